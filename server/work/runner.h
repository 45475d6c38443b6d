/** One run of one job: from its claim to its last row. */
#ifndef VOR_SERVER_WORK_RUNNER_H
#define VOR_SERVER_WORK_RUNNER_H

#include "server/work/live.h"

/** Runs and ends the job of a runner; row is what the claim returned. Returns when it is over, or
 *  waits again: its process has ended, or the daemon goes down. */
void vor_worker_run(struct vor_runner *runner, const struct vor_job_view *row);

#endif
