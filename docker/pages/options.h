/** What can be completed on a command line, whatever the shell: every option with what may follow
 *  it. */
#ifndef VOR_PAGES_OPTIONS_H
#define VOR_PAGES_OPTIONS_H

#include "server/cli/options.h"

/** What stands for the value of an option. */
enum vor_value_kind {
    VOR_VALUE_NONE, /**< it takes none */
    VOR_VALUE_FLAG, /**< it takes one of the words behind a = alone */
    VOR_VALUE_ANY,  /**< what nobody can guess: a number, a URL */
    VOR_VALUE_FILE,
    VOR_VALUE_FOLDER,
    VOR_VALUE_WORD, /**< one of the words */
    VOR_VALUE_LIST  /**< some of them, with commas between */
};

/** Bytes of all words of an option with blanks between, with the NUL. */
#define VOR_VALUE_WORDS_SIZE 512

/** An option as a shell sees it. */
struct vor_page_option {
    const char *name, *sentence;
    char letter;       /**< 0 for none */
    const char *value; /**< how the help names the value */
    enum vor_value_kind kind;
    char words[VOR_VALUE_WORDS_SIZE];
};

/** Calls visit for each option of a command: inputs, options, parameters. */
void vor_page_command(const struct vor_command *command,
                      void (*visit)(void *ctx, const struct vor_page_option *option), void *ctx);

#endif
