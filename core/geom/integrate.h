/** Integrals over a restricted Voronoi cell, and points drawn from it. */
#ifndef VOR_GEOM_INTEGRATE_H
#define VOR_GEOM_INTEGRATE_H

#include "core/geom/cell.h"

/** Area, centroid (in the surface's local coordinates) and energy, the integral of the squared
 *  distance to the seed (Xiao 2024 Eq. 2 with density 1). Powers of the surface's unit: 2, 1, 4. */
struct vor_moments {
    double area;
    double centroid[3];
    double energy;
};

/** Computes the moments of a cell by summing over its triangles.
 *
 *  @return false, and *out is unset, when the area is 0 or the centroid is not finite
 *
 *  O(corners of the cell). */
int vor_cell_moments(struct vor_moments *out, const struct vor_cell *cell);

/** The spacing wanted around a seed, relative to an even one: value at the seed, and its slope
 * along the surface's axes. The density is its power -4. */
struct vor_cell_spacing {
    double value, slope[3];
};

/** vor_cell_moments with a density that is linear over each triangle of the cell, and exact for
 *  that: centroid and energy are weighted by it, the area is not. At the corners, the spacing is at
 *  least half of that at the seed, and at most twice. */
int vor_cell_moments_dense(struct vor_moments *out, const struct vor_cell *cell,
                           const struct vor_cell_spacing *spacing);

/** Draws n points of the cell, uniform by area.
 *
 *  @param[in]  area   of the cell (vor_cell_moments); 0 where it has none
 *  @param[in]  unit   of each, three uniform numbers in [0, 1)
 *  @param[out] local  the points, in the surface's local coordinates; the seed where the cell has
 *                     no area
 *
 *  O(n corners of the cell). */
void vor_cell_sample(const struct vor_cell *cell, double area, size_t n, const double (*unit)[3],
                     double (*local)[3]);

#endif
