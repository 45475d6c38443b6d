/** What stands on the command line of a command: its operands, its options and the parameters of
 *  its process, read by the tables with getopt_long. */
#ifndef VOR_CLI_OPTIONS_H
#define VOR_CLI_OPTIONS_H

#include "core/base/status.h"
#include "core/spec.h"
#include "server/cli/command.h"

#include <limits.h>

struct vor_attribute_names;

/** A command with its options. Strings are argv's or the environment's. */
struct vor_cli {
    const struct vor_command *command;
    char **operands; /**< argv's, moved to its front */
    int operand_count;
    const char *input[VOR_INPUTS_MAX];    /**< files, in the order of the process's inputs, or NULL;
                                               the first is the first operand */
    const char *option[VOR_OPTION_COUNT]; /**< text, "" for a flag that is there, or NULL */
    char folder[PATH_MAX]; /**< the output, if it is a folder's name without a slash at its end */
    double number[VOR_OPTION_COUNT];        /**< of those that are counts, or their default */
    unsigned threads;                       /**< resolved: 1 .. VOR_THREADS_MAX */
    struct vor_spec spec;                   /**< of a process; checked, with its inputs */
    int given[VOR_PARAMETER_COUNT];         /**< the parameters of spec that were named */
    const struct vor_attribute_names *keep; /**< attributes of the input to be kept; NULL: all */
};

/** Reads argv[1 .. argc - 1] and the environment; argv[0] is the command's name. Moves operands to
 *  the front of argv. An unambiguous beginning of a long name stands for it. One thread at a time:
 *  getopt_long has globals.
 *
 *  @retval VOR_E_PARAM unknown or ambiguous option, value missing or wrong, input missing, output
 *                      missing, too few or too many operands; *out is then unset but for
 *                      option[VOR_OPTION_HELP]. With --help nothing else is asked for. */
VOR_NODISCARD vor_status vor_cli_read(struct vor_cli *out, const struct vor_command *command,
                                      int argc, char **argv, struct vor_error *err);

/** True when the results go into a folder: the output's name ends with a slash, which that of an
 *  existing folder has got. */
int vor_cli_into_folder(const struct vor_cli *cli);

/** Refuses a cloud in a file whose name promises a format that is not written, unless the request
 *  names the format.
 *
 *  @retval VOR_E_PARAM the message names the suffix and those that are written */
VOR_NODISCARD vor_status vor_cli_check_suffix(const struct vor_cli *cli, const char *path,
                                              struct vor_error *err);

#endif
