/** Small files that stand in a table of the store and not among the files of --blobs: what is put
 *  there is durable with the next durable change of a row, so that a job of small bytes makes,
 * names, syncs and deletes no file. The store has the functions, blobs call them. */
#ifndef VOR_SERVER_BASE_SMALL_FILES_H
#define VOR_SERVER_BASE_SMALL_FILES_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

/** Bytes of such a file at most. */
enum { VOR_SMALL_FILE_MAX = 64 << 10 };

struct vor_small_files {
    void *ctx;
    /** Both say how many bytes were there of that name before; 0 for none. */
    vor_status (*put)(void *ctx, const char *name, const void *bytes, size_t size, uint64_t *was,
                      struct vor_error *err);
    vor_status (*drop)(void *ctx, const char *name, uint64_t *was, struct vor_error *err);
    /** Calls take with the size, 0 where there is none, and unless only that is wanted the bytes.
     */
    vor_status (*get)(void *ctx, const char *name, int only_size,
                      void (*take)(void *of, const void *bytes, size_t size), void *of,
                      struct vor_error *err);
    /** each must not call the store. */
    vor_status (*list)(void *ctx, void (*each)(void *of, const char *name, size_t size), void *of,
                       struct vor_error *err);
};

#endif
