/** The energy of a seed's flat cell in a power p of a metric, and how it changes with the places of
 *  all seeds that it depends on.
 *
 *  E is the integral of |M (x - s)|_p^p over the cell of the seed s. Over a triangle with a corner
 *  at s and the others at c1, c2, with u = M (c - s), it is, of each component,
 *  |T| / C(p + 2, 2) times the sum over a + b = p of u1^a u2^b.
 *
 *  A corner of the cell lies where two lines meet: bisectors, sides of the patch, or a wall. As the
 *  seeds move, the corners of bisectors do, too. Cells are Euclidean, so what that changes does not
 *  cancel, unless p is 2 and M is 1.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 * methods", Eq. 4 and Sec. 4.3.3; Levy and Liu 2010, "Lp centroidal Voronoi tessellation and its
 *  applications".
 *  Departure: M is the same over a whole cell, that at its seed. The paper averages those at the
 *  corners of a triangle, which cancel where their eigenvectors have different signs; and it would
 *  have to change with the corners. */
#ifndef VOR_GEOM_ENERGY_H
#define VOR_GEOM_ENERGY_H

#include "core/geom/flat.h"

/** Number of the wall of a cell: a line that stands still. */
#define VOR_ENERGY_WALL (VOR_FLAT_SIDE + 15)

/** The plane of a cell; it, M and the patch stand still while seeds move. Its axes are those of M:
 *  M is a diagonal of two factors in the plane, and 0 across it. */
struct vor_energy_plane {
    double factor[2]; /**< of M, along the plane's axes; > 0 */
    unsigned power;   /**< p: 2, 4, 6 .. */
    double radius;    /**< of the patch, an octagon around the origin */
    double wall[2],
        room; /**< the cell ends where x wall[0] + y wall[1] is room; infinite: no wall */
};

/** What the energy of a cell is and depends on. */
struct vor_energy {
    double value;
    double own[2];  /**< gradient in the place of its seed, in the plane */
    double bend[2]; /**< second derivative in that place, were the cell to stand still */
    unsigned count; /**< other seeds that it depends on */
    uint32_t id[VOR_POLYGON_MAX];  /**< their numbers in the list */
    double by[VOR_POLYGON_MAX][3]; /**< gradient in their places, in the axes of the plane */
};

/** Area and second moments of a cell about its centroid, and Xiao's energy: about its seed, p 2. */
struct vor_energy_shape {
    double area, energy;
    double moment[3]; /**< xx, xy, yy */
};

/** Cuts the cell of a seed in its plane.
 *
 *  @param[in] at     place of the seed in the plane, within the patch
 *  @param[in] other  count places of other seeds, in the plane's coordinates; better the nearest
 *                    first
 *
 *  O(count). Cannot fail. */
void vor_energy_cut(struct vor_flat *cell, const struct vor_energy_plane *plane, const double at[2],
                    const double (*other)[3], unsigned count);

/** Computes the energy of a cell that vor_energy_cut made of the same arguments. O(corners).
 *  Cannot fail. */
void vor_energy_of(struct vor_energy *out, const struct vor_flat *cell,
                   const struct vor_energy_plane *plane, const double at[2],
                   const double (*other)[3]);

/** Computes the shape of such a cell. Returns false where it has no area. */
int vor_energy_shape_of(struct vor_energy_shape *out, const struct vor_flat *cell,
                        const double at[2]);

#endif
