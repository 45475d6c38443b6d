/** A warm start: seeds that begin where the points of an earlier result are now (input/motion.h).
 *
 *  Each point of that result is put onto the surface near it; it dies if the surface is too far
 *  away. How many points there should be in each place is read off the first positions of a run
 *  without an earlier result (seeds/start.h): each of these counts for the point nearest to it, and
 *  those farther than a spacing from all points, and than the fit there is off besides, become
 *  points themselves: with noise of 0.2 spacings fits where two sides are near are off by half a
 *  spacing, and 2 to 14 of 5,000 points of an armadillo were born there in each frame, now 0 or 1.
 *  Then the points and what
 *  counts for them are summed along the Morton curve, less where the surface hardly moved, or only
 *  as one body: there the difference is one of noise. Without births where parts of it moved by
 *  themselves, delta of the armadillo of motion.h grows from 0.020 to 0.043 in 30 frames. Where one
 * sum is ahead of the other by BALANCE, a point is born at the emptiest first position since the
 * last such place, or the point with the least room dies. In the end there are exactly as many
 * points as asked for.
 *
 *  Source: none. Matching every point with one of the first positions also keeps the count, but
 *  moves one point in thirty without need. */
#ifndef VOR_SEEDS_WARM_START_H
#define VOR_SEEDS_WARM_START_H

#include "core/seeds/seeds.h"

/** Moves seeds to the points of domain->previous that live on, and to those that are born, in
 *  Morton order; sets their tracks and coherence. If none lives on, the seeds stay where they are.
 *
 *  @param[in,out] seeds  at the first positions of a run without an earlier result, not indexed
 *                        yet; on failure at some of them
 *  @param[in]     coherence  of the request, 0 .. 1; at 0 no point lives on
 *
 *  @retval VOR_E_NOMEM 41 bytes for each earlier point and 29 for each seed do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool. The same positions for any number of threads, unless the run is
 *  late: then the points that are left die. */
VOR_NODISCARD vor_status vor_warm_start(struct vor_seeds *seeds, double coherence,
                                        struct vor_error *err);

/** Gives seeds after the first `known` ones numbers that no point has had so far. */
void vor_warm_start_number(struct vor_seeds *seeds, size_t known);

#endif
