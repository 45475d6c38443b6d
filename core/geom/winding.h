/** Turns patches of a surface that face the wrong way, by winding numbers.
 *
 *  The winding number of oriented points is 1 inside a closed surface and 0 outside; on the surface
 *  it is a half, wherever that is. So a patch faces the wrong way if turning it brings the numbers
 *  on the whole surface nearer to a half, or to its negative. Edges do not tell this: a tail that
 *  hangs along a body has more neighbours across the gap than where it is joined to it, and at a
 *  sharp edge normals are those of neither face.
 *
 *  Source: Barill et al. 2018, "Fast winding numbers for soups and clouds". Departure: two levels,
 *  points and blocks of them, in place of a tree. */
#ifndef VOR_GEOM_WINDING_H
#define VOR_GEOM_WINDING_H

#include "core/geom/span.h"

/** Places on a piece of a surface where numbers are taken. */
enum { VOR_WINDING_PLACES = 32 };

/** Points of a surface. */
struct vor_winding_points {
    const float *xyz;    /**< n x 3, points that are near in the array are near in space */
    const float *normal; /**< n x 3, unit length; span->odd says whether it is turned */
    const float *area;   /**< n: what a point stands for, not negative */
    size_t least;        /**< vor_winding_find leaves out components of fewer points, of which a
                              spacing is a large part */
    const struct vor_graph *graph; /**< of vor_span_make, where there is `other` */
    const unsigned char *other;    /**< n: other signs than the span's; NULL: none */
};

/** Turns those of the patches of `span` that face the wrong way: the one first whose turning gains
 *  most.
 *
 *  @retval VOR_E_NOMEM 14 bytes a point and 150,000 do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; some components are done
 *
 *  O(n) for each of at most 1,056 places, on the run's pool. The same signs for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_winding_turn(struct vor_span *span,
                                          const struct vor_winding_points *points,
                                          const struct vor_run *run, struct vor_error *err);

/** Winding numbers on a component. */
struct vor_winding_found {
    double mean;  /**< about a half, or minus a half, where it is closed */
    double apart; /**< mean square of how far they are from that: 0 on a closed surface, 0.25 on a
                       flat sheet */
    double stray; /**< mean square of how far they are from 0 or 1 (or -1), a spacing off the
                     surface on both sides; likewise. Of a noisy star prism with two sides of an arm
                     the wrong way 0.034, all right 0.016, where apart is 0.056 and 0.041 */
    double jump;  /**< mean square of how far they differ between both ends of edges that the
                       other signs turn: small where the span's are right, closed or not; 0 where
                       no edge is */
    double seam;  /**< points that such edges begin at, over the root of all */
};

/** Finds the numbers on the points of each component, from this component alone.
 *
 *  @param[out] out  span->components; 0 for those left out
 *
 *  Fails as vor_winding_turn. O(n), on the run's pool. The same bits for any number of threads. */
VOR_NODISCARD vor_status vor_winding_find(struct vor_winding_found *out,
                                          const struct vor_span *span,
                                          const struct vor_winding_points *points,
                                          const struct vor_run *run, struct vor_error *err);

#endif
