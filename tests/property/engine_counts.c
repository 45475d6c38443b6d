/* Exactly as many points as asked for, in distinct places, evenly laid. */
#include "tests/support/vt_ask.h"

#include <math.h>
#include <stdio.h>

enum { SEEDS = 3 };

static void shape(struct vor_cloud *cloud, int kind, uint64_t seed, size_t n)
{
    switch (kind) {
    case 0:
        vt_cloud_sphere(cloud, seed, n);
        break;
    case 1:
        vt_cloud_box(cloud, seed, n);
        break;
    case 2:
        vt_cloud_square(cloud, seed, n);
        break;
    default:
        vt_cloud_dome(cloud, seed, n);
    }
}

static void assert_finite(const struct vor_cloud *cloud)
{
    for (size_t i = 0; i < 3 * cloud->n; i++)
        ck_assert(isfinite(cloud->xyz[i]));
}

static void check_count(const struct vor_cloud *in, size_t n, uint64_t seed, const char *iterations)
{
    struct vor_cloud out;
    struct vor_report report;

    vt_resample(&out, &report, in, "points=%zu seed=%zu iterations=%s polish=6", n, (size_t)seed,
                iterations);
    ck_assert_uint_eq(out.n, n);
    ck_assert_uint_eq(report.points_out, n);
    assert_finite(&out);
    if (n <= in->n)
        ck_assert_uint_eq(vt_coincident(&out), 0);
    vor_cloud_free(&out);
}

VT_TEST_FIGURES(the_result_has_exactly_the_points_asked_for, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    static const size_t sizes[3] = {4, 37, 120};
    uint64_t seed = (uint64_t)_i;

    for (int kind = 0; kind < 4; kind++)
        for (int s = 0; s < 3; s++) {
            size_t n = sizes[s] + (s > 0 ? (size_t)_i : 0);
            const size_t wanted[9] = {1, 2, 3, 7, n - 1, n, n + 1, 4 * n, 16 * n};
            struct vor_cloud in;

            shape(&in, kind, seed, n);
            for (int w = 0; w < 9; w++)
                check_count(&in, wanted[w], seed, w % 3 == 0 ? "0" : "2");
            vor_cloud_free(&in);
            vt_assert_no_leak();
        }
}

static size_t count_of(const char *name, const char *text, const struct vor_cloud *in)
{
    struct vt_engine engine;
    struct vor_cloud out;
    struct vor_report report;
    size_t n;

    vt_engine_open(&engine, 2);
    vt_engine_set(&engine, name, text);
    vt_ask_set(&engine, "iterations=0 polish=0");
    vt_engine_resample(&engine, &out, &report, in);
    n = out.n;
    ck_assert(report.parameters.value[VOR_PARAM_POINTS] == (double)n);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return n;
}

VT_TEST(a_ratio_is_of_the_inputs_points)
{
    struct vor_cloud in;

    vt_cloud_sphere(&in, 1, 1001);
    ck_assert_uint_eq(count_of("ratio", "0.1", &in), 100);
    ck_assert_uint_eq(count_of("ratio", "0.0014", &in), 1);
    ck_assert_uint_eq(count_of("ratio", "1", &in), 1001);
    ck_assert_uint_eq(count_of("ratio", "2.5", &in), 2502);
    vor_cloud_free(&in);
}

/* n = area / (sqrt(3)/2 spacing^2) with the true area. */
static void check_spacing(const struct vor_cloud *in, double area, double spacing, double within)
{
    char text[32];
    double wanted = area / (sqrt(3) / 2 * spacing * spacing);
    size_t n;

    (void)snprintf(text, sizeof text, "%.17g", spacing);
    n = count_of("spacing", text, in);
    ck_assert_msg(fabs((double)n / wanted - 1) < within, "%zu points for spacing %g, want %g", n,
                  spacing, wanted);
}

VT_TEST_FIGURES(a_spacing_becomes_points_by_the_area, VT_FEWER(SEEDS))
{
    struct vor_cloud in;

    vt_cloud_sphere(&in, (uint64_t)_i, 10000);
    check_spacing(&in, 4 * M_PI, 0.1, 0.04);
    check_spacing(&in, 4 * M_PI, 0.3, 0.04);
    vor_cloud_free(&in);
    vt_cloud_square(&in, (uint64_t)_i, 10000);
    check_spacing(&in, 1, 0.02, 0.03);
    for (size_t i = 0; i < 3 * in.n; i++)
        in.xyz[i] *= 1000;
    check_spacing(&in, 1e6, 35, 0.03);
    vor_cloud_free(&in);
}

/* A cloud asked for by spacing comes out with about that spacing: a CVT's mean nearest distance is
 * a little below that of the hexagonal lattice. */
VT_TEST_FIGURES(the_result_has_about_the_spacing_asked_for, VT_FEWER(SEEDS))
{
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, 5000);
    vt_resample(&out, &report, &in, "spacing=0.12 iterations=30");
    ck_assert_double_ge(report.spacing_mean, 0.12 * 0.88);
    ck_assert_double_le(report.spacing_mean, 0.12 * 1.02);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}
