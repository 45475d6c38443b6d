/** One capped allocator per job: a hostile cloud meets an error, not the OOM killer. */
#ifndef VOR_BASE_MEMORY_H
#define VOR_BASE_MEMORY_H

#include "core/base/status.h"

#include <stdatomic.h>
#include <stddef.h>

/** Counts and caps what is allocated through it. Initialise with vor_memory_init; no clean-up is
 *  needed beyond freeing what was allocated. Thread-safe. */
struct vor_memory {
    atomic_size_t used;
    atomic_size_t peak;
    atomic_size_t calls; /**< allocations asked for so far */
    size_t cap;          /**< bytes, SIZE_MAX for none */
    size_t fail_at;      /**< tests: the fail_at-th call fails; 0 = never */
};

/** Starts counting at 0 with a cap in bytes, SIZE_MAX for none. */
void vor_memory_init(struct vor_memory *memory, size_t cap);

/** Allocates count * size bytes, checked for overflow and against the cap. Returns NULL on failure,
 *  a valid pointer also for 0 bytes. The memory is aligned to 64 bytes; calloc zeroes it. Free it
 *  with vor_free. Thread-safe. */
VOR_NODISCARD void *vor_malloc(struct vor_memory *memory, size_t count, size_t size);
VOR_NODISCARD void *vor_calloc(struct vor_memory *memory, size_t count, size_t size);

/** Grows or shrinks to count * size bytes; p may be NULL; on failure NULL and p stays valid. */
VOR_NODISCARD void *vor_realloc(struct vor_memory *memory, void *p, size_t count, size_t size);

/** Frees memory from the functions above; p may be NULL. Thread-safe. */
void vor_free(struct vor_memory *memory, void *p);

/** The same for several. */
#define VOR_FREE_ALL(memory, ...)                                                                  \
    vor_free_each(memory, (void *const[]){__VA_ARGS__},                                            \
                  sizeof((void *const[]){__VA_ARGS__}) / sizeof(void *))
void vor_free_each(struct vor_memory *memory, void *const *p, size_t count);

/** An array to be: where its pointer is put, how many rows it has, of how many bytes each. */
struct vor_array {
    void *to; /**< a pointer to an object */
    size_t count, size;
    int zeroed;
};
#define VOR_ARRAY(p, rows, width)                                                                  \
    {                                                                                              \
        &(p), rows, (width) * sizeof *(p), 0                                                       \
    }
#define VOR_ZEROED(p, rows, width)                                                                 \
    {                                                                                              \
        &(p), rows, (width) * sizeof *(p), 1                                                       \
    }

/** Allocates several, as vor_malloc and vor_calloc do. From the first that fails on they are NULL;
 *  those before are the caller's to free. The error names n points. */
#define VOR_MAKE_ALL(memory, err, n, ...)                                                          \
    vor_make_each(memory, n, (const struct vor_array[]){__VA_ARGS__},                              \
                  sizeof((const struct vor_array[]){__VA_ARGS__}) / sizeof(struct vor_array), err)
VOR_NODISCARD vor_status vor_make_each(struct vor_memory *memory, size_t n,
                                       const struct vor_array *array, size_t count,
                                       struct vor_error *err);

/** Counts bytes that a library allocates by itself against the cap. Returns false, and counts
 *  nothing, when they do not fit. vor_memory_release takes them off the count again. Thread-safe.
 */
VOR_NODISCARD int vor_memory_charge(struct vor_memory *memory, size_t bytes);
void vor_memory_release(struct vor_memory *memory, size_t bytes);

#endif
