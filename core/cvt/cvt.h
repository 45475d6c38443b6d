/** The methods `cvt`, centroidal Voronoi tessellation on local quadrics, and `insert`, its start
 *  alone between the points of the input (vor_start_between), which follow the n others in *out and
 *  do not move.
 *
 *  Source: Xiao et al. 2024, "Accelerated Lloyd's method for resampling 3D point clouds". Seeds
 *  start evenly by area (seeds/start.h), or from coarse to fine (seeds/coarse.h), move to the
 * centroids of their cells (cvt/lloyd.h), are attached to the input (seeds/attach.h) and evened out
 * (seeds/repel.h, not in the paper). Departure: all but the last iterations or steps run on a
 * thinned input where it is dense (input/thin.h); the result lies on the whole of it. */
#ifndef VOR_CVT_CVT_H
#define VOR_CVT_CVT_H

#include "core/method.h"

/** A vor_method's run (core/method.h). Goes through the stages ITERATE and, where the request
 *  allows steps of polish, POLISH.
 *
 *  @param[out] out   free with vor_seeds_free; untouched on failure
 *
 *  @param[in] spec  read: seed, boundary, iterations, delta, seconds, anderson, polish
 *
 *  @retval VOR_E_DEGENERATE no seed has a cell with area
 *  @retval VOR_E_CANCELLED, VOR_E_NOMEM
 *
 *  O(n log n) for the start and O(n) for an iteration or step. The same points for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_cvt_run(struct vor_seeds *out, struct vor_outcome *told,
                                     const struct vor_domain *domain, size_t n,
                                     const struct vor_spec *spec, const struct vor_run *run,
                                     struct vor_error *err);

#endif
