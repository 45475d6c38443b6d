/** A shared library that is loaded when its functions are needed: the command line starts in a
 * third of the time without those of a daemon and of the engine, and few need a database or a
 * bucket. Thread-safe. */
#ifndef VOR_SERVER_BASE_LIBRARY_H
#define VOR_SERVER_BASE_LIBRARY_H

#include "core/base/status.h"

#include <stdbool.h>
#include <stddef.h>

struct vor_library {
    const char *file;         /**< as in "libpq.so.5" */
    const char *package;      /**< Debian's that has it */
    const char *const *names; /**< of its functions, count of them */
    size_t count;
    void *functions; /**< a struct of as many pointers, which are set in the order of names */
    bool loaded;
};

/** Loads it, unless that has been done. It is never unloaded.
 *
 *  @retval VOR_E_IO it is not installed, or lacks a function */
VOR_NODISCARD vor_status vor_library_load(struct vor_library *library, struct vor_error *err);

#endif
