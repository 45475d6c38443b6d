/* Xiao et al. 2024, Sec. IV-D, IV-E and V: projection, the border, holes, colours. */
#include "tests/support/vt_ask.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 3 };

static void resample(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
                     size_t points, const char *iterations, const char *boundary)
{
    /* anderson as in the paper, and no polish */
    vt_resample(out, report, in, "points=%zu iterations=%s anderson=4 polish=0 boundary=%s", points,
                iterations, boundary);
}

/* --- Sec. IV-D, row X12 -------------------------------------------------------------------------
 */

static double off_sphere_rms(const struct vor_cloud *cloud)
{
    double sum = 0;

    for (size_t i = 0; i < cloud->n; i++) {
        double x[3], r;

        vor_cloud_position(cloud, i, x);
        r = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        sum += (r - 1) * (r - 1);
    }
    return sqrt(sum / (double)cloud->n);
}

/* The bound is a fiftieth of what a plane patch of this spacing would leave. What is left is
 * rounding and noise of the fit, so it is compared with a factor. */
VT_TEST_LOOP(sec_iv_d_the_distance_to_the_surface_does_not_accumulate, SEEDS)
{
    static const char *const iterations[3] = {"1", "10", "40"};
    double rms[3], sagitta = M_PI / 600 / 2;
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, 4000);
    for (int k = 0; k < 3; k++) {
        resample(&out, &report, &in, 600, iterations[k], "keep");
        rms[k] = off_sphere_rms(&out);
        vor_cloud_free(&out);
    }
    ck_assert_double_lt(rms[1], sagitta / 50);
    ck_assert_double_lt(rms[2], sagitta / 50);
    ck_assert_double_lt(rms[2], 2.5 * rms[1]);
    vor_cloud_free(&in);
}

/* --- Sec. IV-E, Fig. 7, row X13 -----------------------------------------------------------------
 */

/* Points below the rim of the dome by more than `depth`. */
static size_t below(const struct vor_cloud *cloud, double depth)
{
    size_t found = 0;

    for (size_t i = 0; i < cloud->n; i++)
        found += (double)cloud->xyz[3 * i + 2] < -depth;
    return found;
}

VT_TEST_LOOP(fig_7_no_point_drifts_beyond_the_rim_and_without_the_restriction_some_do, SEEDS)
{
    const double spacing = sqrt(2 * M_PI / 4000);
    struct vor_cloud in, keep, free;
    struct vor_report report;

    vt_cloud_dome(&in, (uint64_t)_i, 4000);
    resample(&keep, &report, &in, 600, "40", "keep");
    ck_assert_uint_eq(below(&keep, spacing), 0);
    resample(&free, &report, &in, 600, "40", "free");
    ck_assert_uint_gt(below(&free, spacing), 5);
    ck_assert_uint_eq(report.held_ever, 0);
    vor_cloud_free(&free);
    vor_cloud_free(&keep);
    vor_cloud_free(&in);
}

/* ERRATA, "the boundary restriction freezes closed clouds": ours must not. */
VT_TEST_LOOP(sec_iv_e_on_a_closed_cloud_at_most_one_point_in_a_thousand_is_held, SEEDS)
{
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, 5000);
    resample(&out, &report, &in, 1000, "30", "keep");
    ck_assert_uint_le(report.held_ever, 1);
    ck_assert_double_lt(report.delta, 0.1);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}

/* --- Sec. IV-E and V-A, row X14 -----------------------------------------------------------------
 */

/* A lattice, one apart, each point moved a little, without the points nearer than `hole` to the
 * middle, which lies between four of them. */
static void punched(struct vor_cloud *cloud, uint64_t seed, double hole)
{
    enum { SIDE = 40 };
    struct vor_cloud all;
    size_t n = 0;

    vt_cloud_lattice(&all, SIDE);
    for (size_t i = 0; i < all.n; i++) {
        float *x = &all.xyz[3 * i];

        if (hypot((double)x[0] - 19.5, (double)x[1] - 19.5) < hole)
            continue;
        for (size_t c = 0; c < 2; c++)
            all.xyz[3 * n + c] = x[c] + (float)(0.2 * (vt_unit(seed, 2 * i + c) - 0.5));
        all.xyz[3 * n++ + 2] = 0;
    }
    vt_cloud_make(cloud, n);
    memcpy(cloud->xyz, all.xyz, 3 * n * sizeof *cloud->xyz);
    vor_cloud_free(&all);
}

static double gap(const struct vor_cloud *cloud)
{
    return sqrt(vt_nearest2(cloud, (double[3]){19.5, 19.5, 0}, NULL));
}

/* Without the four points in the middle, opposite points are three apart. */
VT_TEST_LOOP(sec_iv_e_a_hole_narrower_than_three_spacings_is_filled, SEEDS)
{
    struct vor_cloud in, out;
    struct vor_report report;

    punched(&in, (uint64_t)_i, 1);
    ck_assert_double_gt(gap(&in), 1.3);
    resample(&out, &report, &in, in.n, "30", "keep");
    ck_assert_double_lt(gap(&out), 0.8);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}

VT_TEST_LOOP(sec_v_a_a_wider_hole_shrinks_with_every_pass, SEEDS)
{
    struct vor_cloud in, out;
    struct vor_report report;
    double before;

    punched(&in, (uint64_t)_i, 5);
    before = gap(&in);
    ck_assert_double_gt(before, 4.5);
    for (int pass = 0; pass < 3; pass++) {
        resample(&out, &report, &in, in.n, "15", "keep");
        ck_assert_double_lt(gap(&out), before);
        before = gap(&out);
        vor_cloud_free(&in);
        in = out;
    }
    vor_cloud_free(&in);
}
