/** The command line: the same binary as a local tool and as a client of a remote daemon. A command
 *  for each process of the table, and the others. */
#ifndef VOR_CLI_H
#define VOR_CLI_H

#include "server/cli/options.h"

#include <stdio.h>

/** Runs the command argv[0]. Returns the exit code (server/cli/cli_log.h); VOR_EXIT_USAGE when
 * there is no such command. */
int vor_cli_main(int argc, char **argv);

/** Prints the help of one command. Returns the exit code, as vor_cli_main. */
int vor_cli_help(FILE *out, const char *command);

/** Command number `index`: serve, those that run a process, then the others. Writes it to *out and
 *  returns that; NULL past the last. serve is not run by vor_cli_main. */
const struct vor_command *vor_cli_command(struct vor_command *out, unsigned index);

/* The manual and the completions, which the build has made of the tables (docker/pages). */

/** Prints the page that an option names: "--man" with "1", the commands, or "8", the daemon;
 *  "--completion" with a shell, "bash", "zsh" or "fish". Returns the exit code; VOR_EXIT_USAGE,
 * said in a line, when there is no such page. */
int vor_cli_page(FILE *out, const char *option, const char *name);

#endif
