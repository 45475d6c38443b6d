/** A start from coarse to fine: a quarter of the seeds are spread and evened out first, and then
 *  subdivided (seeds/subdivide.h); they themselves start so, as long as there are enough of them.
 *  Steps move coarse seeds farther, so that regions of one orientation grow larger, and faults
 *  between them are fewer.
 *
 *  Source: none of the papers. Measured, old start / this one, mean of three seeds: a sphere of
 *  200,000 random points to 5,072, cells that have not six sides 474 / 180 (12 at least), eta
 * 0.0094 / 0.0058, delta 0.0165 / 0.0150, largest gap 0.715 / 0.712 spacings, CPU 0.83 / 0.70 s. */
#ifndef VOR_SEEDS_COARSE_H
#define VOR_SEEDS_COARSE_H

#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"
#include "core/spec.h"

/** What spreads seeds: a method's stage ITERATE. */
typedef vor_status vor_coarse_spread(struct vor_seeds *seeds, struct vor_outcome *told,
                                     const struct vor_spec *spec, const struct vor_run *run,
                                     struct vor_error *err);

struct vor_coarse_how {
    vor_coarse_spread *spread;   /**< of the coarsest seeds; the others come from these */
    const struct vor_spec *spec; /**< read: as vor_start_seeds, vor_polish and `spread` do */
    const struct vor_run *run;   /**< may be stopped: then coarse seeds make no more steps */
};

/** Makes n seeds at their first positions, from coarse ones if a quarter of them show the surface:
 *  not where n is small, the request gives the number of iterations, has sites, a metric, a free
 *  border or no polish, the input has sheets or there is an earlier result, nor where edges of the
 *  coarse seeds are in doubt (vor_seeds_edges). out->coherence then says how few steps are left to
 *  do; elsewhere these are the positions of vor_start_seeds.
 *
 *  @param[out] out  free with vor_seeds_free; untouched on failure
 *
 *  @retval VOR_E_DEGENERATE no seed has a cell with area
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  O(steps n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_coarse_start(struct vor_seeds *out, const struct vor_domain *domain,
                                          size_t n, const struct vor_coarse_how *how,
                                          struct vor_error *err);

/** After a warm start: fewer iterations, and a polish of down to half as many steps. After a coarse
 *  start the polish is as at a coherence of one half (at 0.5 / 0.83, bunny to 20,000, least
 * distance to the nearest point over the mean 0.73 / 0.51, delta 0.0192 / 0.0205), and one
 * iteration is left, which measures the area: 0 / 1 / 6 change no other figure. Without a polish
 * all iterations are made. */
struct vor_spec vor_coarse_shorten(const struct vor_spec *spec, const struct vor_seeds *seeds);

#endif
