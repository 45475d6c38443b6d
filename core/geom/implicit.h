/** A surface that bends back on itself near a place: where a quadratic in x, y and z is zero.
 *
 *  Over a plane there is one height, so that a fit to both faces of a thin part runs between them.
 *  A quadratic is zero on both, and on the rim where they meet, round or sharp; its gradient leads
 *  away from the part on one face as on the other.
 *
 *  Source: Taubin 1991, "Estimation of planar curves, surfaces, and nonplanar space curves defined
 *  by implicit equations": the mean square of the value over that of the gradient is least. */
#ifndef VOR_GEOM_IMPLICIT_H
#define VOR_GEOM_IMPLICIT_H

#include "core/geom/surface.h"

/** Points that it is fitted to: those of a fit to each of two faces. At 24 / 30 / 40, share of the
 *  pairs of points, each within 20 nearest, whose sides it tells wrong, of lenses, blades and
 *  plates one spacing thick with noise of 0.05 spacings: .019 / .0004 / 0; without noise .0003 /
 *  .0001 / .0001. */
enum { VOR_IMPLICIT_POINTS = 2 * VOR_NEIGHBORS_FEWEST, VOR_IMPLICIT_TERMS = 9 };

/** The quadratic, but for its constant. Lengths are over the radius. */
struct vor_implicit {
    double origin[3], radius;
    double c[VOR_IMPLICIT_TERMS];
};

/** Fits to n points, which count the less the farther they are from x, where they lie far nearer to
 *  it than to a surface of one height.
 *
 *  @param[out] out   untouched where it returns 0
 *  @param[in]  near  n x 3, nearest to x first
 *
 *  @return 0 where one height explains them as well, or they determine nothing
 *
 *  O(n). Thread-safe. Depends on nothing but its arguments. */
int vor_implicit_fit(struct vor_implicit *out, const float *near, unsigned n, const float x[3]);

/** Unit vector along the gradient at x; 0 where that is 0. O(1). */
void vor_implicit_normal(const struct vor_implicit *implicit, const float x[3], double normal[3]);

#endif
