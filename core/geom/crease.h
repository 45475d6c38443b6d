/** A crease: two sides of a surface that meet along an edge, fitted to the points around one.
 *
 *  Source: none of the papers fits one. Over a plane the heights of a crease are those of a smooth
 *  surface plus c max(0, u - u0 - s v), where u runs across the edge and v along it. Both that and
 *  a quadric have the terms 1, u, v, uv, vv; the quadric's uu then stands against the kink. Which
 *  of the two leaves less says whether the points lie on a crease, and u0 how far away its edge is.
 *  u0 is looked for on a row of places; after that each side gets its own plane, the line where the
 *  two meet is the next edge, and so on while that leaves less. */
#ifndef VOR_GEOM_CREASE_H
#define VOR_GEOM_CREASE_H

#include "core/geom/surface.h"

/** Fewest points that a crease is fitted to: twice the coefficients of the fit, less two for the
 *  point itself and the place. */
#define VOR_CREASE_MIN (2 * VOR_QUADRIC_TERMS - 2)

struct vor_crease {
    double smooth2;  /**< mean square of the points' heights over the quadric, in spacings^2 */
    double crease2;  /**< the same over the crease */
    double distance; /**< from the first point to the edge, in spacings */
    double turn;     /**< sine of half the angle between the normals of the two sides */
    double along[3]; /**< unit vector along the edge */
    double foot[3];  /**< from the first point to the nearest one of the edge, in spacings */
};

/** Fits a crease and a quadric.
 *
 *  @param[in] near     k x 3 floats; the crease is looked for within two spacings of the first
 *  @param[in] k        VOR_CREASE_MIN .. VOR_NEIGHBORS_MAX
 *  @param[in] axis     rows, orthonormal: about along the edge, across it, and up
 *  @param[in] spacing  > 0: unit of the results
 *
 *  Cannot fail: where there is no crease at all, crease2 is not below smooth2, or turn is small.
 *  O(k). Depends on nothing but its arguments. */
void vor_crease_fit(struct vor_crease *out, const float *near, unsigned k, double axis[3][3],
                    double spacing);

#endif
