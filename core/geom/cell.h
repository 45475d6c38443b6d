/** The restricted Voronoi cell of a seed: its patch, a meshed hexagon lifted to the local surface,
 *  clipped by the bisectors with the seeds around it.
 *
 *  Source: Xiao et al. 2024, Sec. III-B step 3 and III-C; the stop at the security radius is Levy
 * and Bonneel's. Departure: the hexagon is centred under the seed, not at the nearest input point,
 * so that it covers the cell also where the result is denser than the input. Departure: where the
 * surface hardly bends over the patch, that is one hexagon in the tangent plane. */
#ifndef VOR_GEOM_CELL_H
#define VOR_GEOM_CELL_H

#include "core/geom/surface.h"

#include <stddef.h>

#define VOR_RINGS_MAX 4
#define VOR_PATCH_VERTICES_MAX (1 + 3 * VOR_RINGS_MAX * (VOR_RINGS_MAX + 1))
#define VOR_PATCH_TRIANGLES_MAX (6 * VOR_RINGS_MAX * VOR_RINGS_MAX)

/** Vertices and triangles of the hexagon of radius 1, made once. */
struct vor_disc {
    unsigned vertex_count, triangle_count;
    double vertex[VOR_PATCH_VERTICES_MAX][2];
    unsigned char triangle[VOR_PATCH_TRIANGLES_MAX][3];
};

/** rings is 0 .. VOR_RINGS_MAX: 6 rings^2 triangles; none stands for the tangent plane. */
void vor_disc_init(struct vor_disc *disc, unsigned rings);

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

/** Area, centroid (in the surface's local coordinates) and energy, the integral of the squared
 *  distance to the seed (Xiao 2024 Eq. 2). */
struct vor_moments {
    double area;
    double centroid[3];
    double energy;
};

/** False, and out is unset, when the cell has no area worth the name. */
int vor_cell_moments(struct vor_moments *out, const struct vor_cell *cell);

/** A point of the cell from three uniform numbers in [0, 1), even by area; local coordinates. The
 * cell has area. */
void vor_cell_sample(const struct vor_cell *cell, const double unit[3], double local[3]);

#endif
