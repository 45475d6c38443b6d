/** voronoid fetch: results of jobs, as files. */
#ifndef VOR_CLI_FETCH_H
#define VOR_CLI_FETCH_H

#include "server/cli/options.h"

/** Writes results of each job where -o says: the main one, or that of --result, into a file; all of
 *  them, or that one, into a folder, as JOB-RESULT.SUFFIX. Returns the exit code. */
int vor_cli_fetch(const struct vor_cli *cli);

#endif
