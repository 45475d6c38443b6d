/** voronoid health: whether a daemon takes jobs; for scripts and container probes. */
#ifndef VOR_CLI_HEALTH_H
#define VOR_CLI_HEALTH_H

#include "server/cli/options.h"

/** Asks the daemon (server/cli/server.h) and prints one line. Returns the exit code. */
int vor_cli_health(const struct vor_cli *cli);

#endif
