/** The restricted Voronoi cell of a seed: its patch, a meshed hexagon or octagon lifted to the
 *  local surface, clipped by the bisectors with the seeds around it.
 *
 *  Source: Xiao et al. 2024, Sec. III-B step 3 and III-C. Clipping stops at the security radius:
 *  Levy and Bonneel 2012, "Variational anisotropic surface meshing with Voronoi parallel linear
 *  enumeration".
 *
 *  Departure: the hexagon is centred under the seed, not at the nearest input point. So it covers
 *  the cell also where the result is denser than the input.
 *  Departure: where the surface hardly bends over the patch, the cell begins as one polygon in the
 *  tangent plane.
 *  Departure: a cell that does not reach the sides of its patch is mostly made without one
 *  (vor_cell_wrap). */
#ifndef VOR_GEOM_CELL_H
#define VOR_GEOM_CELL_H

#include "core/geom/patch.h"
#include "core/geom/surface.h"

#include <stddef.h>

/** Most corners of a piece, or of a flat cell (geom/flat.h). A triangle, hexagon or octagon gains
 * at most one corner a cut, and cells have about six sides. A piece that reaches the limit is not
 * cut any further: its area is then too large. */
#define VOR_POLYGON_MAX 24

/** A convex piece of the cell, coordinates relative to the seed in the surface's axes. */
struct vor_polygon {
    unsigned count;
    double radius2;                    /**< squared distance from the seed to the farthest corner */
    double vertex[VOR_POLYGON_MAX][4]; /**< x, y, z and the squared distance to the seed */
};

/** A cell that is being clipped; lengths in the unit of the surface. Each thread needs its own. */
struct vor_cell {
    double seed[3];     /**< in the surface's local coordinates */
    double radius2;     /**< squared distance from the seed to the farthest corner */
    unsigned count;     /**< pieces; 0: nothing is left */
    unsigned bisectors; /**< planes that have cut something off */
    struct vor_polygon piece[VOR_PATCH_TRIANGLES_MAX];
};

/** Begins a cell: lifts the disc, scaled to `radius` and centred at the seed, onto the surface. A
 *  disc without triangles gives one polygon in the tangent plane at the seed.
 *
 *  @param[in] surface  its kind is not NONE
 *  @param[in] seed     in the surface's local coordinates
 *
 *  Cannot fail. O(vertices of the disc). */
void vor_cell_begin(struct vor_cell *cell, const struct vor_disc *disc,
                    const struct vor_surface *surface, const double seed[3], double radius);

/** True when no seed at squared distance d2 or more can cut the cell: every corner is nearer to
 *  this seed than half of that distance (the security radius). */
static inline int vor_cell_secure(const struct vor_cell *cell, double d2)
{
    return d2 >= 4 * cell->radius2;
}

/** Keeps the part of the cell that is nearer to the seed than to seed + offset.
 *
 *  @param[in] offset  in the surface's axes, not zero
 *
 *  Cannot fail; may leave no piece. O(corners of the cell). */
void vor_cell_clip(struct vor_cell *cell, const double offset[3]);

/** The same for seeds around seed i, until one coincides with it or secures the cell.
 *
 *  @param[in] axis   those of the surface
 *  @param[in] xyz    positions of all seeds
 *  @param[in] index  `count` seeds, the nearest first
 *
 *  @return how many of them it went through */
unsigned vor_cell_clip_by(struct vor_cell *cell, const double axis[3][3], const float *xyz,
                          size_t i, const uint32_t *index, unsigned count);

/** The seeds around one, in any order. */
struct vor_cell_around {
    const float *xyz; /**< positions of all seeds */
    size_t i;         /**< the one */
    const uint32_t *index;
    unsigned count;
    int bent; /**< the cell is to follow the surface, not its tangent plane */
};

/** Most seeds around one that vor_cell_wrap takes; lists of seeds hold fewer. A power of two: which
 *  one it is takes so many bits. */
#define VOR_CELL_WRAP_MAX 32

/** Makes a cell at once: goes around it in the tangent plane, along each side to where the next
 *  bisector crosses it. If `bent`, the corners are then moved along the surface to where the
 *  bisectors meet on it, and the cell is a triangle for each side.
 *
 *  @param[in] inner   the cell is to lie within this of the seed
 *  @param[in] around  all seeds within twice that
 *
 *  @return whether it does; else the cell is undefined, and vor_cell_begin may follow
 *
 *  Source: gift wrapping, in the dual (Jarvis 1973, "On the identification of the convex hull of a
 *  finite set of points in the plane"). O(count sides). */
int vor_cell_wrap(struct vor_cell *cell, const struct vor_surface *surface, const double seed[3],
                  double inner, const struct vor_cell_around *around);

#endif
