/** Commands, and the table of the options that they take. */
#ifndef VOR_CLI_COMMAND_H
#define VOR_CLI_COMMAND_H

#include "core/spec.h"
#include "server/base/option.h"

/** What a command does, as far as its options and operands follow from it. */
enum {
    VOR_COMMAND_RUNS = 1,     /**< runs a process on files and writes what comes of it */
    VOR_COMMAND_REMOTE = 2,   /**< that a daemon can run too */
    VOR_COMMAND_ASKS = 4,     /**< asks a daemon something */
    VOR_COMMAND_SUBMITS = 8,  /**< hands files to a daemon */
    VOR_COMMAND_JOBS = 16,    /**< its operands are jobs */
    VOR_COMMAND_LISTS = 32,   /**< lists jobs */
    VOR_COMMAND_FETCHES = 64, /**< writes results of jobs */
    VOR_COMMAND_KEYS = 128,   /**< makes keys */
    VOR_COMMAND_MOVES = 256,  /**< moves what a daemon has stored */
    VOR_COMMAND_FRAMES = 512, /**< its operands are frames of a sequence */
    VOR_COMMAND_SERVES = 1024 /**< the daemon: its options are the settings */
};

#define VOR_COMMAND_TELLS (VOR_COMMAND_RUNS | VOR_COMMAND_SUBMITS | VOR_COMMAND_JOBS)

/** Options besides inputs, parameters and settings: identifier, name, letter (0: none), type, unit,
 *  min, max, default, environment variable, commands that take it (any of what they do), sentence.
 *  An option wins over its variable. No command takes two of the same name or letter. */
