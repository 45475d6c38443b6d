/** Points of a result that do not move. */
#ifndef VOR_SEEDS_FIXED_H
#define VOR_SEEDS_FIXED_H

#include "core/seeds/seeds.h"

/** Points that do not move; borrowed. */
struct vor_fixed {
    const float *xyz; /**< n x 3, normalised */
    size_t n;
};

/** Adds fixed points after the seeds, and puts all of them onto a domain with the same coordinates.
 *  Counters stay.
 *
 *  @param[in,out] seeds   may be all zero: then all points are fixed ones; as it was, or all zero,
 *                         on failure
 *  @param[in]     domain  must outlive the seeds, as must run's watches
 *
 *  @retval VOR_E_NOMEM  as vor_seeds_init
 *
 *  O(n). */
VOR_NODISCARD vor_status vor_seeds_add_fixed(struct vor_seeds *seeds, struct vor_fixed fixed,
                                             const struct vor_domain *domain,
                                             struct vor_seeds_policy policy,
                                             const struct vor_run *run, struct vor_error *err);

#endif
