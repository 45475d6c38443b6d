/** Edges told from bends, among the smoothed data of ear.
 *
 *  Source: none of the papers. Where noise is as wide as the neighbourhoods of normals, points of a
 *  torus or a limb seem to lie on edges, and a projection onto sides makes facets of them. In a
 *  region where the points that seem to lie on edges lie nearly as near to surfaces fitted around
 *  them as to these sides, the surface bends. Departure: Huang et al. (2013) take every point for
 *  one of a side.
 *
 *  Measured, noise of 0.3 spacings, a torus of 12,000 points beside a cube of 3,000, three draws:
 *  the torus' rms over the input's 1.0 without this, .38 to .52 with it; from the cube's edges to
 *  the nearest point as without it in two, .361 for .301 spacings in one. */
#ifndef VOR_LOP_BENDS_H
#define VOR_LOP_BENDS_H

#include "core/input/domain.h"
#include "core/lop/samples.h"

/** What to do about points that seem to lie on edges. */
struct vor_lop_bends_how {
    const unsigned char *flag; /**< n: 1 for those, else 0 */
    int put;                   /**< move data; else regions are only counted */
};

/** Puts the data of regions that bend onto the surfaces fitted around them, with their normals; all
 *  others stay. A region is VOR_NOISY_REGION points (core/input/noisy.h) that follow
 *  each other in the domain.
 *
 *  @param[out]    on_edges  flagged points in the regions that do not bend
 *  @param[in,out] data      the points of the domain, smoothed
 *  @param[in]     domain    read: xyz, lists, neighbours
 *  @param[in]     run       whole: it is not stopped
 *
 *  @retval VOR_E_NOMEM
 *
 *  On the run's pool, a fit for each flagged point and each in a region that bends. The same points
 *  for any number of threads. */
VOR_NODISCARD vor_status vor_lop_bends(size_t *on_edges, struct vor_lop_samples *data,
                                       const struct vor_domain *domain,
                                       const struct vor_lop_bends_how *how,
                                       const struct vor_run *run, struct vor_error *err);

#endif
