/** How evenly a point set is spread, read off d_i, the distance from point i to its nearest other
 *  point.
 *
 *  Source: Xiao et al. 2024, "Accelerated Lloyd's method for resampling 3D point clouds", Eq. 6 and
 *  Sec. V-B. */
#ifndef VOR_METRICS_UNIFORMITY_H
#define VOR_METRICS_UNIFORMITY_H

#include "core/base/run.h"
#include "core/knn/knn.h"

/** Invariant: epsilon == 1 / sqrt(1 + delta^2). All zero (epsilon 1) where there is one point or
 * every point coincides. */
struct vor_uniformity {
    double delta;   /**< rms of d_i / mean(d) - 1; no unit, >= 0, lower is better. Eq. 6 */
    double sigma;   /**< mean of |d_i - mean(d)|, in the cloud's own unit. Sec. V-B */
    double epsilon; /**< cosine between (d_i) and its mean, in (0, 1], higher is better. Sec. V-B */
    double mean, min, max; /**< of d_i */
    size_t coincident;     /**< d_i that are 0 */
};

/** From n distances. Sums run in index order. O(n). */
void vor_uniformity_from(struct vor_uniformity *out, const float *nearest, size_t n);

/** nearest[i] gets the distance of point i (n x 3 floats) to its nearest other point; 0 for a
 * single point. Exact to float32. O(n log n).
 *
 *  @retval VOR_E_CANCELLED the watch ended it
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_nearest_distances(float *nearest, const float *xyz, size_t n,
                                               const struct vor_knn *knn, const struct vor_run *run,
                                               struct vor_error *err);

#endif
