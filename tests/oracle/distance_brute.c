/* Oracle: distances between clouds against a look at every pair. */
#include "core/metrics/distance.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>

enum { SEEDS = 20 };

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Sorted distances from x to every point. */
static void distances_from(double *out, const struct vor_cloud *to, const float *x)
{
    for (size_t i = 0; i < to->n; i++) {
        out[i] = 0;
        for (size_t c = 0; c < 3; c++)
            out[i] += pow((double)to->xyz[3 * i + c] - (double)x[c], 2);
        out[i] = sqrt(out[i]);
    }
    qsort(out, to->n, sizeof *out, ascending);
}

/* kth[i] gets the distance of point i of `from` to its nearest point number k of `to`. */
static void kth_from(double *kth, const struct vor_cloud *from, const struct vor_cloud *to,
                     size_t k)
{
    double *all = malloc(to->n * sizeof *all);

    ck_assert_ptr_nonnull(all);
    for (size_t i = 0; i < from->n; i++) {
        distances_from(all, to, &from->xyz[3 * i]);
        kth[i] = all[k];
    }
    free(all);
}

static double mean_of(const double *d, size_t n)
{
    double sum = 0;

    for (size_t i = 0; i < n; i++)
        sum += d[i];
    return sum / (double)n;
}

static double rms_of(const double *d, size_t n)
{
    double sum = 0;

    for (size_t i = 0; i < n; i++)
        sum += d[i] * d[i];
    return sqrt(sum / (double)n);
}

static double diagonal_of(const struct vor_cloud *cloud)
{
    double sum = 0;

    for (size_t c = 0; c < 3; c++) {
        double low = INFINITY, high = -INFINITY;

        for (size_t i = 0; i < cloud->n; i++) {
            low = fmin(low, (double)cloud->xyz[3 * i + c]);
            high = fmax(high, (double)cloud->xyz[3 * i + c]);
        }
        sum += (high - low) * (high - low);
    }
    return sqrt(sum);
}

VT_TEST_LOOP(the_distances_are_those_of_a_look_at_every_pair, SEEDS)
{
    uint64_t seed = (uint64_t)_i;
    size_t n = 1 + (size_t)vor_rng_below(seed, 31, 0, 400);
    size_t m = 7 + (size_t)vor_rng_below(seed, 31, 1, 500);
    double *d = malloc((n + m) * sizeof *d), diagonal, knn6, rank, far, p999;
    struct vt_engine engine;
    struct vor_cloud cloud, reference;
    struct vor_distances found;

    vt_engine_open(&engine, 2);
    vt_cloud_cube(&cloud, seed, n);
    vt_cloud_sphere(&reference, seed, m);
    vt_assert_ok(
        vor_distances_measure(&found, cloud.xyz, n, reference.xyz, m, &engine.run, &vt_err));
    diagonal = diagonal_of(&reference);
    kth_from(d, &cloud, &reference, 0);
    ck_assert_double_eq_tol(found.out_to_ref_mean, mean_of(d, n), 1e-6);
    ck_assert_double_eq_tol(found.out_to_ref_rms, rms_of(d, n), 1e-6);
    qsort(d, n, sizeof *d, ascending);
    far = d[n - 1];
    ck_assert_double_eq_tol(found.out_to_ref_max, far, 1e-6);
    kth_from(d, &reference, &cloud, 0);
    ck_assert_double_eq_tol(found.ref_to_out_mean, mean_of(d, m), 1e-6);
    ck_assert_double_eq_tol(found.ref_to_out_rms, rms_of(d, m), 1e-6);
    qsort(d, m, sizeof *d, ascending);
    ck_assert_double_eq_tol(found.ref_to_out_max, d[m - 1], 1e-6);
    ck_assert_double_eq_tol(found.hausdorff, fmax(far, d[m - 1]), 1e-6);
    ck_assert_double_eq_tol(found.hausdorff_relative * diagonal, fmax(far, d[m - 1]), 1e-6);
    kth_from(d, &reference, &reference, 6);
    knn6 = mean_of(d, m);
    qsort(d, m, sizeof *d, ascending);
    rank = 0.999 * (double)(m - 1);
    p999 = d[(size_t)rank] + (rank - floor(rank)) * (d[(size_t)rank + 1] - d[(size_t)rank]);
    ck_assert_double_eq_tol(found.far_over_knn6_mean, far / knn6, 1e-5);
    ck_assert_double_eq_tol(found.far_over_knn6_p999, far / p999, 1e-5);
    free(d);
    vt_engine_close(&engine);
    vt_free_last(&reference, &cloud);
}
