#include "core/base/count.h"

#include <stdatomic.h>

enum { BLOCK = 1 << 16 }; /* rows of one task */

struct counting {
    vor_is_counted is;
    const void *ctx;
    atomic_size_t count, first;
};

static void count_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct counting *counting = ctx;
    size_t count = 0, first = end, before = atomic_load(&counting->first);

    for (size_t i = begin; i < end; i++)
        if (counting->is(counting->ctx, i) && count++ == 0)
            first = i;
    atomic_fetch_add(&counting->count, count);
    while (count > 0 && first < before &&
           !atomic_compare_exchange_weak(&counting->first, &before, first))
        ;
}

vor_status vor_count(size_t *count, size_t *first, size_t n, vor_is_counted is, const void *ctx,
                     const struct vor_run *run, struct vor_error *err)
{
    struct counting counting = {.is = is, .ctx = ctx, .first = n};
    vor_status status = vor_run_for(run, n, BLOCK, count_block, &counting, err);

    *count = atomic_load(&counting.count);
    *first = atomic_load(&counting.first);
    return status;
}
