/** Topics of the help on a terminal. */
#ifndef VOR_CLI_TOPIC_H
#define VOR_CLI_TOPIC_H

#include <stdio.h>

/** Prints the topic of that name. Returns the exit code; -1 when there is no such topic. */
int vor_cli_topic(FILE *out, const char *name);

/** Prints the first lines of code in the topics that call a command, such as "submit resample";
 *  those of its first word where there are none. */
void vor_cli_examples(FILE *out, const char *command);

/** Prints a line for each topic. */
void vor_cli_topics(FILE *out);

#endif
