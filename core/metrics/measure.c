#include "core/metrics/measure.h"

#include "core/cloud/frame.h"
#include "core/knn/knn.h"
#include "core/metrics/cells.h"
#include "core/metrics/distance.h"
#include "core/metrics/distortion.h"
#include "core/metrics/mls_error.h"
#include "core/metrics/uniformity.h"

#include <assert.h>
#include <math.h>

static vor_status measure_even(struct vor_measure *out, const float *xyz, size_t n, double unit,
                               const struct vor_run *run, struct vor_error *err)
{
    struct vor_uniformity even = {0};
    struct vor_cells cells = {0};
    struct vor_knn *knn = NULL;
    vor_status status = vor_knn_build(&knn, xyz, n, run->memory, err);

    VOR_THEN(status, vor_uniformity_indexed(&even, xyz, n, knn, run, err));
    VOR_THEN(status, vor_cells_measure(&cells, xyz, n, knn, run, err));
    vor_knn_free(knn);
    if (status != VOR_OK)
        return status;
    if (!(even.mean > 0))
        return vor_fail(err, VOR_E_DEGENERATE,
                        "all %zu points are at the same position, want at least two different "
                        "positions",
                        n);
    *out = (struct vor_measure){.n = n,
                                .delta = even.delta,
                                .sigma = even.sigma * unit,
                                .epsilon = even.epsilon,
                                .mean_nn = even.mean * unit,
                                .min_over_mean = even.min / even.mean,
                                .max_over_mean = even.max / even.mean,
                                .coincident = even.coincident,
                                .six_share = cells.six,
                                .has_cells = cells.open < n,
                                .eta = cells.eta,
                                .gap = cells.gap,
                                .wide = cells.wide,
                                .open = cells.open};
    return VOR_OK;
}

static vor_status measure_error(struct vor_measure *measure, const struct vor_distortion_pair *pair,
                                const struct vor_run *run, struct vor_error *err)
{
    struct vor_mls_error error;
    struct vor_knn *knn = NULL;
    vor_status status;

    if (pair->n < VOR_MLS_ERROR_LEAST)
        return VOR_OK;
    status = vor_knn_build_along(&knn, pair->xyz, pair->n, run, err);
    if (status == VOR_OK)
        status = vor_mls_error_measure(
            &error,
            &(struct vor_mls_error_of){pair->xyz, pair->n, knn, pair->reference, pair->m, pair->m},
            run, err);
    vor_knn_free(knn);
    if (status != VOR_OK)
        return status;
    measure->has_mls_error = 1;
    measure->mls_error_max = error.max;
    measure->mls_error_mean = error.mean;
    return VOR_OK;
}

/* Adds the distances between two clouds in a frame of that unit. */
static vor_status measure_against(struct vor_measure *measure,
                                  const struct vor_distortion_pair *pair, double unit, double peak,
                                  const struct vor_run *run, struct vor_error *err)
{
    struct vor_distances distances;
    struct vor_distortion distortion;
    vor_status status =
        vor_distances_measure(&distances, pair->xyz, pair->n, pair->reference, pair->m, run, err);

    VOR_THEN(status, vor_distortion_measure(&distortion, pair, run, err));
    VOR_THEN(status, measure_error(measure, pair, run, err));
    if (status != VOR_OK)
        return status;
    measure->has_reference = 1;
    measure->far_over_knn6_mean = distances.far_over_knn6_mean;
    measure->far_over_knn6_p999 = distances.far_over_knn6_p999;
    measure->out_to_ref_mean = distances.out_to_ref_mean * unit;
    measure->out_to_ref_rms = distances.out_to_ref_rms * unit;
    measure->out_to_ref_max = distances.out_to_ref_max * unit;
    measure->ref_to_out_mean = distances.ref_to_out_mean * unit;
    measure->ref_to_out_rms = distances.ref_to_out_rms * unit;
    measure->ref_to_out_max = distances.ref_to_out_max * unit;
    measure->hausdorff = distances.hausdorff * unit;
    measure->hausdorff_relative = distances.hausdorff_relative;
    measure->chamfer = distances.chamfer * unit;
    measure->peak = peak > 0 ? peak : distortion.peak * unit;
    measure->d1_mse = distortion.d1_mse * unit * unit;
    measure->d2_mse = distortion.d2_mse * unit * unit;
    measure->d1_psnr = vor_distortion_psnr(distortion.d1_mse, measure->peak / unit);
    measure->d2_psnr = vor_distortion_psnr(distortion.d2_mse, measure->peak / unit);
    return VOR_OK;
}

vor_status vor_measure_clouds(struct vor_measure *out, const struct vor_cloud *cloud,
                              const struct vor_cloud *reference, double peak,
                              const struct vor_run *run, struct vor_error *err)
{
    struct vor_frame frame;
    struct vor_measure measure;
    float *xyz = NULL, *other = NULL;
    vor_status status;

    assert(peak == 0 || (isfinite(peak) && peak > 0));
    vor_frame_choose(&frame, cloud, reference);
    status = vor_frame_positions(&xyz, cloud, &frame, run->memory, err);
    VOR_THEN(status, measure_even(&measure, xyz, cloud->n, frame.unit, run, err));
    if (status == VOR_OK && reference != NULL)
        status = vor_frame_positions(&other, reference, &frame, run->memory, err);
    if (status == VOR_OK && reference != NULL) {
        struct vor_distortion_pair pair = {xyz, other, cloud->n, reference->n,
                                           vor_cloud_find(reference, VOR_NORMAL)};

        status = measure_against(&measure, &pair, frame.unit, peak, run, err);
    }
    measure.invalid = cloud->notes.invalid;
    if (status == VOR_OK)
        *out = measure;
    VOR_FREE_ALL(run->memory, other, xyz);
    return status;
}
