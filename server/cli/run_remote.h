/** Commands that have a daemon run a process. */
#ifndef VOR_CLI_RUN_REMOTE_H
#define VOR_CLI_RUN_REMOTE_H

#include "server/cli/options.h"

/** Sends the cloud to the daemon of --server, follows the job and fetches its main output; ^C
 *  dismisses the job. Returns the exit code. */
int vor_cli_run_remote(const struct vor_cli *cli);

/** Hands each input to the daemon as a job and prints the jobs' IDs, a line each. Waits for none.
 *  Returns the exit code. */
int vor_cli_submit(const struct vor_cli *cli);

#endif
