/** How long cells are over their width, beside what a metric asks for. */
#ifndef VOR_SEEDS_ASPECTS_H
#define VOR_SEEDS_ASPECTS_H

#include "core/seeds/seeds.h"

/** Over all cells: the root of the ratio of their principal second moments about their centroids in
 *  the tangent plane, 1 for a regular hexagon, and by how much that is off what the metric asks for
 *  at the seed, over the latter. */
struct vor_aspects {
    double median;
    double off_median, off_high; /**< off_high: 90th percentile */
};

/** Measures the cells of seeds that have a metric, where they are. Indexes them.
 *
 *  @retval VOR_E_NOMEM 8 n bytes do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n), on the run's pool. The same bits for any number of threads. */
VOR_NODISCARD vor_status vor_seeds_aspects(struct vor_aspects *out, struct vor_seeds *seeds,
                                           struct vor_error *err);

#endif
