/** A document as lines for people. */
#ifndef VOR_CLI_LINES_H
#define VOR_CLI_LINES_H

#include "proto/text.h"
#include "server/cli/options.h"

/** Whether the command's document is printed as lines: one that is meant for people (lines.c), goes
 *  to stdout, and is not asked for as JSON. */
int vor_lines_wanted(const struct vor_cli *cli);

/** Turns the command's document into lines: name, value and unit of each of its members that the
 *  JSON has, in the order of their table.
 *
 *  @param[in,out] text  JSON as vor_json_document writes it; unchanged on failure
 *
 *  @retval VOR_E_REQUEST it is no JSON
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_lines_from_json(struct vor_text *text, const struct vor_cli *cli,
                                             struct vor_error *err);

#endif
