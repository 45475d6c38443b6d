/** Where the seeds come to rest: inside the input, and on all of it. */
#ifndef VOR_SEEDS_ATTACH_H
#define VOR_SEEDS_ATTACH_H

#include "core/seeds/seeds.h"

/** Moves seeds that lie outside the input onto where a result may be; nothing where
 *  seeds->policy.keep_border is not set.
 *
 *  @param[out] keep_holes  whether holes are told from gaps of the sampling (geom/boundary.h, rule
 *                          3): what the steps after this need
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for */
VOR_NODISCARD vor_status vor_attach(struct vor_seeds *seeds, int *keep_holes,
                                    struct vor_error *err);

/** Puts seeds that are on a thinner domain onto the whole one, projects them onto its surface and
 *  moves them inside; nothing where they are on it.
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for */
VOR_NODISCARD vor_status vor_attach_to_whole(struct vor_seeds *seeds, int keep_holes,
                                             struct vor_error *err);

/** After evening out: moves seeds that still are farther from the input than 1.5 times where that
 *  is sparsest (vor_domain.sparse) to that distance.
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for */
VOR_NODISCARD vor_status vor_attach_last(struct vor_seeds *seeds, struct vor_error *err);

#endif
