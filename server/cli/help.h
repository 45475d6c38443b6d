/** Help, made of the tables. */
#ifndef VOR_CLI_HELP_H
#define VOR_CLI_HELP_H

#include "server/cli/options.h"

#include <stdio.h>

/** How a command is called, its options, and the parameters of its process by groups. */
void vor_help_command(FILE *out, const struct vor_command *command);

/** The beginning and the end of the list of commands, and a line of it. */
void vor_help_begin(FILE *out);
void vor_help_line(FILE *out, const char *name, const char *title);
void vor_help_end(FILE *out);

#endif
