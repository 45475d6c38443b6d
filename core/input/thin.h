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
