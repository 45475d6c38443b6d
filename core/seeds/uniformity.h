/** Uniformity of seeds, read off their neighbour lists instead of a search for each. */
#ifndef VOR_SEEDS_UNIFORMITY_H
#define VOR_SEEDS_UNIFORMITY_H

#include "core/metrics/cells.h"
#include "core/metrics/uniformity.h"
#include "core/seeds/seeds.h"

/** Uniformity of positions near those of the seeds' last index. Exact: the nearest neighbour is
 *  taken from the seed's list where it is certain that no other seed is nearer, else from a wider
 *  search.
 *
 *  @param[out] out      lengths in normalised units; with a density, of distances over the spacing
 *                       wanted (seeds/wanted.h)
 *  @param[out] nearest  distance of each seed to its nearest neighbour, seeds->n floats; with a
 *                       metric, in that (seeds/stretched.h), among the VOR_SEEDS_MORE_MAX nearest
 *  @param[in]  xyz      the positions, seeds->n x 3
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *  @retval VOR_E_NOMEM
 *
 *  O(n) while positions are near those of the index, O(n log n) else; on the run's pool. The same
 *  bits for any number of threads. */
VOR_NODISCARD vor_status vor_seeds_uniformity(struct vor_uniformity *out, float *nearest,
                                              const struct vor_seeds *seeds, const float *xyz,
                                              const struct vor_run *run, struct vor_error *err);

/** Distances of the seeds to their nearest neighbours where they are, whatever their metric: n
 *  floats. Fails as vor_seeds_uniformity; O(n log n). */
VOR_NODISCARD vor_status vor_seeds_distances(float *nearest, const struct vor_seeds *seeds,
                                             struct vor_error *err);

/** Measures the cells of the seeds, as of the last index; with a metric, in that. Fails as
 *  vor_cells_of; O(n). */
VOR_NODISCARD vor_status vor_seeds_cells(struct vor_cells *out, struct vor_seeds *seeds,
                                         struct vor_error *err);

/** Indexes the seeds where they are, then vor_seeds_uniformity of them. A stop does not interrupt
 *  it, so that the run has something to hand back. */
VOR_NODISCARD vor_status vor_seeds_uniformity_now(struct vor_uniformity *out, float *nearest,
                                                  struct vor_seeds *seeds, struct vor_error *err);

#endif
