/** How even a candidate is, from the lists of the iterate it came from. */
#ifndef VOR_SEEDS_UNIFORMITY_H
#define VOR_SEEDS_UNIFORMITY_H

#include "core/metrics/uniformity.h"
#include "core/seeds/seeds.h"

/** Uniformity of the positions xyz (seeds->n x 3), to which the seeds came from those of the last
 *  index. Exact: the nearest neighbour is looked for in the seed's list, and wherever a seed from
 *  beyond the list could have come nearer, by a wider search.
 *
 *  @param[out] nearest  distance of every seed to its nearest neighbour, n floats
 *
 *  Lengths in normalised units.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_seeds_uniformity(struct vor_uniformity *out, float *nearest,
                                              const struct vor_seeds *seeds, const float *xyz,
                                              const struct vor_run *run, struct vor_error *err);

/** Share of the seeds, as of the last index, whose cell in the tangent plane has six sides.
 *
 *  @retval as vor_seeds_uniformity */
VOR_NODISCARD vor_status vor_seeds_six_share(double *out, struct vor_seeds *seeds,
                                             struct vor_error *err);

/** vor_seeds_uniformity of the seeds where they are, indexed first. A stop does not cut it short,
 * so that it finds something to hand back. */
VOR_NODISCARD vor_status vor_seeds_uniformity_now(struct vor_uniformity *out, float *nearest,
                                                  struct vor_seeds *seeds, struct vor_error *err);

#endif
