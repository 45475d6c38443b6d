/** The jobs of a daemon: voronoid jobs, wait, cancel and stop. */
#ifndef VOR_CLI_JOBS_H
#define VOR_CLI_JOBS_H

#include "server/cli/options.h"

/** Lists the jobs named, else the newest of the daemon, a line each. Returns the exit code. */
int vor_cli_jobs(const struct vor_cli *cli);

/** Shows the progress of each job until it is over, then what came of it. A signal ends the waiting
 *  and leaves the job alone. Returns the exit code that running the job here would have. */
int vor_cli_wait(const struct vor_cli *cli);

/** Dismisses each job. One that is over keeps its results, and counts as a failure. Returns the
 * exit code. */
int vor_cli_cancel(const struct vor_cli *cli);

/** Stops each running job with the best so far as its result. One that is over counts as a failure.
 *  Returns the exit code. */
int vor_cli_stop(const struct vor_cli *cli);

#endif
