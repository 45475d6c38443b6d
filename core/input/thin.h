/** Thins a dense input: some of its points, spread evenly, with an index of their own.
 *
 *  Source: none of the papers; Xiao 2024 moves points on the whole input. Where the input has many
 *  points for each one of the result, twenty neighbours reach over a fraction of a cell. On a
 *  thinned input they reach as far as a cell: lists and surfaces are valid for as many iterations
 *  as on a sparse input, normals do not follow the noise between neighbours, and an iteration costs
 *  the same for ten thousand points as for five million. The last steps run on the whole input
 *  (vor_attach_to_whole), so that the result lies on all of it. */
#ifndef VOR_INPUT_THIN_H
#define VOR_INPUT_THIN_H

#include "core/input/domain.h"

/** Points of the input for each one of the result, and in all, at least: more show no more of a
 *  cell. Where fits take more than the fewest neighbours, because of noise, there are as many times
 *  more, so that a fit reaches as far. Measured: CPU of an iteration at 5 million points is 1.2
 *  times that at 10,000, without thinning 2.3 times; armadillo, 5 million to 100,000, 20
 *  iterations: 15 CPU s, without 20, delta and distance to the true surface the same; on noisy
 *  dense clouds both are lower by a third. With twice as many, armadillo as above: rms 0.56e-4 for
 *  0.58e-4, searches 9 % fewer, but 11 % more triangles a cell. With a least of 10,000 /
 *  20,000 / 40,000 (then it is not thinned), armadillo, 43,243 to 4,000: rms 2.15e-4 / 2.12e-4
 * / 2.22e-4, delta 0.0207 / 0.0211 / 0.0199. */
enum { VOR_THIN_EACH = 5, VOR_THIN_LEAST = 20000 };

/** Takes some of the points of `in` and indexes them: in their order, each one that is at least
 *  `gap` (normalised) from the last 16 taken in its block. Leaves *out empty if it would keep more
 *  than half of the points. What is known of `in` is taken over, but *out may have sheets that are
 *  too far apart on `in` to be found there.
 *
 *  @param[out] out  free with vor_domain_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_domain_thin(struct vor_domain *out, const struct vor_domain *in,
                                         double gap, const struct vor_run *run,
                                         struct vor_error *err);

/** Thins a domain to move n points on: to about five points for each, at least 20,000, and more
 *  where fits take more neighbours than the fewest. Leaves *out empty if `in` has less than twice
 *  as many, or area is 0.
 *
 *  @param[in] area  of the surface, in squared normalised units
 *
 *  Fails and costs as vor_domain_thin. */
VOR_NODISCARD vor_status vor_domain_thin_for(struct vor_domain *out, const struct vor_domain *in,
                                             size_t n, double area, const struct vor_run *run,
                                             struct vor_error *err);

/** Thins a dense domain whose noise makes fits take more than the fewest neighbours, to about four
 *  points for each of n, at least 20,000. Each is the mean of those of `in` that are nearest to it,
 *  and fits take so many fewer: they reach as far, and see as many points of `in`. Leaves *out
 *  empty if `in` has less than twice as many, sheets or lists, of which means would be a mixture.
 *
 *  Source: none of the papers. A mean of m points has a noise of 1 / sqrt(m), and lies off a bent
 *  surface by a part of what a fit to all neighbours does.
 *
 *  @param[in] area  of the surface, in squared normalised units
 *
 *  Fails and costs as vor_domain_thin, and a search of all points. */
VOR_NODISCARD vor_status vor_domain_means_for(struct vor_domain *out, const struct vor_domain *in,
                                              size_t n, double area, const struct vor_run *run,
                                              struct vor_error *err);

/** Thins a domain itself, to a gap of the mean distance of its points to their three nearest
 *  others: evens the density of an uneven input out from above, and leaves about half of one that
 *  white noise spread. Lists of neighbours (domain->graph) are gone afterwards. Does nothing if
 *  fewer than 20 points would be left.
 *
 *  Source: Lv 2022, Sec. 3.1. Departure: it takes points in their order, the paper the one of each
 *  voxel of that size that is nearest to the voxel's middle; two of those may be as near each other
 *  as any.
 *
 *  Fails and costs as vor_domain_thin, and a search of all points. */
VOR_NODISCARD vor_status vor_thin_filter(struct vor_domain *domain, const struct vor_run *run,
                                         struct vor_error *err);

#endif
