/** Fills a hole: points on a smooth surface that carries on what lies around it.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 *  methods", Sec. 5.6, fills holes with the planes of the points around them, and names surfaces of
 *  higher order as what curved ones need.
 *  Departure: a spline (geom/spline.h) through the points around the loop, laid out in a plane
 *  (input/band.h). It is known before any seed moves, so that seeds need not find their way into
 *  the hole, and is as smooth as what surrounds it. Where creases run into the hole
 *  (input/hole_sides.h), each smooth side has its own spline, and the surface is the highest or the
 *  lowest of them, so that it has the creases too. Points as far apart as those of the input are
 *  put on it, which are input points from then on. */
#ifndef VOR_INPUT_FILL_H
#define VOR_INPUT_FILL_H

#include "core/input/band.h"

/** Most spacings squared of the box around a hole in the plane; a larger one stays open. */
#define VOR_FILL_POINTS 1000000

/** Holes of a domain being filled. */
struct vor_filling {
    const struct vor_domain *domain; /**< has lists (input/lists.h) */
    const struct vor_loops *loops;   /**< its loops */
    struct vor_band_search search;
    size_t n, room;   /**< points that holes were filled with; that there is room for */
    float *xyz;       /**< n x 3, in the domain's normalised coordinates */
    uint32_t *source; /**< n: as the domain's, of the point nearest to each */
};

/** Begins with no points; borrows the domain and its loops.
 *
 *  @param[out] out  free with vor_filling_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 12 bytes a point do not fit */
VOR_NODISCARD vor_status vor_filling_init(struct vor_filling *out, const struct vor_domain *domain,
                                          const struct vor_loops *loops, struct vor_error *err);

/** Fills the hole of a loop.
 *
 *  @param[in,out] filling  its points are added
 *  @param[out]    closed   0, and nothing is added, where the hole cannot be closed: the points
 *                          around it determine no surface, it would take more than VOR_FILL_POINTS,
 *                          another part of the input is where they would go, or the run is late
 *  @param[in]     loop     0 .. loops->count - 1
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(m^3 + p m + b (m + log b)), m some of the b points around the loop, 400 at most, p those it is
 *  filled with; on the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_fill_hole(struct vor_filling *filling, int *closed, size_t loop,
                                       const struct vor_run *run, struct vor_error *err);

/** filling may be all zero. */
void vor_filling_free(struct vor_filling *filling);

#endif
