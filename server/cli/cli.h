/** The command line: the same binary as a local tool and as a client of a remote daemon. */
#ifndef VOR_CLI_H
#define VOR_CLI_H

#include "core/base/status.h"
#include "core/spec.h"

#include <stdint.h>
#include <stdio.h>

/** Exit codes. */
enum {
    VOR_EXIT_OK = 0,
    VOR_EXIT_FAILED = 1,
    VOR_EXIT_USAGE = 2,        /**< a command, an option or a parameter is wrong */
    VOR_EXIT_REJECTED = 3,     /**< the cloud is */
    VOR_EXIT_CANCELLED = 4,    /**< by somebody else, or a signal but ^C */
    VOR_EXIT_UNREACHABLE = 5,  /**< the server is not there, or busy */
    VOR_EXIT_INTERRUPTED = 130 /**< by ^C */
};

/** Commands: identifier, name, its one operand, sentence. A command with the name of a process runs
 *  it, and takes its parameters. */
#define VOR_COMMAND_TABLE(X)                                                                       \
    X(RESAMPLE, "resample", "IN",                                                                  \
      "Spread exactly the number of points asked for evenly over a cloud's surface")               \
    X(DENOISE, "denoise", "IN",                                                                    \
      "Spread as many points as a cloud has evenly over its surface, without its outliers")        \
    X(UPSAMPLE, "upsample", "IN",                                                                  \
      "Spread four times as many points as a cloud has, or as asked for, over its surface")        \
    X(SIMPLIFY, "simplify", "IN",                                                                  \
      "Spread as few points as asked for evenly over a cloud's surface")                           \
    X(MEASURE, "measure", "IN", "Print how evenly a cloud is spread, as JSON")                     \
    X(HEALTH, "health", "", "Ask whether a daemon is ready")

enum vor_command {
#define VOR_COMMAND_ENUM(id, name, operand, sentence) VOR_COMMAND_##id,
    VOR_COMMAND_TABLE(VOR_COMMAND_ENUM)
#undef VOR_COMMAND_ENUM
        VOR_COMMAND_COUNT
};

/** Options besides the request's parameters: identifier, name, letter (0: none), what follows (""
 *  for nothing), environment variable, commands that take it, sentence. An option wins over its
 *  variable. */
#define VOR_FOR(command) (1u << VOR_COMMAND_##command)
#define VOR_FOR_PROCESSES                                                                          \
    (VOR_FOR(RESAMPLE) | VOR_FOR(DENOISE) | VOR_FOR(UPSAMPLE) | VOR_FOR(SIMPLIFY))
#define VOR_OPTION_TABLE(X)                                                                        \
    X(OUTPUT, "output", 'o', "OUT", "", VOR_FOR_PROCESSES, "Where the result goes; - is stdout")   \
    X(REFERENCE, "reference", 0, "FILE", "", VOR_FOR(MEASURE),                                     \
      "Print the distances to this cloud too")                                                     \
    X(PEAK, "peak", 0, "P", "", VOR_FOR(MEASURE),                                                  \
      "Peak of d1_psnr and d2_psnr, 1e-30 to 1e+30 in the cloud's unit; by default the largest "   \
      "distance of a reference point to its nearest other one")                                    \
    X(SERVER, "server", 0, "URL", "VORONOID_SERVER", VOR_FOR_PROCESSES | VOR_FOR(HEALTH),          \
      "The daemon that does the work (else it is done here) or is asked (health)")                 \
    X(THREADS, "threads", 0, "N", "VORONOID_THREADS", VOR_FOR_PROCESSES | VOR_FOR(MEASURE),        \
      "Threads, 0 to 256, when the work is done here; 0, the default, is one for each core")       \
    X(JSON, "json", 0, "", "", VOR_FOR_PROCESSES,                                                  \
      "One JSON object a line on stdout (on stderr with -o -): records, then the report")          \
    X(QUIET, "quiet", 'q', "", "", VOR_FOR_PROCESSES, "No progress and no summary")                \
    X(HELP, "help", 'h', "", "", ~0u, "Print this")

enum vor_option {
#define VOR_OPTION_ENUM(id, name, letter, value, variable, commands, sentence) VOR_OPTION_##id,
    VOR_OPTION_TABLE(VOR_OPTION_ENUM)
#undef VOR_OPTION_ENUM
        VOR_OPTION_COUNT
};

#define VOR_SERVER_DEFAULT "http://127.0.0.1:8080"

/** A command with its options. Strings are argv's or the environment's. */
struct vor_cli {
    enum vor_command command;
    const char *input;                    /**< the operand; NULL for health */
    const char *option[VOR_OPTION_COUNT]; /**< text, "" for a flag that is there, or NULL */
    unsigned threads;                     /**< resolved: 1 .. VOR_THREADS_MAX */
    double peak;                          /**< measure; VOR_PEAK_MIN .. MAX, 0 if not given */
    struct vor_spec spec;                 /**< of a process; checked */
    int given[VOR_PARAMETER_COUNT];       /**< the parameters of spec that were named */
};

/** Reads argv[1 .. argc - 1] and the environment; argv[0] is the command's name.
 *
 *  @retval VOR_E_PARAM unknown option, value missing or wrong, operand missing, output missing;
 *                      *out is then unset but for option[VOR_OPTION_HELP]. With --help nothing else
 *                      is asked for. */
VOR_NODISCARD vor_status vor_cli_read(struct vor_cli *out, enum vor_command command, int argc,
                                      char **argv, struct vor_error *err);

/** The help of one command, and of the binary; both made of the tables. */
void vor_cli_help(FILE *out, enum vor_command command);
void vor_cli_overview(FILE *out);

/** Runs the command argv[0]. Returns the exit code; VOR_EXIT_USAGE when there is no such command.
 */
int vor_cli_main(int argc, char **argv);

/** Finds a command by name; VOR_COMMAND_COUNT when there is none. */
enum vor_command vor_cli_find(const char *name);

/** Prints "voronoid: subject: message" on stderr, in one line whatever they hold; subject may be
 *  NULL. */
void vor_cli_say(const char *subject, const char *message);

/** Says err and returns its exit code. */
int vor_cli_fail(const char *subject, const struct vor_error *err);

/** Exit code of an HTTP status; type is the problem's (NULL or "" when not known). */
int vor_cli_exit_code(int http, const char *type);

/** The commands. Each returns an exit code. */
int vor_cli_process_here(const struct vor_cli *cli);
int vor_cli_process_there(const struct vor_cli *cli);
int vor_cli_measure(const struct vor_cli *cli);
int vor_cli_health(const struct vor_cli *cli);

/** From here on SIGINT and SIGTERM only leave a note. */
void vor_interrupt_catch(void);

/** The signal that came since, or 0. Cheap; any thread. */
int vor_interrupt_seen(void);

/** Fails as cancelled, and the exit code for it: 130 after ^C, else 4. */
VOR_NODISCARD vor_status vor_interrupt_fail(struct vor_error *err);
int vor_interrupt_exit_code(void);

#endif
