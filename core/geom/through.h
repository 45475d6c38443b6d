/** A smooth height over the plane that goes through a few points: a sum of |u - u_i|^3 over them
 *  and a plane.
 *
 *  Source: as geom/spline.h, which fits three values to up to thousands of points on the heap. With
 *  so few points a plane bends less than its quadric. */
#ifndef VOR_GEOM_THROUGH_H
#define VOR_GEOM_THROUGH_H

#include "core/geom/surface.h"

/** Most points that it goes through. */
enum { VOR_THROUGH_MOST = 14 };

/** Fits to n points, over the frame of the surface fitted to them.
 *
 *  @param[out] frame   that surface
 *  @param[out] at      x in the frame
 *  @param[out] height  over (at[0], at[1]); at[2] is that of x
 *  @param[in]  near    n x 3, nearest to x first
 *  @param[in]  n       at most VOR_THROUGH_MOST
 *
 *  @return 0 where the points determine none: they are fewer than four, lie on a line, or two of
 *          them at one place
 *
 *  O(n^3). Thread-safe. Depends on nothing but its arguments. */
int vor_through_fit(struct vor_surface *frame, double at[3], double *height, const float *near,
                    unsigned n, const double x[3]);

#endif
