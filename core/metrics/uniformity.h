/** How evenly points are spread, from d_i, the distance of point i to its nearest other point.
 *
 *  Source: Xiao et al. 2024, "Accelerated Lloyd's method for resampling 3D point clouds", Eq. 6 and
 *  Sec. V-B. */
#ifndef VOR_METRICS_UNIFORMITY_H
#define VOR_METRICS_UNIFORMITY_H

#include "core/base/run.h"
#include "core/knn/knn.h"

/** Invariant: epsilon == 1 / sqrt(1 + delta^2). With one point, or if all coincide, epsilon is 1
 *  and the other distances 0. */
struct vor_uniformity {
    double delta;   /**< rms of d_i / mean(d) - 1; no unit, >= 0, lower is better. Eq. 6 */
    double sigma;   /**< mean of |d_i - mean(d)|, in the cloud's own unit. Sec. V-B */
    double epsilon; /**< cosine between (d_i) and its mean, in (0, 1], higher is better. Sec. V-B */
    double mean, min, max; /**< of d_i */
    size_t coincident;     /**< d_i that are 0 */
};

/** Computes *out from n distances d_i. Sums run in index order. Cannot fail. O(n). */
void vor_uniformity_from(struct vor_uniformity *out, const float *nearest, size_t n);

/** Finds the distance of each point to its nearest other point; 0 for a single point.
 *
 *  @param[out] nearest  n distances, exact to float32
 *  @param[in]  xyz      n x 3 floats
 *  @param[in]  knn      an index of these points
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n), on the run's pool. */
VOR_NODISCARD vor_status vor_nearest_distances(float *nearest, const float *xyz, size_t n,
                                               const struct vor_knn *knn, const struct vor_run *run,
                                               struct vor_error *err);

/** Finds the distance of each of n queries (n x 3) to its k-th nearest indexed point, k <=
 *  VOR_KTH_MAX. Fails and costs as vor_nearest_distances. */
VOR_NODISCARD vor_status vor_kth_distances(float *out, const float *queries, size_t n,
                                           const struct vor_knn *knn, unsigned k,
                                           const struct vor_run *run, struct vor_error *err);
enum { VOR_KTH_MAX = 7 };

/** Measures how evenly n points (n x 3) are spread, by an index of them. Fails as
 *  vor_uniformity_measure; O(n log n). */
VOR_NODISCARD vor_status vor_uniformity_indexed(struct vor_uniformity *out, const float *xyz,
                                                size_t n, const struct vor_knn *knn,
                                                const struct vor_run *run, struct vor_error *err);

/** Measures how evenly n points (n x 3) are spread. Fails as vor_nearest_distances.
 *
 *  @retval VOR_E_NOMEM  the index or 4 n bytes do not fit
 *
 *  O(n log n), on the run's pool. */
VOR_NODISCARD vor_status vor_uniformity_measure(struct vor_uniformity *out, const float *xyz,
                                                size_t n, const struct vor_run *run,
                                                struct vor_error *err);

#endif
