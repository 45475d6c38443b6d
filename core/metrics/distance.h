/** Distances between two clouds, in the unit of their positions. */
#ifndef VOR_METRICS_DISTANCE_H
#define VOR_METRICS_DISTANCE_H

#include "core/base/run.h"

/** Each member as in struct vor_measure (report.h), which has its definition. */
struct vor_distances {
    double far_over_knn6_mean, far_over_knn6_p999;
    double out_to_ref_mean, out_to_ref_rms, out_to_ref_max;
    double ref_to_out_mean, ref_to_out_rms, ref_to_out_max;
    double hausdorff, hausdorff_relative, chamfer;
};

/** Measures the distances from n points to m reference points and back.
 *
 *  @param[out] out             written only when VOR_OK is returned
 *  @param[in]  xyz, reference  n x 3 and m x 3 floats in one frame, each of magnitude at most 1e6
 *
 *  @retval VOR_E_DEGENERATE m < 7, or the reference has no extent
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log m + m log n + m log m), on the run's pool. The same bits for any number of threads. */
VOR_NODISCARD vor_status vor_distances_measure(struct vor_distances *out, const float *xyz,
                                               size_t n, const float *reference, size_t m,
                                               const struct vor_run *run, struct vor_error *err);

#endif
