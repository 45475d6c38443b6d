/** The names and letters of a command, as getopt_long wants them. */
#ifndef VOR_CLI_MENU_H
#define VOR_CLI_MENU_H

#include "server/base/reference.h"
#include "server/cli/command.h"

#include <getopt.h>

/** What getopt_long returns for a long option is its row behind one of these, above every letter.
 */
enum {
    VOR_LONG_OPTION = 256,
    VOR_LONG_INPUT = VOR_LONG_OPTION + VOR_OPTION_COUNT,
    VOR_LONG_PARAMETER = VOR_LONG_INPUT + VOR_INPUTS_MAX,
    VOR_LONGS_MAX = VOR_OPTION_COUNT + VOR_INPUTS_MAX + 2 * VOR_PARAMETER_COUNT
};

/** A parameter whose name has capitals has two rows, one behind the other: "max-aspect",
 *  "maxAspect". */
struct vor_menu {
    struct option longs[VOR_LONGS_MAX + 1]; /**< the last one is zero */
    int count;
    char parameters[VOR_PARAMETER_COUNT][VOR_REFERENCE_NAME_SIZE];
    char letters[2 * VOR_OPTION_COUNT + 8];
};

/** Makes the menu of a command. */
void vor_menu_make(struct vor_menu *menu, const struct vor_command *command);

/** The parameter of a name, with capitals or with dashes; VOR_PARAMETER_COUNT when there is none.
 */
enum vor_parameter vor_menu_parameter(const char *name);

#endif
