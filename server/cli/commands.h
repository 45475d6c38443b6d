/** What each command does; each returns an exit code (cli_log.h), and says in a line what went
 * wrong. */
#ifndef VOR_CLI_COMMANDS_H
#define VOR_CLI_COMMANDS_H

#include "server/cli/options.h"

/** Reads the clouds, runs the process and writes its main output. Returns the exit code. */
int vor_cli_run_local(const struct vor_cli *cli);

/** Sends the cloud to the daemon of --server, follows the job and fetches its main output; ^C
 *  dismisses the job. Returns the exit code. */
int vor_cli_run_remote(const struct vor_cli *cli);

/** Hands each input to the daemon as a job and prints the jobs' IDs, a line each. Waits for none.
 *  Returns the exit code. */
int vor_cli_submit(const struct vor_cli *cli);

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

/** Writes results of each job where -o says: the main one, or that of --result, into a file; all of
 *  them, or that one, into a folder, as JOB-RESULT.SUFFIX. Returns the exit code. */
int vor_cli_fetch(const struct vor_cli *cli);

/** Asks the daemon (server/cli/server.h) and prints one line. Returns the exit code. */
int vor_cli_health(const struct vor_cli *cli);

/** Copies DATA/jobs.sqlite and DATA/blobs to --store and --blobs; returns an exit code. */
int vor_cli_migrate(const struct vor_cli *cli);

#endif
