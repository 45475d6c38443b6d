/** Where the seeds come to rest: inside the input, and on all of it. */
#ifndef VOR_SEEDS_ATTACH_H
#define VOR_SEEDS_ATTACH_H

#include "core/seeds/seeds.h"

/** Pulls seeds that lie outside the input up to where a result may be; nothing where
 *  seeds->keep_border is not set.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for */
VOR_NODISCARD vor_status vor_attach(struct vor_seeds *seeds, struct vor_error *err);

/** Puts seeds that are on a thinner domain onto the whole one, projects them onto its surface and
 *  settles them; nothing where they are on it. A stop does not cut it short.
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for */
VOR_NODISCARD vor_status vor_attach_to_whole(struct vor_seeds *seeds, struct vor_error *err);

/** After a polish: whoever still is farther from the input than 1.5 times where that is sparsest
 * (vor_domain.sparse) is pulled up to that.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for */
VOR_NODISCARD vor_status vor_attach_last(struct vor_seeds *seeds, struct vor_error *err);

#endif
