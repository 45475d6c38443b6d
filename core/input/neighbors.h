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
 *  doubt and a third of the error is left, more where seven tenths of it are. So little tells less
 *  than the whole, and fewer neighbours than the noise wants do more harm than more. */
#ifndef VOR_INPUT_NEIGHBORS_H
#define VOR_INPUT_NEIGHBORS_H

#include "core/input/domain.h"

enum { VOR_NEIGHBORS_PLACES = 512 };

/** How many input points a surface is fitted to, by where it is. */
struct vor_neighbors {
    unsigned usual, most;                /**< of all places taken together; of any */
    unsigned places;                     /**< VOR_NEIGHBORS_PLACES, or 0: `usual` everywhere */
    float xyz[3 * VOR_NEIGHBORS_PLACES]; /**< normalised */
    unsigned char k[VOR_NEIGHBORS_PLACES];
};

/** The same number everywhere, 1 to VOR_NEIGHBORS_MAX. */
void vor_neighbors_fix(struct vor_neighbors *out, unsigned k);

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
