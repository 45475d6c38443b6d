/** What a command tells its caller: lines on stderr and the exit code. */
#ifndef VOR_CLI_SAY_H
#define VOR_CLI_SAY_H

#include "core/base/status.h"

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

/** Prints "voronoid: subject: message" on stderr, in one line whatever they hold; subject may be
 *  NULL. */
void vor_cli_say(const char *subject, const char *message);

/** Says err and returns its exit code. */
int vor_cli_fail(const char *subject, const struct vor_error *err);

/** Exit code of an HTTP status; type is the problem's (NULL or "" when not known). */
int vor_cli_exit_code(int http, const char *type);

#endif
