#include "core/base/memory.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 };

/* Sits in the ALIGNMENT bytes before what the caller gets. */
struct header {
    size_t bytes;
    void *block; /* what was allocated: the header or, if zeroed, less than ALIGNMENT before it */
};

_Static_assert(sizeof(struct header) <= ALIGNMENT, "the header must fit before the block");

void vor_memory_init(struct vor_memory *memory, size_t cap)
{
    atomic_init(&memory->used, 0);
    atomic_init(&memory->peak, 0);
    atomic_init(&memory->calls, 0);
    memory->cap = cap;
    memory->fail_at = 0;
}

int vor_memory_charge(struct vor_memory *memory, size_t bytes)
{
    size_t used = atomic_load(&memory->used);
    size_t peak;

    do {
        if (bytes > memory->cap || used > memory->cap - bytes)
            return 0;
    } while (!atomic_compare_exchange_weak(&memory->used, &used, used + bytes));
    used += bytes;
    peak = atomic_load(&memory->peak);
    while (peak < used && !atomic_compare_exchange_weak(&memory->peak, &peak, used))
        continue;
    return 1;
}

void vor_memory_release(struct vor_memory *memory, size_t bytes)
{
    size_t before = atomic_fetch_sub(&memory->used, bytes);

    assert(before >= bytes);
    (void)before;
}

static int total_bytes(size_t count, size_t size, size_t *total)
{
    size_t bytes;

    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - 3 * (size_t)ALIGNMENT)
        return 0;
    bytes = (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    *total = bytes + ALIGNMENT;
    return 1;
}

static struct header *header_of(void *p)
{
    return (struct header *)(void *)((char *)p - ALIGNMENT);
}

/* Allocates as vor_malloc, or zeroed. Large zeroed blocks take memory only where they are written
 * to: they are not cleared here, as the system clears them. */
static void *allocate(struct vor_memory *memory, size_t count, size_t size, int zeroed)
{
    size_t call = atomic_fetch_add(&memory->calls, 1) + 1;
    size_t total;
    struct header *header;
    char *block;

    if (call == memory->fail_at || !total_bytes(count, size, &total) ||
        !vor_memory_charge(memory, total))
        return NULL;
    block = zeroed ? calloc(1, total + ALIGNMENT) : aligned_alloc(ALIGNMENT, total);
    if (block == NULL) {
        vor_memory_release(memory, total);
        return NULL;
    }
    header = (struct header *)(void *)(block + (-(uintptr_t)block & (ALIGNMENT - 1)));
    *header = (struct header){total, block};
    return (char *)header + ALIGNMENT;
}

void *vor_malloc(struct vor_memory *memory, size_t count, size_t size)
{
    return allocate(memory, count, size, 0);
}

void *vor_calloc(struct vor_memory *memory, size_t count, size_t size)
{
    return allocate(memory, count, size, 1);
}

void *vor_realloc(struct vor_memory *memory, void *p, size_t count, size_t size)
{
    void *grown = vor_malloc(memory, count, size);
    size_t old, now;

    if (grown == NULL || p == NULL)
        return grown;
    old = header_of(p)->bytes;
    now = header_of(grown)->bytes;
    memcpy(grown, p, (old < now ? old : now) - ALIGNMENT);
    vor_free(memory, p);
    return grown;
}

void vor_free(struct vor_memory *memory, void *p)
{
    struct header *header;

    if (p == NULL)
        return;
    header = header_of(p);
    vor_memory_release(memory, header->bytes);
    free(header->block);
}

void vor_free_each(struct vor_memory *memory, void *const *p, size_t count)
{
    for (size_t i = 0; i < count; i++)
        vor_free(memory, p[i]);
}

vor_status vor_make_each(struct vor_memory *memory, size_t n, const struct vor_array *array,
                         size_t count, struct vor_error *err)
{
    int failed = 0;

    for (size_t i = 0; i < count; i++) {
        void *p = NULL;

        if (!failed && array[i].zeroed)
            p = vor_calloc(memory, array[i].count, array[i].size);
        else if (!failed)
            p = vor_malloc(memory, array[i].count, array[i].size);
        failed |= p == NULL;
        memcpy(array[i].to, &p, sizeof p);
    }
    return failed ? vor_fail(err, VOR_E_NOMEM, "%zu points", n) : VOR_OK;
}
