/* Principal curvatures of made surfaces of which the truth is known. */
#include "core/base/stat.h"
#include "core/geom/curvature.h"
#include "core/knn/knn.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { N = 50000, PLACES = 2000, K = 32 };

/* A surface and its curvatures at x, the smaller one first up to the side. */
struct truth {
    const char *name;
    void (*make)(struct vor_cloud *cloud, size_t n);
    void (*kappa)(const float *x, double kappa[2]);
};

static void make_sphere(struct vor_cloud *cloud, size_t n)
{
    vt_cloud_sphere(cloud, 1, n);
}

static void kappa_sphere(const float *x, double kappa[2])
{
    (void)x;
    kappa[0] = kappa[1] = 1;
}

static void make_cylinder(struct vor_cloud *cloud, size_t n)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double turn = 2 * M_PI * vt_unit(1, 2 * i);

        cloud->xyz[3 * i] = (float)cos(turn);
        cloud->xyz[3 * i + 1] = (float)sin(turn);
        cloud->xyz[3 * i + 2] = (float)(3 * vt_unit(1, 2 * i + 1) - 1.5);
    }
}

static void kappa_cylinder(const float *x, double kappa[2])
{
    (void)x;
    kappa[0] = 0;
    kappa[1] = 1;
}

static void make_torus(struct vor_cloud *cloud, size_t n)
{
    vt_cloud_torus(cloud, 1, n);
}

static void kappa_torus(const float *x, double kappa[2])
{
    double away = hypot((double)x[0], (double)x[1]);

    kappa[0] = (away - 1) / VT_TORUS_TUBE / away;
    kappa[1] = 1 / VT_TORUS_TUBE;
}

/* z = (x^2 - y^2) / 2 over a square. */
static void make_saddle(struct vor_cloud *cloud, size_t n)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double x = 2 * vt_unit(1, 2 * i) - 1, y = 2 * vt_unit(1, 2 * i + 1) - 1;

        cloud->xyz[3 * i] = (float)x;
        cloud->xyz[3 * i + 1] = (float)y;
        cloud->xyz[3 * i + 2] = (float)((x * x - y * y) / 2);
    }
}

static void kappa_saddle(const float *at, double kappa[2])
{
    double x = (double)at[0], y = (double)at[1], w2 = 1 + x * x + y * y;
    double gauss = -1 / (w2 * w2), mean = (y * y - x * x) / (2 * w2 * sqrt(w2));
    double apart = sqrt(mean * mean - gauss);

    kappa[0] = mean - apart;
    kappa[1] = mean + apart;
}

static const struct truth truths[] = {{"sphere", make_sphere, kappa_sphere},
                                      {"cylinder", make_cylinder, kappa_cylinder},
                                      {"torus", make_torus, kappa_torus},
                                      {"saddle", make_saddle, kappa_saddle}};

enum { TRUTHS = sizeof truths / sizeof truths[0] };

static double larger(double a, double b)
{
    return fabs(a) > fabs(b) ? fabs(a) : fabs(b);
}

/* Largest error of both curvatures over the larger one, whichever side is up. */
static double error_of(const double found[2], const double truth[2])
{
    double same = larger(found[0] - truth[0], found[1] - truth[1]);
    double other = larger(found[0] + truth[1], found[1] + truth[0]);

    return fmin(same, other) / larger(truth[0], truth[1]);
}

/* The errors at places of the cloud, ascending. */
static void errors_of(double error[PLACES], const struct truth *truth, unsigned k)
{
    struct vor_cloud cloud;
    struct vor_knn *knn;

    truth->make(&cloud, N);
    vt_assert_ok(vor_knn_build(&knn, cloud.xyz, N, &vt_memory, &vt_err));
    for (size_t i = 0; i < PLACES; i++) {
        uint32_t index[K];
        float distance2[K], near[3 * K];
        struct vor_surface surface;
        double found[2], expected[2];

        vor_knn_search(knn, &cloud.xyz[3 * i], 1, k, index, distance2);
        for (unsigned j = 0; j < k; j++)
            memcpy(&near[3 * j], &cloud.xyz[3 * (size_t)index[j]], 3 * sizeof *near);
        vor_surface_fit(&surface, near, k);
        vor_curvature_at(found, &surface, near, k);
        truth->kappa(&cloud.xyz[3 * i], expected);
        ck_assert(found[0] <= found[1]);
        error[i] = error_of(found, expected);
    }
    vor_sort_doubles(error, PLACES);
    vor_knn_free(knn);
    vor_cloud_free(&cloud);
}

/* Measured: medians to 0.01 %, 95th percentiles to 0.04 %. */
VT_TEST_LOOP(curvatures_of_exact_points_are_right_to_a_thousandth_and_nearly_all_to_a_two_hundredth,
             VT_FEWER(TRUTHS))
{
    static double error[PLACES];

    errors_of(error, &truths[_i], K);
    ck_assert_msg(error[PLACES / 2] <= 1e-3, "%s: median %g", truths[_i].name, error[PLACES / 2]);
    ck_assert_msg(error[PLACES * 95 / 100] <= 5e-3, "%s: 95th percentile %g", truths[_i].name,
                  error[PLACES * 95 / 100]);
}

VT_TEST(what_is_flat_or_no_surface_has_no_curvature)
{
    float flat[3 * K], line[3 * K];
    struct vor_surface surface;
    double kappa[2];

    for (size_t i = 0; i < K; i++) {
        for (size_t c = 0; c < 3; c++) {
            flat[3 * i + c] = c < 2 ? (float)vt_unit(1, 2 * i + c) : 0;
            line[3 * i + c] = (float)i;
        }
    }
    vor_surface_fit(&surface, flat, K);
    vor_curvature_at(kappa, &surface, flat, K);
    ck_assert(fabs(kappa[0]) < 1e-9 && fabs(kappa[1]) < 1e-9);
    vor_surface_fit(&surface, line, K);
    ck_assert_int_eq(surface.kind, VOR_SURFACE_NONE);
    vor_curvature_at(kappa, &surface, line, K);
    ck_assert(kappa[0] == 0 && kappa[1] == 0);
}
