/** Evening out of oriented points (the stage `polish` of a run with edges): short-range repulsion
 *  along their tangent planes, while points on edges move along those only.
 *
 *  Source: seeds/repel.h, whose forces these are; the surface is the latent one (lop/latent.h) and
 *  not the local fits of the input, which are round at edges. The points nearest to an edge are put
 *  onto it first (lop/edges.h): a row of them keeps the others from passing it, and is what the
 *  edge looks like in the result. No point passes the plane of the other side of an edge near it.
 *  At an open border points are not pushed out. */
#ifndef VOR_LOP_EVEN_H
#define VOR_LOP_EVEN_H

#include "core/input/domain.h"
#include "core/lop/beside.h"
#include "core/lop/latent.h"
#include "core/seeds/outcome.h"

/** Most steps that do more good than harm: each time that points are put back they follow the
 *  latent surface, which is smoother than they are, and on edges they crowd. Resampled by 0 / 8 /
 * 24 / 40 / 100: armadillo, 222,543 points with noise to 22,000, rms distance to the true surface
 *  4.7e-4 / 6.0e-4 / 6.5e-4 / 6.7e-4 / 7.2e-4, delta 0.137 / 0.100 / 0.084 / 0.077 / 0.071;
 *  fandisk30k_noise2 to 10,000, rms near edges 7.7e-4 / 7.8e-4 / 9.7e-4 / 1.05e-3 / 1.15e-3, from
 *  the true edge to the nearest point 4.8e-3 / 3.2e-3 / 3.0e-3 / 3.0e-3 / 3.0e-3, delta 0.135 /
 *  0.067 / 0.048 / 0.047 / 0.049; fandisk30k_noisy likewise, but delta 0.171 / 0.104 / 0.071 /
 *  0.064 / 0.058. */
enum { VOR_LOP_EVEN_MOST = 24 };

/** How points are evened out. */
struct vor_lop_even_how {
    uint32_t steps; /**< 0: nothing is done */
    int local;      /**< the spacing of each place is kept; else all of the surface gets one */
    const struct vor_lop_beside *beside; /**< where points that hang in the air are put,
                                            each time before neighbours are listed */
    const struct vor_spec *spec;         /**< read: delta, seconds, which end it earlier */
};

/** Evens the points out; normals follow.
 *
 *  @param[in]     latent  the surface
 *  @param[in]     domain  what is told counts from it
 *  @param[in,out] told    the stage is added; stopped may change, and if the caller stopped the run
 *                         before, nothing is done
 *  @param[in]     run     a stop ends it with the positions so far
 *
 *  @retval VOR_E_CANCELLED  the watch answered VOR_CANCEL
 *  @retval VOR_E_NOMEM      330 n bytes do not fit
 *
 *  O(steps n), on the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_lop_even(struct vor_lop_samples *samples,
                                      const struct vor_lop_latent *latent,
                                      const struct vor_lop_even_how *how,
                                      const struct vor_domain *domain, struct vor_outcome *told,
                                      const struct vor_run *run, struct vor_error *err);

#endif
