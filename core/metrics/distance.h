/** Distances between two clouds, over the bounding-box diagonal of the second. */
#ifndef VOR_METRICS_DISTANCE_H
#define VOR_METRICS_DISTANCE_H

#include "core/base/run.h"

/** Names as in struct vor_measure (report.h). */
struct vor_distances {
    double far_over_knn6_mean, far_over_knn6_p999;
    double out_to_ref_mean, out_to_ref_rms, out_to_ref_max;
    double ref_to_out_mean, ref_to_out_rms, ref_to_out_max;
    double hausdorff, chamfer;
};

/** From n points to m reference points, both x 3 floats in one frame, each of magnitude at most
 * 1e6.
 *
 *  @retval VOR_E_DEGENERATE m < 7, or the reference has no extent
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  O(n log m + m log n + m log m). */
VOR_NODISCARD vor_status vor_distances_measure(struct vor_distances *out, const float *xyz,
                                               size_t n, const float *reference, size_t m,
                                               const struct vor_run *run, struct vor_error *err);

#endif
