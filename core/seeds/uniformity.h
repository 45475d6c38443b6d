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
VOR_NODISCARD vor_status vor_even_measure(struct vor_uniformity *out, float *nearest,
                                          const struct vor_seeds *seeds, const float *xyz,
                                          struct vor_error *err);

/** Share of the seeds, as of the last index, whose cell in the tangent plane has six sides.
 *
 *  @retval as vor_even_measure */
VOR_NODISCARD vor_status vor_even_six(double *out, struct vor_seeds *seeds, struct vor_error *err);

/** vor_even_measure of the seeds where they are, indexed first. A stop does not cut it short, so
 * that it finds something to hand back. */
VOR_NODISCARD vor_status vor_even_begin(struct vor_uniformity *out, float *nearest,
                                        struct vor_seeds *seeds, struct vor_error *err);

#endif
