/** Which daemon a command asks. */
#ifndef VOR_CLI_SERVER_H
#define VOR_CLI_SERVER_H

#include "server/cli/options.h"
#include "server/cli/remote.h"

/** Writes the URL of the daemon without a slash at its end: that of --server or its variable, else
 *  of the daemon that VORONOID_LISTEN has listen on this machine (an address that stands for all of
 *  them is asked at its loopback one), else http://127.0.0.1:8080.
 *
 *  @retval VOR_E_PARAM the URL is too long, or VORONOID_LISTEN names no port that can be asked */
VOR_NODISCARD vor_status vor_cli_server(char out[VOR_REMOTE_URL_MAX], const struct vor_cli *cli,
                                        struct vor_error *err);

#endif
