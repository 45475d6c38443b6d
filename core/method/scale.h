/** How many input points a local surface is to be fitted to, told by the input itself: few where it
 * is exact, so that nothing is rounded off, more where it is noisy or on a lattice.
 *
 *  Source: none of the papers; Xiao 2024 Sec. V-D leaves the number to the caller, and too few on a
 *  noisy cloud is worse than no denoising. At places spread over the input a surface is fitted to
 *  20, 30, 45, 70, 100 and 150 neighbours. A neighbourhood that is nearly as thick as it is wide
 *  says nothing of a surface: where that is so at more than one place in thirty, more neighbours
 * are taken until it is not, or until more of them help little; not where the shape is merely
 * coarse. From there the number goes up while that lowers 3 s^2 / k, what noise of variance s^2
 * leaves of itself in a fit to k points, by more than it adds to the residual, the detail that is
 * lost. */
#ifndef VOR_METHOD_SCALE_H
#define VOR_METHOD_SCALE_H

#include "core/method/domain.h"

/** @param[out] k  20 to 150
 *
 *  @retval VOR_E_NOMEM 100 KB do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(log n), some 20 ms. The same number for any number of threads. */
VOR_NODISCARD vor_status vor_scale_neighbors(unsigned *k, const struct vor_domain *domain,
                                             const struct vor_run *run, struct vor_error *err);

#endif
