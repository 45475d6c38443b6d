/** What a command tells its caller: lines on stderr and the exit code. */
#ifndef VOR_CLI_LOG_H
#define VOR_CLI_LOG_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdio.h>

/** Exit codes: identifier, number, what it means for a command, what it means for serve ("": it
 * does not end like that). --help and the manual print this table. */
#define VOR_EXIT_TABLE(X)                                                                          \
    X(OK, 0, "success", "ended by a signal")                                                       \
    X(FAILED, 1, "failed", "it cannot start, --store or --blobs cannot be used, or it failed")     \
    X(USAGE, 2, "a command, an option or a parameter is wrong", "a setting is wrong")              \
    X(REJECTED, 3, "an input is rejected", "")                                                     \
    X(CANCELLED, 4, "cancelled on the daemon, or by SIGTERM", "")                                  \
    X(UNREACHABLE, 5, "the server is unreachable or busy", "")                                     \
    X(IN_USE, 75, "a daemon uses the data folder or the database",                                 \
      "another daemon uses the data folder")                                                       \
    X(INTERRUPTED, 130, "ended by ^C; the best result so far is written, if there is one", "")

enum {
#define VOR_EXIT_ENUM(id, code, command, serve) VOR_EXIT_##id = (code),
    VOR_EXIT_TABLE(VOR_EXIT_ENUM)
#undef VOR_EXIT_ENUM
};

/** Bytes of the control character that a text begins with, which would break a line or a terminal;
 *  0 for any other: ASCII's, and those of U+0080 to U+009F in UTF-8. */
size_t vor_cli_control(const char *text);

/** Prints a text without its control characters, each of which becomes a ?. */
void vor_cli_put(FILE *out, const char *text);

/** Prints "voronoid: subject: message" on stderr, in one line whatever they hold; subject may be
 *  NULL. */
void vor_cli_say(const char *subject, const char *message);

/** The same on a line that an answer ends. */
void vor_cli_ask(const char *subject, const char *question);

/** Says err and returns its exit code. */
int vor_cli_fail(const char *subject, const struct vor_error *err);

/** Exit code of a command that a signal has cancelled (server/cli/interrupt.h). */
int vor_cli_interrupted(void);

/** Exit code of an HTTP status; type is the problem's (NULL or "" when not known). */
int vor_cli_exit_code(int http, const char *type);

#endif
