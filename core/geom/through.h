/** A smooth height over the plane that goes through a few points: a sum of |u - u_i|^3 over them
 *  and a plane.
 *
 *  Source: as geom/spline.h, which fits three values to up to thousands of points on the heap. With
 *  so few points a plane bends less than its quadric. */
#ifndef VOR_GEOM_THROUGH_H
#define VOR_GEOM_THROUGH_H

/** Most points that it goes through. */
enum { VOR_THROUGH_MOST = 14 };

/** Terms of the plane: 1, u, v. */
enum { VOR_THROUGH_TERMS = 3 };

/** Lengths are over the scale. */
struct vor_through {
    unsigned n;
    double scale;                                        /**< largest |u| or |v| of a point */
    double at[VOR_THROUGH_MOST][2];                      /**< places of the points */
    double weight[VOR_THROUGH_MOST + VOR_THROUGH_TERMS]; /**< of the points, then of the plane */
};

/** Fits to n points.
 *
 *  @param[out] out    untouched where it returns 0
 *  @param[in]  local  n x 3: u, v and the height
 *  @param[in]  n      at most VOR_THROUGH_MOST
 *
 *  @return 0 where the points determine none: they are fewer than four, lie on a line, or two of
 *          them at one place
 *
 *  O(n^3). Thread-safe. Depends on nothing but its arguments. */
int vor_through_fit(struct vor_through *out, const double (*local)[3], unsigned n);

/** The height over (u, v). O(n). Cannot fail. */
double vor_through_height(const struct vor_through *through, double u, double v);

#endif
