/** The method `kmeans`: discrete k-means of the input points, a baseline that other methods are
 * held against.
 *
 *  Source: the k-means clustering that Chen et al. 2018, "Point cloud resampling using centroidal
 *  Voronoi tessellation methods", Sec. 5.1, compare with; Lloyd 1982, "Least squares quantization
 *  in PCM". The points start at a random subset of the input. An iteration assigns each input point
 *  to the nearest of them, and moves each to the mean of those that were assigned to it.
 *
 *  Departure: at the end the points are put onto the surface around them and kept inside the input,
 *  as with every method; means lie off a curved surface, on its hollow side.
 *  Departure: the result is the most even iterate of all.
 *
 *  Its limits: it needs as many input points as it makes, and follows their density: what is
 * sampled more densely gets more points. Nothing keeps a mean from joining two sheets. Polish and
 * anderson are not part of it, so that it stays a baseline. */
#ifndef VOR_KMEANS_KMEANS_H
#define VOR_KMEANS_KMEANS_H

#include "core/method.h"

/** Iterations where the request gives no number: those of Chen et al. 2018, Sec. 5. */
#define VOR_KMEANS_ITERATIONS 35

/** A vor_method's run (core/method.h). Goes through the stage ITERATE.
 *
 *  @param[out] out   free with vor_seeds_free; untouched on failure
 *  @param[in]  spec  read: seed, boundary, patch, iterations, delta, seconds
 *
 *  @retval VOR_E_TARGET  the input has fewer than n points at different places
 *  @retval VOR_E_DENSITY, VOR_E_METRIC  a density or metric is asked for, which it does not follow
 *  @retval VOR_E_PARAM    sites are asked for, which it has none of
 *  @retval VOR_E_CANCELLED, VOR_E_NOMEM  88 n bytes (the index of the seeds among them) and 4
 *                               for each input point do not fit
 *
 *  O(N log n) an iteration, on the run's pool; the sums on one thread. The same points for any
 *  number of threads. */
VOR_NODISCARD vor_status vor_kmeans_run(struct vor_seeds *out, struct vor_outcome *told,
                                        const struct vor_domain *domain, size_t n,
                                        const struct vor_spec *spec, const struct vor_run *run,
                                        struct vor_error *err);

#endif
