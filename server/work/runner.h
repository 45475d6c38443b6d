/** One run of one job: from the claim to its last row. */
#ifndef VOR_SERVER_WORK_RUNNER_H
#define VOR_SERVER_WORK_RUNNER_H

#include "server/work/live.h"

/** Claims, runs and ends a job that was popped from the queue. Returns when it is over, or was
 *  given back because the daemon goes down.
 *
 *  @return true when the run came to nothing, as its process ended, and the job, which is accepted
 *          again, is to be queued (vor_worker_requeue) */
VOR_NODISCARD int vor_worker_run(struct vor_worker *worker, struct vor_job *job);

#endif
