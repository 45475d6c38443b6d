#include "proto/draco/draco_meter.h"

#include "core/cloud/cloud.h"

#define SAME_ORDER(name, ctype, ply, sized)                                                        \
    _Static_assert((int)VOR_DRACO_##name == (int)VOR_##name, "scalars and types differ: " #name);
VOR_TYPE_TABLE(SAME_ORDER)
#undef SAME_ORDER
_Static_assert((int)VOR_DRACO_SCALAR_COUNT == (int)VOR_TYPE_COUNT, "scalars and types differ");

static int charge(void *ctx, size_t bytes)
{
    struct vor_draco_purse *purse = ctx;

    if (bytes > purse->most - purse->held || !vor_memory_charge(purse->memory, bytes))
        return 0;
    purse->held += bytes;
    return 1;
}

static void release(void *ctx, size_t bytes)
{
    struct vor_draco_purse *purse = ctx;

    vor_memory_release(purse->memory, bytes);
    purse->held -= bytes;
}

struct vor_draco_meter vor_draco_purse_meter(struct vor_draco_purse *purse)
{
    return (struct vor_draco_meter){.ctx = purse, .charge = charge, .release = release};
}
