/* Oracle: distances between clouds against a look at every pair. */
#include "core/base/stat.h"
#include "core/geom/plane.h"
#include "core/knn/knn.h"
#include "core/metrics/distance.h"
#include "core/metrics/mls_error.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>

enum { SEEDS = 20 };

static void at(double x[3], const struct vor_cloud *cloud, size_t i)
{
    for (size_t c = 0; c < 3; c++)
        x[c] = (double)cloud->xyz[3 * i + c];
}

static double apart(const double a[3], const double b[3])
{
    return sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
}

/* Indices of the k points of a cloud nearest to x. Returns the distance of the last. */
static double nearest(uint32_t *index, size_t k, const struct vor_cloud *cloud, const double x[3])
{
    double least = 0;

    for (size_t j = 0; j < k; j++) {
        least = INFINITY;
        for (size_t i = 0; i < cloud->n; i++) {
            double y[3];
            int taken = 0;

            at(y, cloud, i);
            for (size_t before = 0; before < j; before++)
                taken |= index[before] == i;
            if (!taken && apart(x, y) < least) {
                least = apart(x, y);
                index[j] = (uint32_t)i;
            }
        }
    }
    return least;
}

/* kth[i] gets the distance of point i of `from` to its nearest point number k of `to`. */
static void kth_from(double *kth, const struct vor_cloud *from, const struct vor_cloud *to,
                     size_t k)
{
    for (size_t i = 0; i < from->n; i++) {
        uint32_t index[7];
        double x[3];

        at(x, from, i);
        kth[i] = nearest(index, k + 1, to, x);
    }
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

static double diagonal_of(const struct vor_cloud *cloud, double *longest)
{
    double sum = 0;

    *longest = 0;

    for (size_t c = 0; c < 3; c++) {
        double low = INFINITY, high = -INFINITY;

        for (size_t i = 0; i < cloud->n; i++) {
            low = fmin(low, (double)cloud->xyz[3 * i + c]);
            high = fmax(high, (double)cloud->xyz[3 * i + c]);
        }
        sum += (high - low) * (high - low);
        *longest = fmax(*longest, high - low);
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
    diagonal = diagonal_of(&reference, &rank);
    kth_from(d, &cloud, &reference, 0);
    ck_assert_double_eq_tol(found.out_to_ref_mean, mean_of(d, n), 1e-6);
    ck_assert_double_eq_tol(found.out_to_ref_rms, rms_of(d, n), 1e-6);
    vor_sort_doubles(d, n);
    far = d[n - 1];
    ck_assert_double_eq_tol(found.out_to_ref_max, far, 1e-6);
    kth_from(d, &reference, &cloud, 0);
    ck_assert_double_eq_tol(found.ref_to_out_mean, mean_of(d, m), 1e-6);
    ck_assert_double_eq_tol(found.ref_to_out_rms, rms_of(d, m), 1e-6);
    vor_sort_doubles(d, m);
    ck_assert_double_eq_tol(found.ref_to_out_max, d[m - 1], 1e-6);
    ck_assert_double_eq_tol(found.hausdorff, fmax(far, d[m - 1]), 1e-6);
    ck_assert_double_eq_tol(found.hausdorff_relative * diagonal, fmax(far, d[m - 1]), 1e-6);
    kth_from(d, &reference, &reference, 6);
    knn6 = mean_of(d, m);
    vor_sort_doubles(d, m);
    rank = 0.999 * (double)(m - 1);
    p999 = d[(size_t)rank] + (rank - floor(rank)) * (d[(size_t)rank + 1] - d[(size_t)rank]);
    ck_assert_double_eq_tol(found.far_over_knn6_mean, far / knn6, 1e-5);
    ck_assert_double_eq_tol(found.far_over_knn6_p999, far / p999, 1e-5);
    free(d);
    vt_engine_close(&engine);
    vt_free_last(&reference, &cloud);
}

/* The plane through the twenty points nearest to point i. Returns the distance to number 12. */
static double plane_at(struct vor_plane *plane, const struct vor_cloud *cloud, size_t i)
{
    uint32_t index[20];
    double x[3];

    at(x, cloud, i);
    (void)nearest(index, 20, cloud, x);
    vor_plane_fit(plane, cloud->xyz, index, 20);
    return nearest(index, 13, cloud, x);
}

/* How far ten steps of Eq. 1 of Lv 2022 move p. */
static double moved(const struct vor_cloud *cloud, const struct vor_plane *plane, double h,
                    const double p[3])
{
    double x[3] = {p[0], p[1], p[2]};
    uint32_t index[12];

    (void)nearest(index, 12, cloud, p);
    for (int step = 0; step < 10; step++) {
        double total = 0, a[3] = {0}, n[3] = {0}, off = 0;

        for (int j = 0; j < 12; j++) {
            const float *of = plane[index[j]].normal, *first = plane[index[0]].normal;
            double q[3], weight;
            float side = of[0] * first[0] + of[1] * first[1] + of[2] * first[2];

            at(q, cloud, index[j]);
            weight =
                exp(-(pow(q[0] - x[0], 2) + pow(q[1] - x[1], 2) + pow(q[2] - x[2], 2)) / h / h);
            total += weight;
            for (int c = 0; c < 3; c++) {
                a[c] += weight * q[c];
                n[c] += weight * (double)copysignf(of[c], side * of[c]);
            }
        }
        for (int c = 0; c < 3; c++)
            off += n[c] / total * (x[c] - a[c] / total);
        for (int c = 0; c < 3; c++)
            x[c] -= off * n[c] / total;
    }
    return apart(x, p);
}

VT_TEST_LOOP(the_geometric_error_is_that_of_a_look_at_every_pair, 4)
{
    uint64_t seed = (uint64_t)_i;
    size_t n = 150 + (size_t)vor_rng_below(seed, 32, 0, 200), m = 100;
    struct vor_plane *plane = malloc(n * sizeof *plane);
    double h = 0, max = 0, mean = 0, longest;
    struct vor_mls_error found;
    struct vt_engine engine;
    struct vor_cloud cloud, input;
    struct vor_knn *knn;

    vt_engine_open(&engine, 2);
    vt_cloud_sphere(&cloud, seed, n);
    vt_cloud_sphere(&input, seed + SEEDS, m);
    for (size_t i = 0; i < 3 * m; i++)
        input.xyz[i] *= 1.1F;
    for (size_t i = 0; i < n; i++)
        h = fmax(h, plane_at(&plane[i], &cloud, i));
    for (size_t i = 0; i < m; i++) {
        double p[3], error;

        at(p, &input, i);
        error = moved(&cloud, plane, h, p);
        max = fmax(max, error);
        mean += error / (double)m;
    }
    vt_assert_ok(vor_knn_build_along(&knn, cloud.xyz, n, &engine.run, &vt_err));
    vt_assert_ok(vor_mls_error_measure(
        &found, &(struct vor_mls_error_of){cloud.xyz, n, knn, input.xyz, m, m}, &engine.run,
        &vt_err));
    (void)diagonal_of(&input, &longest);
    ck_assert_double_eq_tol(found.max, 2 * max / longest, 1e-5);
    ck_assert_double_eq_tol(found.mean, 2 * mean / longest, 1e-5);
    vor_knn_free(knn);
    free(plane);
    vt_engine_close(&engine);
    vt_free_last(&input, &cloud);
}
