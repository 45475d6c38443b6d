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

/** Draws a point of the cell, uniform by area.
 *
 *  @param[in]  unit   three uniform numbers in [0, 1)
 *  @param[out] local  the point, in the surface's local coordinates; the seed where the cell has no
 *                     area
 *
 *  O(corners of the cell). */
void vor_cell_sample(const struct vor_cell *cell, const double unit[3], double local[3]);

#endif
