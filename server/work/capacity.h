/** What jobs take of the daemon, and whether there is room for one more: places in the queue, bytes
 *  of decoded inputs that wait, memory of what runs. A job books a place while its inputs are
 *  decoded, waits, runs, and waits again or is over: each step is counted here. What a principal
 *  may have is counted by the store (struct vor_ledger). vor_worker_room, _book, _unbook and _load
 *  are in worker.h. */
#ifndef VOR_SERVER_WORK_CAPACITY_H
#define VOR_SERVER_WORK_CAPACITY_H

#include "server/work/live.h"

/** A former life of the daemon has left so much that waits. */
void vor_capacity_begin(struct vor_worker *worker, const struct vor_waiting *waiting);

/** Makes the row of a job durable that has booked a place, if its inputs still fit into the queue
 *  and its principal may have it; it then waits.
 *
 *  @retval VOR_DONE
 *  @retval VOR_FULL, VOR_CROWDED, VOR_OVER_BYTES, VOR_FAILED  it keeps the place that it booked */
VOR_NODISCARD enum vor_job_outcome vor_capacity_insert(struct vor_worker *worker,
                                                       struct vor_job_view *row,
                                                       struct vor_ledger *ledger,
                                                       struct vor_error *err);

/** A row waits from now on (1), or does no longer (-1); tells the runners. */
void vor_capacity_wait(struct vor_worker *worker, const struct vor_job_view *row, int by);

/** What may be claimed beside what runs; false when nothing may. */
VOR_NODISCARD int vor_capacity_claim(struct vor_worker *worker, struct vor_claim *claim);

/** A row that was claimed runs from now on, or does no longer; the mutex is held. */
void vor_capacity_run(struct vor_worker *worker, const struct vor_job_view *row);
void vor_capacity_leave(struct vor_worker *worker, const struct vor_job_view *row);

#endif
