/** The manual, made of the tables: pages in roff's man macros. */
#ifndef VOR_CLI_MANUAL_H
#define VOR_CLI_MANUAL_H

#include <stdio.h>

/** Prints voronoid(1), the commands, or voronoid(8), the daemon. section is "1" or "8". Returns the
 *  exit code; VOR_EXIT_USAGE, said in a line, when there is no such page. */
int vor_cli_manual(FILE *out, const char *section);

#endif
