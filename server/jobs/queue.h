/** The bounded list of jobs that wait for a runner. Those of one tenant (vor_job_tenant) leave in
 * the order of acceptance; tenants take turns, a job each a round. A tenant whose first job comes
 * while others have many waiting has its turn in the round that goes on, so that it waits for no
 * more of theirs than run at that moment. Within a round, the job that was accepted first leaves
 * first: with one tenant that is the order of acceptance. Thread-safe. */
#ifndef VOR_SERVER_JOBS_QUEUE_H
#define VOR_SERVER_JOBS_QUEUE_H

#include "server/jobs/job.h"

#include <stddef.h>

struct vor_queue;

/** Room for `capacity` (at least 1) jobs; NULL when memory is out. */
struct vor_queue *vor_queue_create(size_t capacity);

/** From here on the next job is handed out once `may` is true of it, and no other before it. `may`
 *  is asked with the queue locked, by a thread that then has the job if it is true: it must be
 * quick and not call the queue. Call vor_queue_look when its answer may have become another. */
void vor_queue_guard(struct vor_queue *queue, int (*may)(void *ctx, struct vor_job *job),
                     void *ctx);
void vor_queue_look(struct vor_queue *queue);

/** Lets go of the jobs that still wait. queue may be NULL; no thread may be in a call. */
void vor_queue_destroy(struct vor_queue *queue);

/** Books a place for a job that is about to be accepted.
 *
 *  @retval VOR_DONE, VOR_FULL, VOR_DRAINING (closed) */
enum vor_job_outcome vor_queue_reserve(struct vor_queue *queue);

/** Gives a booked place back. */
void vor_queue_cancel(struct vor_queue *queue);

/** Puts a job into its booked place by its seq; takes a reference. Never fails; once the queue is
 *  closed, the job waits for the next start of the daemon. */
void vor_queue_push(struct vor_queue *queue, struct vor_job *job, int64_t seq);

/** The same for a job of a former life of the daemon. It needs no booking: every one of them is
 *  taken, however many the queue has room for.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_queue_restore(struct vor_queue *queue, struct vor_job *job,
                                           int64_t seq, struct vor_error *err);

/** Waits for the next job; the caller gets its reference. NULL once the queue is closed. */
struct vor_job *vor_queue_pop(struct vor_queue *queue);

/** Takes a job out, of which the caller holds a reference; false when it does not wait. */
int vor_queue_remove(struct vor_queue *queue, const struct vor_job *job);

/** How many would leave before a job if no other came; -1 when it does not wait. The caller holds a
 *  reference to it. */
long vor_queue_position(struct vor_queue *queue, const struct vor_job *job);

/** When the job that is next was accepted (wall clock, ms); 0 when none waits. */
int64_t vor_queue_oldest(struct vor_queue *queue);

/** Jobs that wait or have a place booked. */
size_t vor_queue_depth(struct vor_queue *queue);
size_t vor_queue_capacity(const struct vor_queue *queue);

/** No job is handed out or booked any more; every vor_queue_pop returns. */
void vor_queue_close(struct vor_queue *queue);

#endif
