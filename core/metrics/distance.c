#include "core/metrics/distance.h"

#include "core/base/stat.h"
#include "core/knn/knn.h"
#include "core/metrics/uniformity.h"

#include <math.h>

enum { SEVENTH = 7 }; /* the sixth neighbour, as the point itself comes first */

static struct vor_stat summarise(const float *d, size_t n)
{
    struct vor_sums sums = {0};

    for (size_t i = 0; i < n; i++)
        vor_sums_add(&sums, (double)d[i], (double)d[i] * (double)d[i]);
    return vor_sums_stat(&sums, n);
}

static double diagonal(const float *xyz, size_t n)
{
    double low[3], high[3], sum = 0;

    for (size_t c = 0; c < 3; c++) {
        low[c] = high[c] = (double)xyz[c];
        for (size_t i = 1; i < n; i++) { /* fmax in this loop crashes gcc 12 for arm64 */
            double x = (double)xyz[3 * i + c];

            low[c] = x < low[c] ? x : low[c];
            high[c] = x > high[c] ? x : high[c];
        }
        sum += (high[c] - low[c]) * (high[c] - low[c]);
    }
    return sqrt(sum);
}

/* A cloud, and an index of it. */
struct indexed {
    const float *xyz;
    size_t n;
    struct vor_knn *knn;
};

/* Measures both directions and the reference's own spacing; d has room for the larger cloud. */
static vor_status measure(struct vor_distances *out, float *d, const struct indexed *cloud,
                          const struct indexed *reference, const struct vor_run *run,
                          struct vor_error *err)
{
    size_t n = cloud->n, m = reference->n;
    struct vor_stat forth, back;
    double mean;
    vor_status status = vor_kth_distances(d, cloud->xyz, n, reference->knn, 1, run, err);

    if (status != VOR_OK)
        return status;
    forth = summarise(d, n);
    status = vor_kth_distances(d, reference->xyz, m, cloud->knn, 1, run, err);
    if (status != VOR_OK)
        return status;
    back = summarise(d, m);
    out->out_to_ref_mean = forth.mean;
    out->out_to_ref_rms = forth.rms;
    out->out_to_ref_max = forth.max;
    out->ref_to_out_mean = back.mean;
    out->ref_to_out_rms = back.rms;
    out->ref_to_out_max = back.max;
    out->hausdorff = fmax(out->out_to_ref_max, out->ref_to_out_max);
    out->hausdorff_relative = out->hausdorff / diagonal(reference->xyz, m);
    out->chamfer = out->out_to_ref_mean + out->ref_to_out_mean;
    status = vor_kth_distances(d, reference->xyz, m, reference->knn, SEVENTH, run, err);
    if (status != VOR_OK)
        return status;
    mean = summarise(d, m).mean;
    out->far_over_knn6_mean = mean > 0 ? forth.max / mean : 0;
    vor_sort_floats(d, m);
    mean = vor_quantile(d, m, 0.999);
    out->far_over_knn6_p999 = mean > 0 ? forth.max / mean : 0;
    return VOR_OK;
}

vor_status vor_distances_measure(struct vor_distances *out, const float *xyz, size_t n,
                                 const float *reference, size_t m, const struct vor_run *run,
                                 struct vor_error *err)
{
    struct indexed from = {xyz, n, NULL}, to = {reference, m, NULL};
    struct vor_distances distances;
    double length = m > 0 ? diagonal(reference, m) : 0;
    float *d = NULL;
    vor_status status;

    if (m < SEVENTH || !(length > 0))
        return vor_fail(err, VOR_E_DEGENERATE,
                        "the reference has %zu points and a diagonal of %g, want at least 7 points "
                        "and a diagonal above 0",
                        m, length);
    d = vor_malloc(run->memory, n > m ? n : m, sizeof *d);
    if (d == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n > m ? n : m);
    status = vor_knn_build(&from.knn, xyz, n, run->memory, err);
    VOR_THEN(status, vor_knn_build(&to.knn, reference, m, run->memory, err));
    VOR_THEN(status, measure(&distances, d, &from, &to, run, err));
    if (status == VOR_OK)
        *out = distances;
    vor_knn_free(to.knn);
    vor_knn_free(from.knn);
    vor_free(run->memory, d);
    return status;
}
