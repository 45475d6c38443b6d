/** Books what the Draco library allocates on a cloud's allocator. */
#ifndef VOR_PROTO_DRACO_METER_H
#define VOR_PROTO_DRACO_METER_H

#include "core/base/memory.h"
#include "proto/draco/draco_shim.h"

/** The library may hold `most` bytes at a time; beyond that, and beyond the allocator's cap, it is
 *  refused. */
struct vor_alloc_budget {
    struct vor_memory *memory;
    size_t held, most;
};

/** A meter on the budget, which is borrowed. */
struct vor_draco_meter vor_alloc_budget_meter(struct vor_alloc_budget *budget);

#endif
