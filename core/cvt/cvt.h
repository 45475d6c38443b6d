/** The method `cvt`: centroidal Voronoi tessellation on local quadrics.
 *
 *  Source: Xiao et al. 2024, "Accelerated Lloyd's method for resampling 3D point clouds". Seeds are
 *  started even by area (cvt/start.h), moved to the centroids of their cells (cvt/lloyd.h), moved
 *  inside the input, and evened out (seeds/repel.h, not in the paper). A dense input is thinned for
 *  all but the last of this (input/thin.h); the result lies on the whole of it. */
#ifndef VOR_CVT_CVT_H
#define VOR_CVT_CVT_H

#include "core/method.h"

/** A vor_method's run (core/method.h). Goes through the stages ITERATE and, where the request
 * allows steps of polish, POLISH.
 *
 *  @param[in] spec  read: seed, boundary, iterations, delta, seconds, anderson, polish
 *
 *  @retval VOR_E_DEGENERATE no seed has a cell with area
 *  @retval VOR_E_CANCELLED, VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_cvt_run(struct vor_seeds *out, struct vor_outcome *told,
                                     const struct vor_domain *domain, size_t n,
                                     const struct vor_spec *spec, const struct vor_run *run,
                                     struct vor_error *err);

#endif
