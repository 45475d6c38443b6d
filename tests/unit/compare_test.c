/* What a report says of the result beside the input, where it is known: distances on a lattice,
 * points along borders of known length and on closed clouds, numbers of neighbours. */
#include "core/output/compare.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 3, N = 4000, SIDE = 20 };

struct bed {
    struct vt_engine engine;
    struct vor_domain domain;
    struct vor_seeds seeds;
};

static void open_bed(struct bed *bed, const struct vor_cloud *in, size_t n)
{
    vt_engine_open(&bed->engine, 2);
    vt_assert_ok(vor_domain_init(&bed->domain, in, &bed->engine.run, &vt_err));
    vt_assert_ok(
        vor_seeds_init(&bed->seeds, &bed->domain, n, vt_policy, &bed->engine.run, &vt_err));
}

static void close_bed(struct bed *bed)
{
    vor_seeds_free(&bed->seeds);
    vor_domain_free(&bed->domain);
    vt_engine_close(&bed->engine);
}

/* A seed in the middle of each square of the lattice is as far from its corners as they from it. */
VT_TEST(in_the_middle_of_the_squares_of_a_lattice_all_distances_are_half_a_diagonal)
{
    struct bed bed;
    struct vor_cloud in;
    struct vor_comparison account;
    double half, spacing;

    vt_cloud_lattice(&in, SIDE);
    open_bed(&bed, &in, (SIDE - 1) * (SIDE - 1));
    spacing = 1 / bed.domain.unit;
    half = sqrt(0.5) * spacing;
    for (size_t i = 0; i < bed.seeds.n; i++) {
        double x[3] = {(double)(i % (SIDE - 1)) + 0.5, (double)(i / (SIDE - 1)) + 0.5, 0};

        for (size_t c = 0; c < 3; c++)
            bed.seeds.xyz[3 * i + c] = (float)((x[c] - bed.domain.shift[c]) * spacing);
    }
    vt_assert_ok(vor_seeds_index(&bed.seeds, &bed.seeds.run, &vt_err));
    vt_assert_ok(vor_compare(&account, &bed.seeds, spacing, 0, &vt_err));
    ck_assert_uint_eq(account.ref_to_out.points, SIDE * SIDE);
    ck_assert_uint_eq(account.out_to_ref.points, (SIDE - 1) * (SIDE - 1));
    ck_assert_double_eq_tol(account.ref_to_out.mean, half, 1e-6);
    ck_assert_double_eq_tol(account.ref_to_out.rms, half, 1e-6);
    ck_assert_double_eq_tol(account.ref_to_out.max, half, 1e-6);
    ck_assert_double_eq_tol(account.out_to_ref.mean, half, 1e-6);
    ck_assert_double_eq_tol(account.out_to_ref.rms, half, 1e-6);
    ck_assert_double_eq_tol(account.out_to_ref.max, half, 1e-6);
    ck_assert_uint_eq(account.border, 4 * (SIDE - 2));
    vor_cloud_free(&in);
    close_bed(&bed);
}

static struct vor_report resample(const struct vor_cloud *in, const char *points, const char *name,
                                  const char *value)
{
    struct vt_engine engine;
    struct vor_report report;
    struct vor_cloud out;

    vt_engine_open(&engine, 2);
    vt_engine_set(&engine, "points", points);
    if (name != NULL)
        vt_engine_set(&engine, name, value);
    vt_engine_resample(&engine, &out, &report, in);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return report;
}

static void assert_along(const struct vor_report *report, double length)
{
    double share = (double)report->boundary_points * report->spacing_mean / length;

    ck_assert_msg(share > 0.8 && share < 1.15, "%g of the border: %u points", share,
                  (unsigned)report->boundary_points);
}

/* Input four and forty times as dense as the result: cells, and neighbours of the input, end at the
 * border in other ways. */
VT_TEST_FIGURES(the_border_of_a_square_has_its_length_over_the_spacing,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    for (size_t n = N; n <= 10 * N; n *= 10) {
        struct vor_cloud in;
        struct vor_report report;

        vt_cloud_square(&in, (uint64_t)_i, n);
        report = resample(&in, "1000", NULL, NULL);
        assert_along(&report, 4);
        vor_cloud_free(&in);
    }
}

/* The rim of a hole counts as the sides of the square do. */
VT_TEST_FIGURES(a_hole_has_a_border_too, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vor_cloud in;
    struct vor_report report;
    size_t kept = 0;

    vt_cloud_square(&in, (uint64_t)_i, 6 * N);
    for (size_t i = 0; i < in.n; i++)
        if (hypot((double)in.xyz[3 * i] - 0.5, (double)in.xyz[3 * i + 1] - 0.5) > 0.25)
            memmove(&in.xyz[3 * kept++], &in.xyz[3 * i], 3 * sizeof *in.xyz);
    in.n = kept;
    report = resample(&in, "1000", NULL, NULL);
    assert_along(&report, 4 + 0.5 * M_PI);
    vor_cloud_free(&in);
}

VT_TEST_FIGURES(closed_smooth_clouds_have_no_border, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    static const char *const points[3] = {"300", "1000", "4000"};

    for (int shape = 0; shape < VT_SMOOTH; shape++) {
        struct vor_cloud in;

        vt_shapes[shape].make(&in, (uint64_t)_i, N);
        for (int k = 0; k < 3; k++)
            ck_assert_uint_eq(resample(&in, points[k], NULL, NULL).boundary_points, 0);
        vor_cloud_free(&in);
    }
}

/* The number of neighbours is one for all, but for those on a finer fit, which there are only
 * with a polish. */
VT_TEST_LOOP(the_histogram_of_neighbors_counts_every_point, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vor_cloud in;
    struct vor_report report;

    vt_cloud_box(&in, (uint64_t)_i, N);
    report = resample(&in, "1000", "neighbors", "20");
    ck_assert_uint_eq(report.fitted_count, 2);
    ck_assert_uint_eq(report.fitted[0].neighbors, 12);
    ck_assert_uint_eq(report.fitted[1].neighbors, 20);
    ck_assert_uint_gt(report.fitted[0].points, 0);
    ck_assert_uint_eq(report.fitted[0].points + report.fitted[1].points, 1000);
    report = resample(&in, "1000", "neighbors", "21");
    ck_assert_uint_eq(report.fitted_count, 1);
    ck_assert_uint_eq(report.fitted[0].neighbors, 21);
    ck_assert_uint_eq(report.fitted[0].points, 1000);
    report = resample(&in, "1000", "polish", "0");
    ck_assert_uint_eq(report.fitted_count, 1);
    ck_assert_uint_eq(report.fitted[0].neighbors, 20);
    in.n = 9;
    report = resample(&in, "5", "neighbors", "20");
    ck_assert_uint_eq(report.fitted_count, 1);
    ck_assert_uint_eq(report.fitted[0].neighbors, 9);
    ck_assert_uint_eq(report.fitted[0].points, 5);
    vor_cloud_free(&in);
}
