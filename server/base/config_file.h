/** Settings from files: one of many, and files that hold one value each. */
#ifndef VOR_SERVER_BASE_CONFIG_FILE_H
#define VOR_SERVER_BASE_CONFIG_FILE_H

#include "core/base/status.h"

#include <stddef.h>

/** Bytes of a line, with the NUL. */
enum { VOR_CONFIG_LINE_MAX = 2048 };

/** Where the lines of a file go. */
struct vor_config_lines {
    vor_status (*take)(void *ctx, unsigned line, const char *name, const char *value,
                       struct vor_error *err);
    void (*fault)(void *ctx, const struct vor_error *why);
    void *ctx;
};

/** Reads "name = value" lines; empty ones and those that begin with # or ; are passed over, as are
 *  blanks around names and values. Calls take for each, and fault with what that fails with, or
 *  with what is wrong with a line, "FILE line N: " before its message; then reads on, except behind
 *  a line that is too long.
 *
 *  @param[in] must_exist  0: a file that is not there is an empty one
 *
 *  @retval VOR_E_PARAM the file cannot be read */
VOR_NODISCARD vor_status vor_config_file_read(const char *path, int must_exist,
                                              const struct vor_config_lines *lines,
                                              struct vor_error *err);

/** Puts "FILE line N: " before a message. Returns its status. */
vor_status vor_config_file_blame(struct vor_error *err, const char *path, unsigned line);

/** Reads a file that is a value, but for a newline at its end.
 *
 *  @param[in] variable  that names the file, for messages
 *
 *  @retval VOR_E_PARAM it cannot be read, has size bytes or more, or holds a control byte */
VOR_NODISCARD vor_status vor_config_file_value(char *out, size_t size, const char *variable,
                                               const char *path, struct vor_error *err);

#endif
