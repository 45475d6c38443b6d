/** What a result is held against: as many points of the same input by simple methods, and how even
 *  those are.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 * methods", Sec. 5.1, has k-means beside its own; random choice, voxel grid and farthest points are
 * what libraries offer.
 *
 *  Departure: none follows a density. Where the request has one, delta, sigma and epsilon are of
 *  distances over the spacing wanted all the same, as those of the result. */
#ifndef VOR_BASELINES_BASELINES_H
#define VOR_BASELINES_BASELINES_H

#include "core/method.h"

/** What baselines are made for; all of it is borrowed. */
struct vor_baselines_of {
    const struct vor_domain *domain; /**< the whole, islands put back */
    size_t n;                        /**< points of the result; 0 where filters made it */
    const struct vor_method *kmeans;
    const struct vor_outcome *told; /**< by the method of the result */
    const struct vor_spec *spec;    /**< read: baselines; seed, boundary, patch */
};

/** Makes the points of each baseline, one after another, and measures them. Does nothing unless the
 *  request asks for baselines and a method made the result. Goes through the stage BASELINES.
 *
 *  @param[in,out] report  of the result, told but for them; gets the members baselines and the
 *                         stage. Without them where the caller stopped the run
 *
 *  @retval VOR_E_CANCELLED
 *  @retval VOR_E_NOMEM  what the method kmeans takes for n points, or seeds (seeds/seeds.h) of up
 * to twice as many, and 24 bytes for each of these, do not fit
 *
 *  As the method kmeans in time; O(N log n) for the others. On the run's pool. The same numbers for
 *  any number of threads. */
VOR_NODISCARD vor_status vor_baselines_tell(struct vor_report *report,
                                            const struct vor_baselines_of *of,
                                            const struct vor_run *run, struct vor_error *err);

#endif
