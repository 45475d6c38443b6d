/** A command that runs a process by a daemon. */
#ifndef VOR_CLI_THERE_H
#define VOR_CLI_THERE_H

#include "server/cli/options.h"

/** Sends the cloud to the daemon of --server, follows the job and fetches its main output; ^C
 *  dismisses the job. Returns the exit code. */
int vor_cli_process_there(const struct vor_cli *cli);

#endif
