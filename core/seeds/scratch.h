/** What one worker has at hand while it computes something for a seed, and what it counts. */
#ifndef VOR_SEEDS_SCRATCH_H
#define VOR_SEEDS_SCRATCH_H

#include "core/geom/cell.h"
#include "core/geom/surface.h"
#include "core/knn/point_lists.h"

/** Input points around a place, nearest first, and the surface fitted to them. */
struct vor_place {
    unsigned k; /**< how many */
    float near[3 * VOR_NEIGHBORS_MAX];
    struct vor_surface surface;
};

struct vor_scratch {
    struct vor_place here, there; /**< of the seed at hand, and of where it wants to go */
    struct vor_place foot;        /**< of the input point nearest to one of these */
    struct vor_surface onto;      /**< set by vor_seeds_recall: what the seed moves along */
    int interior;                 /**< the seed at hand is known to be far from the border */
    struct vor_crowd crowd;       /**< seeds around the seed at hand */
    struct vor_cell cell;
    double radius;                        /**< of the patch */
    uint64_t queries;                     /**< searches of either index */
    uint64_t cells, bisectors, triangles; /**< computed; that cut them; of their patches */
};

/** Sums of those counters over the workers. */
struct vor_counts {
    uint64_t queries, cells, bisectors, triangles;
};

#endif
