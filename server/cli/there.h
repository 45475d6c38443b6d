/** Commands that have a daemon run a process. */
#ifndef VOR_CLI_THERE_H
#define VOR_CLI_THERE_H

#include "server/cli/options.h"

/** Sends the cloud to the daemon of --server, follows the job and fetches its main output; ^C
 *  dismisses the job. Returns the exit code. */
int vor_cli_process_there(const struct vor_cli *cli);

/** Hands each input to the daemon as a job and prints the jobs' IDs, a line each. Waits for none.
 *  Returns the exit code. */
int vor_cli_submit(const struct vor_cli *cli);

#endif
