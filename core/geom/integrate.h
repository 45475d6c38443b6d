/** Integrals over a restricted Voronoi cell, and points drawn from it. */
#ifndef VOR_GEOM_INTEGRATE_H
#define VOR_GEOM_INTEGRATE_H

#include "core/geom/cell.h"

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
