/** A surface stretched along its tangent plane until a metric there is that of equal lengths in all
 *  directions: cells clipped on it by the usual bisectors are cells in the metric. Stretching is
 *  linear and keeps areas in the plane, so that the cell, brought back, has its centroid and area.
 *
 *  Source: none of the papers; Chen 2018, Sec. 5.3, minimises an energy with the metric over
 *  Euclidean cells. Measured in the plane, constant metric, 150 steps of L-BFGS with the exact
 *  gradient from an isotropic start: these reach a median aspect of 1.5 where 2 is asked for, and
 *  of 2.2 where 4 is. */
#ifndef VOR_GEOM_STRETCH_H
#define VOR_GEOM_STRETCH_H

#include "core/geom/cell.h"
#include "core/geom/surface.h"

/** The stretch at a seed. */
struct vor_stretch {
    struct vor_surface surface; /**< stretched; only what vor_cell_begin reads: kind, c, center,
                                     reach */
    double root[3];             /**< xx xy yy of the map, in the surface's first two axes */
    double least;               /**< shortest that a unit vector in space may become */
};

/** Sets up the stretch of a surface for a metric in space (geom/metric.h), as it is in the tangent
 *  plane at the surface's origin, scaled to determinant 1. O(1). Cannot fail. */
void vor_stretch_init(struct vor_stretch *out, const struct vor_surface *surface,
                      const float metric[6]);

/** Stretches a point or offset in the surface's local coordinates. */
static inline void vor_stretch_local(const struct vor_stretch *stretch, double local[3])
{
    double u = local[0], v = local[1];

    local[0] = stretch->root[0] * u + stretch->root[1] * v;
    local[1] = stretch->root[1] * u + stretch->root[2] * v;
}

/** Brings a cell, clipped on the stretched surface, back to the coordinates of the surface itself.
 *  O(corners of the cell). */
void vor_stretch_undo(struct vor_cell *cell, const struct vor_stretch *stretch);

/** The corner of a cell farthest from its seed, NULL when the cell is empty.
 *
 *  @param[in]  stretch  unless NULL, as far as it is once stretched
 *  @param[out] far2     square of that distance, 0 for no corner */
const double *vor_stretch_farthest(const struct vor_cell *cell, const struct vor_stretch *stretch,
                                   double *far2);

#endif
