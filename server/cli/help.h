/** Help, made of the tables. */
#ifndef VOR_CLI_HELP_H
#define VOR_CLI_HELP_H

#include "server/cli/options.h"

#include <stdio.h>

/** Sentences of the help and of the manual. */
#define VOR_HELP_COUNTS "A whole number may end in k, for thousands, or M, for millions: 10k, 1.5M."
#define VOR_HELP_JOBS                                                                              \
    "JOB is the ID of a job, or the beginning of its ID if no other ID begins in the same "        \
    "way."
#define VOR_HELP_WORDS                                                                             \
    "Write options as --name VALUE or --name=VALUE. The name of an option may be shortened as "    \
    "long as it is unambiguous. Arguments after -- are not options."

/** How a command is called, its options, and the parameters of its process by groups. */
void vor_help_command(FILE *out, const struct vor_command *command);

/** What voronoid is and how to begin, for who typed nothing else. */
void vor_help_brief(FILE *out);

/** The lists of commands, which `at` has (vor_cli_command), topics and exit codes. */
void vor_help_overview(FILE *out,
                       const struct vor_command *(*at)(struct vor_command *out, unsigned index));

/** Prints the topic of that name. Returns the exit code; -1 when there is no such topic. */
int vor_cli_topic(FILE *out, const char *name);

#endif