#define VOR_OPTION_TABLE(X)                                                                        \
    X(OUTPUT, "output", 'o', TEXT, "OUT", 0, 0, "", "", VOR_COMMAND_RUNS,                          \
      "File for the result, or - for stdout. If OUT is a folder (DIR/), each result is written "   \
      "there under the name of its input. inspect and measure write to stdout by default")         \
    X(INTO, "output", 'o', TEXT, "OUT", 0, 0, "", "", VOR_COMMAND_FETCHES,                         \
      "File for one result, or - for stdout. If OUT is a folder (DIR/), all results are written "  \
      "there. For example, the results of a job named bunny.ply are written to "                   \
      "bunny.resample.ply and bunny.report.json. Default: ./")                                     \
    X(FORCE, "force", 'f', FLAG, "", 0, 1, "", "", VOR_COMMAND_RUNS | VOR_COMMAND_FETCHES,         \
      "Overwrite existing files, but never an input")                                              \
    X(RESULT, "result", 0, TEXT, "NAME", 0, 0, "", "", VOR_COMMAND_FETCHES,                        \
      "Name of the result to fetch, such as cloud or report. Default: the main result if "         \
      "--output is a file, all results if --output is a folder")                                   \
    X(LIMIT, "limit", 0, COUNT_OF, "jobs", 1, 10000, "20", "", VOR_COMMAND_LISTS,                  \
      "Number of jobs to list")                                                                    \
    X(STATUS, "status", 0, TEXT, "LIST", 0, 0, "", "", VOR_COMMAND_LISTS,                          \
      "List only jobs with these statuses, separated by commas: accepted, running, successful, "   \
      "failed, dismissed")                                                                         \
    X(SERVER, "server", 0, TEXT, "URL", 0, 0, "", "VORONOID_SERVER",                               \
      VOR_COMMAND_REMOTE | VOR_COMMAND_ASKS,                                                       \
      "URL of the daemon to use. Without this option, processes such as resample run on this "     \
      "machine, without a daemon; other commands connect to the address in VORONOID_LISTEN or "    \
      "to http://127.0.0.1:8080")                                                                  \
    X(API_KEY_FILE, "api-key-file", 0, TEXT, "FILE", 0, 0, "", "VORONOID_KEY_FILE",                \
      VOR_COMMAND_REMOTE | VOR_COMMAND_ASKS,                                                       \
      "File with the API key for the daemon in its first line. Default: the key in VORONOID_KEY")  \
    X(SCOPES, "scopes", 0, TEXT, "LIST", 0, 0, "", "", VOR_COMMAND_KEYS,                           \
      "Scopes of the key, separated by commas: read, submit, admin. Default: submit,read")         \
    X(QUOTAS, "quotas", 0, TEXT, "LIST", 0, 0, "", "", VOR_COMMAND_KEYS,                           \
      "Quotas of the key, separated by commas: jobs=N, at most N jobs that wait or run (default "  \
      "16); rate=N, at most N jobs started per second (default 10); bytes=N, at most N bytes of "  \
      "stored inputs and results; points=N, at most N points in an input")                         \
    X(STORE, "store", 0, TEXT, "SCHEME:PLACE", 0, 0, "", "VORONOID_STORE", VOR_COMMAND_MOVES,      \
      "Database that the jobs are moved to, written like the setting --store of voronoid serve: "  \
      "postgresql://USER@HOST/DATABASE")                                                           \
    X(BLOBS, "blobs", 0, TEXT, "SCHEME:PLACE", 0, 0, "", "VORONOID_BLOBS", VOR_COMMAND_MOVES,      \
      "Destination of the files, written like the setting --blobs of voronoid serve: "             \
      "s3:https://HOST/BUCKET/PREFIX or postgresql://USER@HOST/DATABASE")                          \
    X(NAME, "name", 0, TEXT, "TEXT", 0, 0, "", "", VOR_COMMAND_REMOTE | VOR_COMMAND_SUBMITS,       \
      "Name of the job on the daemon. Default: the name of the input's file")                      \
    X(PRESET, "preset", 0, TEXT, "NAME", 0, 0, "", "", VOR_COMMAND_RUNS | VOR_COMMAND_SUBMITS,     \
      "Use the values of a preset listed below; other options override them")                      \
    X(THREADS, "threads", 0, COUNT_OF, "threads", 0, 256, "0", "VORONOID_THREADS",                 \
      VOR_COMMAND_RUNS,                                                                            \
      "Number of threads for computations on this machine. 0: one thread per core")                \
    X(JSON, "json", 0, FLAG, "", 0, 1, "", "", VOR_COMMAND_TELLS,                                  \
      "Print JSON, one object per line: either one object for each job or file, or one for each "  \
      "progress record and a last one for the report. The objects go to stdout, or to stderr if "  \
      "the result goes to stdout. inspect prints a single document")                               \
    X(QUIET, "quiet", 'q', FLAG, "", 0, 1, "", "", VOR_COMMAND_TELLS,                              \
      "Print no progress and no summary. The commands jobs and submit print only IDs")             \
    X(HELP, "help", 'h', FLAG, "", 0, 1, "", "", ~0u, "Print this help")

enum vor_option {
#define VOR_OPTION_ENUM(id, ...) VOR_OPTION_##id,
    VOR_OPTION_TABLE(VOR_OPTION_ENUM)
#undef VOR_OPTION_ENUM
        VOR_OPTION_COUNT
};

const struct vor_option_row *vor_option_info(enum vor_option option);

struct vor_cli;

/** A command. One that runs or submits a process takes files for operands, the process's first
 *  input; each further input is an option --INPUT FILE, its parameters are options. */
struct vor_command {
    const char *name, *title, *sentence;
    unsigned does;                          /**< VOR_COMMAND_... */
    const char *operands;                   /**< as the help shows them: " IN..."; "" for none */
    int least, most;                        /**< operands */
    const struct vor_process_info *process; /**< NULL when it has none */
    int (*run)(const struct vor_cli *cli);  /**< returns an exit code */
};

/** True when the command takes the option. */
int vor_command_takes(const struct vor_command *command, enum vor_option option);

/** Option number `index` of those that the command takes, inputs and parameters aside; NULL past
 * the last. */
const struct vor_option_row *vor_command_option(const struct vor_command *command, unsigned index);

#endif
