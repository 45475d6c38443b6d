/** What stands on the command line of a command: its inputs, its options and the parameters of its
 *  process, read by the tables. */
#ifndef VOR_CLI_OPTIONS_H
#define VOR_CLI_OPTIONS_H

#include "core/base/status.h"
#include "core/spec.h"

/** What a command does, as far as its options follow from it. */
enum {
    VOR_COMMAND_RUNS = 1,   /**< runs a process */
    VOR_COMMAND_REMOTE = 2, /**< that a daemon can run too */
    VOR_COMMAND_ASKS = 4    /**< asks a daemon something */
};

/** Options besides inputs and parameters: identifier, name, letter (0: none), what follows ("" for
 *  nothing), environment variable, commands that take it (any of what they do), sentence. An option
 *  wins over its variable. */
#define VOR_OPTION_TABLE(X)                                                                        \
    X(OUTPUT, "output", 'o', "OUT", "", VOR_COMMAND_RUNS,                                          \
      "Where the result goes; - is stdout, and the default of a document")                         \
    X(SERVER, "server", 0, "URL", "VORONOID_SERVER", VOR_COMMAND_REMOTE | VOR_COMMAND_ASKS,        \
      "The daemon that does the work (else it is done here) or is asked (health)")                 \
    X(NAME, "name", 0, "TEXT", "", VOR_COMMAND_REMOTE,                                             \
      "What the job is called in the daemon's lists, with --server")                               \
    X(THREADS, "threads", 0, "N", "VORONOID_THREADS", VOR_COMMAND_RUNS,                            \
      "Threads, 0 to 256, when the work is done here; 0, the default, is one for each core")       \
    X(JSON, "json", 0, "", "", VOR_COMMAND_RUNS,                                                   \
      "One JSON object a line on stdout (on stderr when the result goes there): records, then "    \
      "the report; of inspect, its document instead of lines")                                     \
    X(QUIET, "quiet", 'q', "", "", VOR_COMMAND_RUNS, "No progress and no summary")                 \
    X(HELP, "help", 'h', "", "", ~0u, "Print this")

enum vor_option {
#define VOR_OPTION_ENUM(id, name, letter, value, variable, commands, sentence) VOR_OPTION_##id,
    VOR_OPTION_TABLE(VOR_OPTION_ENUM)
#undef VOR_OPTION_ENUM
        VOR_OPTION_COUNT
};

/** One row of the table of options. */
struct vor_option_info {
    const char *name, *value, *variable, *sentence;
    unsigned commands;
    char letter;
};

const struct vor_option_info *vor_option_info(enum vor_option option);

struct vor_cli;

/** A command. One that runs a process has its id for a name: its first input is the operand, each
 *  further one an option --INPUT FILE, its parameters are options. */
struct vor_command {
    const char *name, *title, *sentence;
    unsigned does;                          /**< VOR_COMMAND_... */
    const struct vor_process_info *process; /**< NULL when it runs none */
    int (*run)(const struct vor_cli *cli);  /**< returns an exit code */
};

/** A command with its options. Strings are argv's or the environment's. */
struct vor_cli {
    const struct vor_command *command;
    const char *input[VOR_INPUTS_MAX]; /**< files, in the order of the process's inputs, or NULL */
    const char *option[VOR_OPTION_COUNT]; /**< text, "" for a flag that is there, or NULL */
    unsigned threads;                     /**< resolved: 1 .. VOR_THREADS_MAX */
    struct vor_spec spec;                 /**< of a process; checked, with its inputs */
    int given[VOR_PARAMETER_COUNT];       /**< the parameters of spec that were named */
};

/** Reads argv[1 .. argc - 1] and the environment; argv[0] is the command's name.
 *
 *  @retval VOR_E_PARAM unknown option, value missing or wrong, input missing, output missing; *out
 *                      is then unset but for option[VOR_OPTION_HELP]. With --help nothing else is
 *                      asked for. */
VOR_NODISCARD vor_status vor_cli_read(struct vor_cli *out, const struct vor_command *command,
                                      int argc, char **argv, struct vor_error *err);

#endif
