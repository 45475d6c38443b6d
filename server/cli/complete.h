/** Completion for shells, made of the tables. */
#ifndef VOR_CLI_COMPLETE_H
#define VOR_CLI_COMPLETE_H

#include <stdio.h>

/** Prints the script that completes voronoid's command line in a shell, "bash", "zsh" or "fish".
 * Returns the exit code; VOR_EXIT_USAGE, said in a line, for another shell. */
int vor_cli_complete(FILE *out, const char *shell);

#endif
