#include "proto/draco/draco_meter.h"

#include "core/cloud/cloud.h"

#define SAME_ORDER(name, ctype, ply, sized)                                                        \
    _Static_assert((int)VOR_DRACO_##name == (int)VOR_##name, "scalars and types differ: " #name);
VOR_TYPE_TABLE(SAME_ORDER)
#undef SAME_ORDER
_Static_assert((int)VOR_DRACO_SCALAR_COUNT == (int)VOR_TYPE_COUNT, "scalars and types differ");

static int charge(void *ctx, size_t bytes)
{
    struct vor_alloc_budget *budget = ctx;

    if (bytes > budget->most - budget->held || !vor_memory_charge(budget->memory, bytes))
        return 0;
    budget->held += bytes;
    return 1;
}

static void release(void *ctx, size_t bytes)
{
    struct vor_alloc_budget *budget = ctx;

    vor_memory_release(budget->memory, bytes);
    budget->held -= bytes;
}

struct vor_draco_meter vor_alloc_budget_meter(struct vor_alloc_budget *budget)
{
    return (struct vor_draco_meter){.ctx = budget, .charge = charge, .release = release};
}
