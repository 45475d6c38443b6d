/** Where the points of a sequence end: between the surface of their frame and that of the result
 *  before, weighed by what is known of each.
 *
 *  A fit to points with noise has an error, another one in each frame, though nothing moved. Of a
 *  quadric it is 2 r / sqrt(k) at its middle, r the rms distance of the k points from it. Around
 *  each seed it is compared with how far the former points lie above the new surface, along its
 *  normal: the former surface has the weight error^2 / way^2, which leaves the least error whether
 *  the way comes from both errors alone or the surface moved too. Where nothing moves that is 1/2
 * in the second frame, 2/3 in the third: the running mean of all frames, though none but the last
 * is kept. Where the surface moved much farther than the error, the former one has next to no
 * weight. No point goes farther back than the error. Of way^2 the mean of the seeds around is
 * taken, of error^2 the harmonic mean: where some fits round off a crease, those beside it count.
 *
 *  20,000 points at rest with noise of 0.2 spacings, fourth frame: from frame to frame they move by
 *  0.062 spacings along the normal, without it by 0.112. 12,000 points whose surface moves by 0 /
 *  0.05 / 0.3 spacings a frame, sixth frame: 0.090 / 0.097 / 0.108 spacings off it, single runs
 *  0.105 / 0.106 / 0.108.
 *
 *  Source: the gain of a Kalman filter from its innovations (Mehra 1970, "On the identification of
 *  variances and adaptive Kalman filtering"), by place instead of by time. */
#ifndef VOR_SEEDS_FORMER_H
#define VOR_SEEDS_FORMER_H

#include "core/seeds/seeds.h"

/** Moves seeds along their normals towards the surface of whole->previous, by that weight times
 *  seeds->coherence. Does nothing without an earlier result, and little if the run is late. Lists
 *  are not made anew for the new positions.
 *
 *  @retval VOR_E_NOMEM  24 bytes for each seed and 52 for each earlier point do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_former_weigh(struct vor_seeds *seeds, struct vor_error *err);

#endif
