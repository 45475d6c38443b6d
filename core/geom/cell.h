/** The restricted Voronoi cell of a seed: its patch, a meshed hexagon lifted to the local surface,
 *  clipped by the bisectors with the seeds around it.
 *
 *  Source: Xiao et al. 2024, Sec. III-B step 3 and III-C; the stop at the security radius is Levy
 * and Bonneel's. Departure: the hexagon is centred under the seed, not at the nearest input point,
 * so that it covers the cell also where the result is denser than the input. Departure: where the
 * surface hardly bends over the patch, that is one hexagon in the tangent plane. */
#ifndef VOR_GEOM_CELL_H
#define VOR_GEOM_CELL_H

#include "core/geom/patch.h"
#include "core/geom/surface.h"

#include <stddef.h>

#define VOR_POLYGON_MAX 24

/** A convex piece of the cell, coordinates relative to the seed in the surface's axes. */
struct vor_polygon {
    unsigned count;
    double radius2;                    /**< squared distance of the farthest corner from the seed */
    double vertex[VOR_POLYGON_MAX][4]; /**< last: squared distance from the seed */
};

/** A cell being clipped. Scratch: one for each thread. */
struct vor_cell {
    double seed[3];     /**< in the surface's local coordinates */
    double radius2;     /**< squared distance of the farthest corner from the seed */
    unsigned count;     /**< pieces; 0: nothing is left */
    unsigned bisectors; /**< that cut something */
    struct vor_polygon piece[VOR_PATCH_TRIANGLES_MAX];
};

/** Lifts the disc of the given radius around the seed onto the surface (kind is not NONE); without
 * triangles, the cell begins as one hexagon in the tangent plane at the seed. */
void vor_cell_begin(struct vor_cell *cell, const struct vor_disc *disc,
                    const struct vor_surface *surface, const double seed[3], double radius);

/** True when a seed at squared distance d2 and every farther one cannot cut the cell any more. */
static inline int vor_cell_secure(const struct vor_cell *cell, double d2)
{
    return d2 >= 4 * cell->radius2;
}

/** Keeps what is nearer to the seed than to seed + offset (in the surface's axes, not zero). */
void vor_cell_clip(struct vor_cell *cell, const double offset[3]);

#endif
