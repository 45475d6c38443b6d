/** Keys on the command line: one is made for a daemon, or read for a call to one. */
#ifndef VOR_CLI_KEY_H
#define VOR_CLI_KEY_H

#include "server/base/keys.h"
#include "server/cli/options.h"

/** voronoid key NAME: prints a new key on stderr, this once, and its line for --api-keys on stdout.
 *  Returns an exit code. */
int vor_cli_key(const struct vor_cli *cli);

/** The key to send: the first line of --api-key-file, else VORONOID_KEY; "" when there is neither.
 *  It never stands on a command line, which every user of the machine may read.
 *
 *  @retval VOR_E_PARAM it is longer than VOR_KEY_SENT_MAX, or holds a blank or a control character;
 *                      the message does not show it
 *  @retval VOR_E_IO    the file cannot be read */
VOR_NODISCARD vor_status vor_cli_key_read(char out[VOR_KEY_SENT_MAX + 1], const struct vor_cli *cli,
                                          struct vor_error *err);

#endif
