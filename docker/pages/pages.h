/** What the build makes of the tables of commands, options and settings, and embeds in the binary
 *  (server/cli/cli.h): the manual and the completions. */
#ifndef VOR_PAGES_H
#define VOR_PAGES_H

#include <stdio.h>

/** Prints the part of a completion that is made of the tables, for "bash", "zsh" or "fish"; or the
 *  manual's section "1", the commands, or "8", the daemon. Returns 0, or -1 when memory ran out or
 *  there is no such page. */
int vor_page_completion(FILE *out, const char *shell);
int vor_page_manual(FILE *out, const char *section);

#endif
