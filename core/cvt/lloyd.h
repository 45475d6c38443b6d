/** Centroidal Voronoi tessellation on local quadrics by Lloyd's method, accelerated.
 *
 *  Source: Xiao et al. 2024, Algorithm 1 and Sec. IV. Each iteration: local surface and restricted
 *  Voronoi cell of every seed, its centroid, projected. With a window given, the paper's
 * acceleration: the Anderson mix of the last iterates; of the two the more even one.
 *
 *  Departure: without a window, seeds go 1.5 times the way to the centroid and keep up to 0.6 of
 * their last step (the heavy ball of Polyak 1964; over-relaxed Lloyd of Du and Emelianenko 2006).
 * Measured on closed clouds of 2,000 to 20,000 points, that reaches the delta of 50 Lloyd
 * iterations in 15 to 28, the mix in 26 to 50, and keeps one vector where the mix keeps ten.
 * Departure: of Eq. 12 the smaller delta is taken, as the text says and the formula does not.
 * Departure: the mix keeps to the tangent plane at the projected centroid and within half a spacing
 * of it; points at the border take no part in it. Departure: the result is the most even iterate of
 * all.
 *
 *  Not done here: density, anisotropy, other norms. */
#ifndef VOR_CVT_LLOYD_H
#define VOR_CVT_LLOYD_H

#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

/** Moves the seeds until a stop of the request (iterations, delta, seconds, plateau) or the watch
 *  ends it, and leaves the most even positions in seeds->xyz.
 *
 *  @param[in,out] told  takes in this stage
 *  @param[in]     spec  read: iterations, delta, seconds, anderson, polish
 *  @param[in]     run   may be stopped
 *
 *  @retval VOR_E_CANCELLED the watch answered VOR_CANCEL
 *  @retval VOR_E_NOMEM
 *
 *  O(iterations n log n). The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_lloyd_run(struct vor_seeds *seeds, struct vor_outcome *told,
                                       const struct vor_spec *spec, const struct vor_run *run,
                                       struct vor_error *err);

#endif
