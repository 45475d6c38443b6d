/** A closed polygon in two or three dimensions with a box around each piece of it, halved down to a
 *  few edges: what is asked of it costs the logarithm of its edges, whatever way it winds. */
#ifndef VOR_GEOM_POLYGON_H
#define VOR_GEOM_POLYGON_H

#include "core/base/memory.h"
#include "core/base/status.h"

#include <stddef.h>

/** Edge i goes from point i to the next; after the last comes the first. */
struct vor_polygon {
    struct vor_memory *memory;
    size_t n, dims;   /**< points; coordinates of each, 2 or 3 */
    const double *at; /**< n x dims; borrowed */
    double *box;      /**< of each piece: dims lowest coordinates, dims highest */
};

/** @param[out] out  free with vor_polygon_free; untouched on failure
 *  @param[in]  at   n x dims, finite; must stay as it is while *out lives
 *  @param[in]  n    at least 1
 *
 *  @retval VOR_E_NOMEM 8 dims bytes a point do not fit
 *
 *  O(n), one thread. */
VOR_NODISCARD vor_status vor_polygon_init(struct vor_polygon *out, const double *at, size_t n,
                                          size_t dims, struct vor_memory *memory,
                                          struct vor_error *err);

/** Whether u lies within a polygon in the plane: whether the line from there along the first axis
 *  crosses an odd number of edges. O(log n) and the edges whose boxes u lies in. Thread-safe. */
int vor_polygon_within(const struct vor_polygon *polygon, const double u[2]);

/** The place on a polygon nearest to a point. */
struct vor_polygon_near {
    size_t edge;      /**< of several, the first */
    double t;         /**< share of that edge before the place, 0 .. 1 */
    double distance2; /**< squared */
};

/** Finds it for x, of dims coordinates. O(log n) where few boxes are as near. Thread-safe. */
void vor_polygon_nearest(struct vor_polygon_near *out, const struct vor_polygon *polygon,
                         const double *x);

/** polygon may be all zero. */
void vor_polygon_free(struct vor_polygon *polygon);

#endif
