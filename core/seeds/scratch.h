/** What one worker needs while it computes something for a seed, and what it counts. */
#ifndef VOR_SEEDS_SCRATCH_H
#define VOR_SEEDS_SCRATCH_H

#include "core/geom/cell.h"
#include "core/geom/stretch.h"
#include "core/geom/surface.h"
#include "core/knn/point_lists.h"

/** Input points around a place, the nearest first, and the surface fitted to them. Normalised
 *  units. */
struct vor_place {
    unsigned k; /**< points in near */
    float near[3 * VOR_NEIGHBORS_MAX];
    struct vor_surface surface;
};

/** One for each worker; about 100 KB. The seed is the one that the worker is computing. */
struct vor_scratch {
    struct vor_place here, there; /**< around the seed, and around the place it is meant to go to */
    struct vor_place foot;        /**< around the input point nearest to one of these */
    struct vor_surface onto;      /**< set by vor_seeds_recall: the surface the seed moves along */
    int interior;                 /**< the seed is known to be far from the border */
    struct vor_crowd crowd;       /**< seeds around the seed */
    struct vor_cell cell;
    struct vor_stretch stretch;           /**< with a metric: that of the cell */
    double radius;                        /**< of the patch; with a metric, in that */
    uint64_t queries;                     /**< searches of either index */
    uint64_t cells, bisectors, triangles; /**< cells computed, planes that cut them, triangles of
                                               their patches */
};

/** Sums of these counters over the workers. */
struct vor_counts {
    uint64_t queries, cells, bisectors, triangles;
};

#endif
