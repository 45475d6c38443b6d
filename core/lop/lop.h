/** The methods `wlop` and `ear`.
 *
 *  Source: Huang et al. 2009, "Consolidation of unorganized point clouds" (wlop); Huang et al.
 *  2013, "Edge-Aware Point Set Resampling" (ear). wlop projects a random subset of the input
 *  (lop/project.h) and evens it out (seeds/repel.h). ear smooths normals (lop/normals.h), projects
 *  away from edges, inserts points up to them (lop/insert.h) and evens these out (lop/even.h).
 *
 *  Departure: sigma_p, which the paper sets to the diagonal over the root of the number of input
 *  points, is by default twice the spacing that the samples would have in an even spread, 1.5 times
 *  for wlop: with the paper's, samples that are a tenth of the input do not see each other. It is
 *  the reach of the weights, where exp(-4) is left of the Gaussian that others use.
 *  Departure: more samples than the input has points start beside these.
 *
 *  As the subset follows the input's density, so does the result where that is uneven over more
 *  than sigma_p: three boxes with thin sides, 36,000 points to 8,000: delta 0.51 (wlop), 0.59
 * (ear), 0.039 (cvt).
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
