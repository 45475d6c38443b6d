#include "core/base/memory.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 };

/* Sits in the ALIGNMENT bytes before what the caller gets. */
struct header {
    size_t bytes;
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

    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - 2 * (size_t)ALIGNMENT)
        return 0;
    bytes = (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    *total = bytes + ALIGNMENT;
    return 1;
}

static struct header *header_of(void *p)
{
    return (struct header *)(void *)((char *)p - ALIGNMENT);
}

void *vor_malloc(struct vor_memory *memory, size_t count, size_t size)
{
    size_t call = atomic_fetch_add(&memory->calls, 1) + 1;
    size_t total;
    char *block;

    if (call == memory->fail_at || !total_bytes(count, size, &total) ||
        !vor_memory_charge(memory, total))
        return NULL;
    block = aligned_alloc(ALIGNMENT, total);
    if (block == NULL) {
        vor_memory_release(memory, total);
        return NULL;
    }
    ((struct header *)(void *)block)->bytes = total;
    return block + ALIGNMENT;
}

void *vor_calloc(struct vor_memory *memory, size_t count, size_t size)
{
    void *p = vor_malloc(memory, count, size);

    if (p != NULL)
        memset(p, 0, count * size);
    return p;
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
    free(header);
}

void vor_free_each(struct vor_memory *memory, void *const *p, size_t count)
{
    for (size_t i = 0; i < count; i++)
        vor_free(memory, p[i]);
}
