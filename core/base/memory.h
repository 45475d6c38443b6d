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

void vor_memory_init(struct vor_memory *memory, size_t cap);

/** count * size bytes, checked for overflow and against the cap; NULL on failure. count or size 0
 *  yields a valid pointer. The memory is 64-byte aligned; calloc zeroes it. */
VOR_NODISCARD void *vor_malloc(struct vor_memory *memory, size_t count, size_t size);
VOR_NODISCARD void *vor_calloc(struct vor_memory *memory, size_t count, size_t size);

/** Grows or shrinks to count * size bytes; p may be NULL; on failure NULL and p stays valid. */
VOR_NODISCARD void *vor_realloc(struct vor_memory *memory, void *p, size_t count, size_t size);

/** p may be NULL. */
void vor_free(struct vor_memory *memory, void *p);

/** Books bytes that a library allocates by itself against the cap. False when they do not fit, and
 *  then nothing is booked. */
VOR_NODISCARD int vor_memory_charge(struct vor_memory *memory, size_t bytes);
void vor_memory_release(struct vor_memory *memory, size_t bytes);

#endif
