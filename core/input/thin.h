/** A dense input made thinner: some of its points, even in space, with an index of their own.
 *
 *  Source: none of the papers; Xiao 2024 moves points on the whole input. */
#ifndef VOR_INPUT_THIN_H
#define VOR_INPUT_THIN_H

#include "core/input/domain.h"

/** Some of the points of `in`, with an index of their own: a gap (normalised) from those kept
 *  before them in the order, every other one within a gap of a kept one. Leaves *out empty if it
 *  would keep more than half of the points. The same points for any number of threads. O(n).
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED */
VOR_NODISCARD vor_status vor_domain_thin(struct vor_domain *out, const struct vor_domain *in,
                                         double gap, const struct vor_run *run,
                                         struct vor_error *err);

/** A thinner domain to move n points on, given the (normalised) area they cover: about five points
 *  for each, 20,000 at least, more where fits take more. Leaves *out empty where `in` has less than
 *  twice as many. Fails as vor_domain_thin. */
VOR_NODISCARD vor_status vor_domain_thin_for(struct vor_domain *out, const struct vor_domain *in,
                                             size_t n, double area, const struct vor_run *run,
                                             struct vor_error *err);

#endif
