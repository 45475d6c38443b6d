/** Whether a command may write a file that is there already. */
#ifndef VOR_CLI_OVERWRITE_H
#define VOR_CLI_OVERWRITE_H

#include "server/cli/options.h"

/** Checks an output before it is opened. An input is never written, under whatever name. Any other
 *  regular file needs --force, or a yes: asked for on stderr if that and stdin are terminals and
 *  stdin is no input. Pipes and devices are written as they are.
 *
 *  @param[out] replace  set if a file is there and may be replaced; else 0
 *  @retval VOR_E_PARAM  it is an input, or exists and may not be replaced */
VOR_NODISCARD vor_status vor_overwrite_check(const struct vor_cli *cli, const char *path,
                                             int *replace, struct vor_error *err);

#endif
