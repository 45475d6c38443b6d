/** Centroidal Voronoi tessellation on local quadrics by Lloyd's method, accelerated.
 *
 *  Source: Xiao et al. 2024, Algorithm 1 and Sec. IV. An iteration fits the local surface of each
 *  seed, clips its restricted Voronoi cell, and projects the cell's centroid. If the request gives
 *  a window, it accelerates as the paper does: of the centroids and the Anderson mix of the last
 *  iterates the more even one is taken.
 *
 *  Departure: without a window, seeds go 1.5 times the way to the centroid and keep up to 0.6 of
 *  their last step (the heavy ball of Polyak 1964; over-relaxed Lloyd of Du and Emelianenko 2006).
 *  Measured on closed clouds of 2,000 to 20,000 points, that reaches the delta of 50 Lloyd
 *  iterations in 15 to 28, the mix in 26 to 50, and stores one vector where the mix stores ten
 *  (tests/paper/departures_test.c). With a few hundred points either may end in another minimum; on
 *  open clouds plain Lloyd (a window of 0) ends lower than both, but slowly.
 *  Departure: of Eq. 12 the smaller delta is taken, as the text says and the formula does not.
 *  Departure: the mix stays in the tangent plane at the projected centroid and within half a
 *  spacing of it; points at the border take no part in it.
 *  Departure: the result is the most even iterate of all.
 *  Departure: where the input is thinned, the last iterations run on the whole of it.
 *
 *  With a density (input/density.h) a centroid is that of Chen 2018, Eq. 3: linear over each
 *  triangle of the cell, from the field around the seed.
 *
 *  With a metric (input/anisotropy.h) cells are clipped in that of their seed (geom/stretch.h), and
 *  steps are as long as they are in it.
 *
 *  Not done here: other norms. */
#ifndef VOR_CVT_LLOYD_H
#define VOR_CVT_LLOYD_H

#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

/** Of a patch's radius: a step is not stretched beyond it, and a seed goes no farther on a plane
 * that stands still (cvt/planes.h). At 0.15 / 0.3 / 0.6: igea 0.0490 / 0.0482 / 0.0486, cow 0.0687
 * / 0.0709 / 0.0702 (lloyd.c); of planes at 0.2 / 0.4 / 0.6, psi4 of a tube 0.88 / 0.88 / 0.85, of
 *  fillets 0.93 / 0.94 / 0.94 (planes.c). */
#define VOR_LLOYD_LONG_STEP 0.3

/** Moves the seeds until a stop of the request (iterations, delta, moveStop, seconds, plateau) or
 * the watch ends it. seeds->xyz ends as the most even positions of all.
 *
 *  @param[in,out] told  this stage is added
 *  @param[in]     spec  read: iterations, delta, moveStop, seconds, anderson, polish
 *  @param[in]     run   may be stopped
 *
 *  @retval VOR_E_CANCELLED the watch answered VOR_CANCEL
 *  @retval VOR_E_NOMEM  up to 110 n bytes (with a window of 4) do not fit
 *
 *  O(iterations n log n) at worst, on the run's pool; mostly O(iterations n). The same positions
 *  for any number of threads. */
VOR_NODISCARD vor_status vor_lloyd_run(struct vor_seeds *seeds, struct vor_outcome *told,
                                       const struct vor_spec *spec, const struct vor_run *run,
                                       struct vor_error *err);

#endif
