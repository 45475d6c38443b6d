/** A command that runs a process in this one. */
#ifndef VOR_CLI_RUN_LOCAL_H
#define VOR_CLI_RUN_LOCAL_H

#include "server/cli/options.h"

/** Reads the clouds, runs the process and writes its main output. Returns the exit code. */
int vor_cli_run_local(const struct vor_cli *cli);

#endif
