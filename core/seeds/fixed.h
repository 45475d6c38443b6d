/** Points of a result that do not move. */
#ifndef VOR_SEEDS_FIXED_H
#define VOR_SEEDS_FIXED_H

#include "core/seeds/seeds.h"

/** Adds the islands' share of the points after the seeds as points that do not move, and puts the
 *  islands' input points back into the domain. Counters stay. Where there are no islands it does
 *  nothing.
 *
 *  @param[in,out] seeds         may be all zero: then all points are fixed ones; on failure as
 *                               they were, or all zero
 *  @param[out]    delta_beside  delta of the seeds as they come; as it was, where there are none
 *  @param[in,out] domain        must outlive the seeds, as must run's watches
 *  @param[in]     share         of all points, vor_islands_share; a stop does not lose one
 *
 *  @retval VOR_E_NOMEM  as vor_seeds_init
 *  @retval VOR_E_CANCELLED
 *
 *  O(n + N). */
VOR_NODISCARD vor_status vor_seeds_add_islands(struct vor_seeds *seeds, double *delta_beside,
                                               struct vor_domain *domain, size_t share,
                                               struct vor_seeds_policy policy,
                                               const struct vor_run *run, struct vor_error *err);

#endif
