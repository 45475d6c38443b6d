/** The geometric error of a result: how far the points of an input are from the surface that the
 *  points of the result stand for.
 *
 *  Source: Lv et al. 2022, "Intrinsic and isotropic resampling for 3D point clouds", Tables 1, 3
 *  and 4. The paper gives no formula; its authors' program moves each point of the input by Eq. 1,
 *  at most ten times, on its twelve nearest points of the result with weights exp(-d^2 / h^2). h is
 *  the largest distance of a point of the result to its twelfth neighbour; normals are of planes
 *  through twenty points, and their weighted mean is not made a unit vector again. The error is how
 *  far a point has moved in all, where the longest side of the input's bounding box is 2.
 *  Departure: normals are given the side of the nearest point's before they are averaged; the
 *  program takes them with the sign that the fit happens to give.
 *
 *  Most of it is the blur of the weights, which grows with curvature times spacing^2: points that
 *  lie exactly on a surface have an error too. It compares results with the same number of points.
 */
#ifndef VOR_METRICS_MLS_ERROR_H
#define VOR_METRICS_MLS_ERROR_H

#include "core/base/run.h"

struct vor_knn;

/** Fewest points of a result that has such an error: a point and twelve neighbours. */
enum { VOR_MLS_ERROR_LEAST = 13 };

/** Largest and mean error; no unit. */
struct vor_mls_error {
    double max, mean;
};

/** Two clouds in one frame. */
struct vor_mls_error_of {
    const float *xyz;          /**< n x 3: the result */
    size_t n;                  /**< VOR_MLS_ERROR_LEAST or more */
    const struct vor_knn *knn; /**< over xyz, made by vor_knn_build_along */
    const float *input;        /**< m x 3 */
    size_t m;
    size_t most; /**< points of the input that are measured, at equal steps, if it has more */
};

/** Measures the error.
 *
 *  @retval VOR_E_NOMEM 12 bytes for each point of the result, and a little, do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O((n + most) log n), 3 us of CPU a point, on the run's pool. The same bits for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_mls_error_measure(struct vor_mls_error *out,
                                               const struct vor_mls_error_of *of,
                                               const struct vor_run *run, struct vor_error *err);

#endif
