/* Oracle: the distances in a report against a look at every pair of points. */
#include "tests/support/vt_ask.h"

#include <math.h>

enum { SEEDS = 8, N = 1500, OUT = 400, DENSE = 250000, FEW = 60 };

static struct vor_apart look(const struct vor_cloud *from, size_t n, const struct vor_cloud *to,
                             size_t m)
{
    struct vor_apart apart = {.points = n};
    struct vor_cloud some = *to;

    some.n = m;
    for (size_t i = 0; i < n; i++) {
        double x[3], d2;

        vor_cloud_position(from, i, x);
        d2 = vt_nearest2(&some, x, NULL);
        apart.mean += sqrt(d2) / (double)n;
        apart.rms += d2 / (double)n;
        apart.max = fmax(apart.max, sqrt(d2));
    }
    apart.rms = sqrt(apart.rms);
    return apart;
}

static void assert_same(const struct vor_apart *found, const struct vor_apart *wanted)
{
    double close = 1e-4 * wanted->max; /* positions are rounded to float32 */

    ck_assert_uint_eq(found->points, wanted->points);
    ck_assert_double_eq_tol(found->mean, wanted->mean, close);
    ck_assert_double_eq_tol(found->rms, wanted->rms, close);
    ck_assert_double_eq_tol(found->max, wanted->max, close);
}

/* The last `strays` points of the input count for nothing: they share a place with others, or are
 * an outlier. */
static void check(const struct vor_cloud *in, size_t strays, size_t points, const char *outliers)
{
    struct vor_report report;
    struct vor_cloud out;
    struct vor_apart forth, back;

    vt_resample(&out, &report, in, "points=%zu iterations=4 polish=10 outliers=%s", points,
                outliers);
    forth = look(in, in->n - strays, &out, out.n);
    back = look(&out, out.n, in, in->n - strays);
    assert_same(&report.ref_to_out, &forth);
    assert_same(&report.out_to_ref, &back);
    ck_assert_double_gt(fabs(forth.mean - back.mean), 1e-3 * forth.mean);
    vor_cloud_free(&out);
}

VT_TEST_LOOP(the_distances_are_those_of_a_look_at_every_pair, VT_FEWER(SEEDS))
{
    struct vor_cloud in;

    if (_i % 2)
        vt_cloud_dome(&in, (uint64_t)_i, N);
    else
        vt_cloud_box(&in, (uint64_t)_i, N);
    in.origin[0] = 1e6;
    for (size_t i = 0; i < 3 * N; i++)
        in.xyz[i] = 40 * in.xyz[i] + 300;
    check(&in, 0, _i % 4 < 2 ? OUT : 3 * N, "keep");
    vor_cloud_free(&in);
}

VT_TEST_LOOP(points_in_one_place_count_once, 2)
{
    struct vor_cloud in;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    for (size_t i = N - 300; i < N; i++)
        for (size_t c = 0; c < 3; c++)
            in.xyz[3 * i + c] = in.xyz[3 * (i % 7) + c];
    check(&in, 300, OUT, "keep");
    vor_cloud_free(&in);
}

VT_TEST_LOOP(outliers_that_were_ignored_do_not_count, 2)
{
    struct vor_cloud in;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    in.xyz[3 * N - 1] = in.xyz[3 * N - 2] = in.xyz[3 * N - 3] = 3;
    check(&in, 1, OUT, "drop");
    vor_cloud_free(&in);
}

/* Mean and rms of a part of them are close, and no point of it is farther than the farthest. */
VT_TEST(of_many_points_200000_stand_for_all)
{
    struct vor_report report;
    struct vor_cloud in, out;
    struct vor_apart all;

    vt_cloud_dome(&in, 1, DENSE);
    vt_resample(&out, &report, &in, "points=%d iterations=2 polish=0", FEW);
    all = look(&in, DENSE, &out, FEW);
    ck_assert_uint_eq(report.ref_to_out.points, 200000);
    ck_assert_double_eq_tol(report.ref_to_out.mean, all.mean, 1e-3 * all.mean);
    ck_assert_double_eq_tol(report.ref_to_out.rms, all.rms, 1e-3 * all.rms);
    ck_assert_double_le(report.ref_to_out.max, all.max * (1 + 1e-6));
    ck_assert_double_gt(report.ref_to_out.max, 0.9 * all.max);
    ck_assert_uint_eq(report.out_to_ref.points, FEW);
    vt_free_last(&out, &in);
}
