/** How many input points a local surface is to be fitted to, told by the input itself: few where it
 * is exact, so that nothing is rounded off, more where it is noisy or on a lattice.
 *
 *  Source: none of the papers; Xiao 2024 Sec. V-D leaves the number to the caller, and too few on a
 *  noisy cloud is worse than no denoising. At places spread over the input a surface is fitted to
 *  20, 30, 45, 70, 100 and 150 neighbours. A neighbourhood that is nearly as thick as it is wide
 *  says nothing of a surface: where that is so at more than one place in thirty, more neighbours
 *  are taken until it is not, or until more of them help little; not where the shape is merely
 *  coarse. From there the number goes up while that lowers 3 s^2 / k, what noise of variance s^2
 *  leaves of itself in a fit to k points, by more than it adds to the residual, the detail that is
 *  lost.
 *
 *  That is the usual number. Each place then asks the same of itself and the 31 places nearest to
 *  it, and takes another number where that is worth it: fewer where neighbourhoods are thin beyond
 *  doubt and a third of the error is left, more where seven tenths of it are. Few places estimate
 *  the noise worse than all together, and too few neighbours do more harm than too many.
 *
 *  Measured, rms distance to the true surface with one number for all and with one for each region:
 *  igea with noise on one half 1.16e-3 and 0.99e-3, with noise that grows across it 1.20e-3 and
 *  0.97e-3; bunny with noise on one half 0.96e-3 and 0.84e-3; where noise is the same everywhere, 2
 *  % more to 3 % less. Weighed too: regions that decide by themselves alone, which wins another 5 %
 *  on such halves and loses 10 % where noise is the same everywhere; pools of 16 and 64 places; a
 *  number for each lattice point's smoothing (no gain). */
#ifndef VOR_INPUT_NEIGHBORS_H
#define VOR_INPUT_NEIGHBORS_H

#include "core/input/domain.h"

/** 20 to 150 by what the domain is like.
 *
 *  @retval VOR_E_NOMEM 100 KB do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(log n), some 20 ms. The same numbers for any number of threads. */
VOR_NODISCARD vor_status vor_neighbors_choose(struct vor_neighbors *out,
                                              const struct vor_domain *domain,
                                              const struct vor_run *run, struct vor_error *err);

/** How many at x: as at the nearest place. 0.3 us where that differs. */
unsigned vor_neighbors_at(const struct vor_neighbors *neighbors, const float x[3]);

#endif
