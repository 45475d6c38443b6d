/** The methods `wlop` and `ear`.
 *
 *  Source: Huang et al. 2009, "Consolidation of unorganized point clouds" (wlop); Huang et al.
 *  2013, "Edge-Aware Point Set Resampling" (ear). wlop starts evenly by area (seeds/start.h),
 *  projects the points to the input (lop/project.h) and evens them out (seeds/repel.h). ear smooths
 *  normals (lop/normals.h), projects away from edges, inserts points up to them (lop/insert.h) and
 *  evens these out (lop/even.h).
 *
 *  Departure: sigma_p, which the paper sets to the diagonal over the root of the number of input
 *  points, is by default twice the spacing that the samples would have in an even spread, 1.5 times
 *  for wlop: with the paper's, samples that are a tenth of the input do not see each other. It is
 *  the reach of the weights, where exp(-4) is left of the Gaussian that others use. For ear it is
 *  no less than the radius of the fits that the input's noise asks for (input/neighbors.h), one
 *  for all regions: noise that reaches beyond it stays in clusters of samples.
 *  Where not even the most neighbours of a fit show a surface, or noise hides edges that show among
 *  fewer points (lop/scale.h), ear takes fewer of the input's points (input/coarsen.h), and its
 *  result is not attached to the input.
 *  Departure: the papers start from a random subset of the input. That follows its density, and so
 *  does the result, where that is uneven over more than sigma_p: igea, 30,000 points with one half
 *  20 times as dense, to 10,000: delta 0.45 (both), now 0.043 (wlop) and 0.037 (ear); three boxes
 *  with thin sides, 36,000 points in proportions of up to 1:50 to 8,000: wlop 0.69, now 0.09; ear
 *  0.27, where there are fewer data than points. Only `phases=insert` takes points of the input, as
 *  many as `samples` asks for and it has: they stay where they are.
 *  Departure: rho counts only where the input has edges, or nothing is polished: elsewhere
 * priorities make clusters where noise turns the normals (bun_zipper to 20,000: delta 0.165, now
 * 0.022).
 *  Departure: of a dense input with noise ear takes means, three for each sample (input/thin.h):
 * its fits and weights reach as far on them and see the same points. Armadillo, 222,543 points with
 *  noise of 0.1 % of the diagonal to 22,000: rms distance to the true surface 8.1e-4 instead of
 *  8.6e-4, 4.6e-4 instead of 5.1e-4 without the polish; a third of the time.
 *
 *  Neither follows a density or a metric, nor has sites. */
#ifndef VOR_LOP_H
#define VOR_LOP_H

#include "core/method.h"

/** A vor_method's run (core/method.h). Goes through PROJECT and POLISH.
 *
 *  @param[in] spec  read: seed, mu, rounds, steps, sigmaP, boundary, delta, seconds, polish
 *
 *  Fails as that does. Deterministic for any number of threads. */
VOR_NODISCARD vor_status vor_wlop_run(struct vor_seeds *out, struct vor_outcome *told,
                                      const struct vor_domain *domain, size_t n,
                                      const struct vor_spec *spec, const struct vor_run *run,
                                      struct vor_error *err);

/** The same with normals, which the seeds then have. Goes through PROJECT, INSERT and POLISH.
 *
 *  @param[in] spec  read besides: sigmaN, phases, samples, rho, gaps. Half of the seconds are for
 *                   insertion and polish */
VOR_NODISCARD vor_status vor_ear_run(struct vor_seeds *out, struct vor_outcome *told,
                                     const struct vor_domain *domain, size_t n,
                                     const struct vor_spec *spec, const struct vor_run *run,
                                     struct vor_error *err);

#endif
