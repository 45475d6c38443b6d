/** Points of a result that do not move. */
#ifndef VOR_SEEDS_FIXED_H
#define VOR_SEEDS_FIXED_H

#include "core/seeds/seeds.h"
#include "core/seeds/sites.h"

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

/** Adds the points of a domain after the seeds as points that do not move. Counters stay.
 *
 *  @param[in,out] seeds  may be all zero; on failure as they were, or all zero
 *
 *  @retval VOR_E_NOMEM  as vor_seeds_init
 *
 *  O(n + N). */
VOR_NODISCARD vor_status vor_seeds_add_input(struct vor_seeds *seeds,
                                             const struct vor_domain *domain,
                                             struct vor_seeds_policy policy,
                                             const struct vor_run *run, struct vor_error *err);

/** How many seeds are to be started where sites join them, so that n come of both: as many as there
 *  are sites make way for these, but half as many on borders, as a site there has half a cell. */
size_t vor_seeds_beside_sites(size_t n, const struct vor_sites *sites);

/** Adds sites after the seeds as points that do not move; as many seeds as are too many then, those
 *  nearest to the sites, are taken out. Counters stay. Does nothing where there are no sites.
 *
 *  @param[in,out] seeds  of vor_seeds_beside_sites; on failure as they were, or all zero
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n). */
VOR_NODISCARD vor_status vor_seeds_add_sites(struct vor_seeds *seeds, const struct vor_sites *sites,
                                             size_t n, const struct vor_run *run,
                                             struct vor_error *err);

#endif
