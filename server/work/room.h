/** Room on the disk: looking after the reserve, waiting for it, and saying that a disk has failed.
 *  vor_worker_ready is in worker.h. */
#ifndef VOR_SERVER_WORK_ROOM_H
#define VOR_SERVER_WORK_ROOM_H

#include "server/work/live.h"

/** What the sweeper's thread does twice a second: makes the reserve again once there is room, and
 *  tells config.failed, once, that a disk has failed. */
void vor_worker_look(struct vor_worker *worker);

/** Waits `seconds`, and longer while the disk is full. False when the job is to end instead: it was
 *  cancelled, or the daemon goes down. */
int vor_worker_wait_room(struct vor_worker *worker, struct vor_job *job, double seconds);

/** Drops lost bytes that are too old or too many; shift_ms as in struct vor_lost_bounds. */
void vor_worker_trim_lost(struct vor_worker *worker, int64_t shift_ms);

#endif
