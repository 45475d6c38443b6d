/** The manual and the completions, which the build has made of the tables (docker/pages). */
#ifndef VOR_CLI_PAGES_H
#define VOR_CLI_PAGES_H

#include <stdio.h>

/** Prints the page that an option names: "--man" with "1", the commands, or "8", the daemon;
 *  "--completion" with a shell, "bash", "zsh" or "fish". Returns the exit code; VOR_EXIT_USAGE,
 * said in a line, when there is no such page. */
int vor_cli_page(FILE *out, const char *option, const char *name);

#endif
