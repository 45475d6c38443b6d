/** Turns patches of a surface that face the wrong way, by winding numbers.
 *
 *  The winding number of oriented points is 1 inside a closed surface and 0 outside; on the surface
 *  it is a half, wherever that is. Where a part such as a tail is turned inside out, it is a half
 *  less than 0 on it. So a patch faces the wrong way if turning it brings the numbers on it
 *  nearer to that of the rest of its component. Edges do not tell this: a tail that hangs along a
 *  body has more neighbours across the gap than where it is joined to it.
 *
 *  Source: Barill et al. 2018, "Fast winding numbers for soups and clouds". Departure: two levels,
 *  points and blocks of them, in place of a tree. Departure: a number is compared with those on the
 *  rest of the surface and not with a half, so that open surfaces, on which it is another one, are
 *  judged alike. */
#ifndef VOR_GEOM_WINDING_H
#define VOR_GEOM_WINDING_H

#include "core/geom/span.h"

/** Points of a surface. */
struct vor_winding_points {
    const float *xyz;    /**< n x 3, points that are near in the array are near in space */
    const float *normal; /**< n x 3, unit length; span->odd says whether it is turned */
    const float *area;   /**< n: what a point stands for, not negative */
};

/** Turns those of the patches of `span` that face the wrong way.
 *
 *  @retval VOR_E_NOMEM 3 bytes a point do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; some patches are turned
 *
 *  O(n) for each patch, on the run's pool. The same signs for any number of threads. */
VOR_NODISCARD vor_status vor_winding_turn(struct vor_span *span,
                                          const struct vor_winding_points *points,
                                          const struct vor_run *run, struct vor_error *err);

/** The mean of the winding numbers on the points: about a half, or minus a half, where their
 *  surface is closed.
 *
 *  Fails as vor_winding_turn. O(n), on the run's pool. The same bits for any number of threads. */
VOR_NODISCARD vor_status vor_winding_mean(double *out, struct vor_span *span,
                                          const struct vor_winding_points *points,
                                          const struct vor_run *run, struct vor_error *err);

#endif
