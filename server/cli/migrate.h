/** voronoid migrate: what a daemon has in its folder goes to another database and another storage
 * of files. */
#ifndef VOR_CLI_MIGRATE_H
#define VOR_CLI_MIGRATE_H

#include "server/cli/options.h"

/** Copies DATA/jobs.sqlite and DATA/blobs to --store and --blobs; returns an exit code. */
int vor_cli_migrate(const struct vor_cli *cli);

#endif
