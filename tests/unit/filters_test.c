/* Filters: smoothing by moving least squares, outliers pulled in or dropped, thinning. */
#include "tests/support/vt_filter.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 2, N = 3000 };

static double rms_height(const struct vor_cloud *cloud)
{
    double sum = 0;

    for (size_t i = 0; i < cloud->n; i++)
        sum += (double)cloud->xyz[3 * i + 2] * cloud->xyz[3 * i + 2];
    return sqrt(sum / (double)cloud->n);
}

VT_TEST_FIGURES(noise_on_a_plane_and_on_a_sphere_falls_to_less_than_half,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    for (int is_sphere = 0; is_sphere < 2; is_sphere++) {
        struct vor_cloud in, out;
        struct vor_report report;
        double before, after;

        (is_sphere ? vt_cloud_sphere : vt_cloud_square)(&in, (uint64_t)_i, N);
        vt_noise_radial(&in, (uint64_t)_i, is_sphere ? 0.02 : 0.005, is_sphere);
        vt_filter(&out, &report, &in, "mls", "drop");
        ck_assert_uint_eq(out.n, N);
        before = is_sphere ? vt_rms_off_sphere(&in) : rms_height(&in);
        after = is_sphere ? vt_rms_off_sphere(&out) : rms_height(&out);
        ck_assert_msg(after < 0.4 * before, "sphere %d: %g of %g", is_sphere, after, before);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
    }
}

/* A quadric has no plane's error, and a sphere's only of fourth order: 2e-4 at 20 of 6,000 points.
 */
VT_TEST_FIGURES(exact_planes_and_spheres_stay_where_they_are, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_square(&in, (uint64_t)_i, N);
    vt_filter(&out, &report, &in, "mls", "keep");
    for (size_t i = 0; i < 3 * (size_t)N; i++)
        ck_assert_float_eq_tol(out.xyz[i], in.xyz[i], 1e-6f);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_cloud_sphere(&in, (uint64_t)_i, N);
    vt_filter(&out, &report, &in, "mls", "keep");
    ck_assert_double_lt(vt_rms_off_sphere(&out), 2e-4);
    ck_assert_double_lt(report.out_to_ref.rms, 2e-4);
    vt_free_last(&out, &in);
}

VT_TEST_LOOP(the_filter_outliers_drops_strays_and_moves_no_other_point,
             VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vor_cloud in, out;
    struct vor_report report;
    size_t strays = 0;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    vt_stray(&in, (uint64_t)_i);
    vt_number(&in);
    vt_filter(&out, &report, &in, "outliers", "keep");
    ck_assert_uint_eq(report.outliers, N - out.n);
    ck_assert_uint_ge(out.n, N - VT_STRAYS - N / 1000);
    for (size_t i = 0; i < out.n; i++) {
        size_t was = vt_number_of(&out, i);

        strays += was < VT_STRAYS;
        ck_assert(i == 0 || was > vt_number_of(&out, i - 1));
        ck_assert_mem_eq(&out.xyz[3 * i], &in.xyz[3 * was], 3 * sizeof *in.xyz);
    }
    ck_assert_uint_le(strays, VT_STRAYS / 50);
    ck_assert(report.ref_to_out.max == 0 && report.out_to_ref.max == 0);
    vt_free_last(&out, &in);
}

/* Without looking wider where neighbours fill space: 0.009. */
VT_TEST_FIGURES(points_scattered_around_a_sphere_are_moved_onto_it, VT_ONCE(1))
{
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, 1, 20000);
    for (size_t i = 0; i < 3 * in.n; i++)
        in.xyz[i] += i % 12 < 3 ? (float)(0.32 * vt_unit(2, i) - 0.16) : 0;
    vt_filter(&out, &report, &in, "outliers,mls", "drop");
    ck_assert_uint_ge(out.n, in.n * 3 / 4);
    ck_assert_double_lt(vt_rms_off_sphere(&out), 0.006);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(pull_moves_strays_onto_the_surface_and_keeps_every_point,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vor_cloud in, out;
    struct vor_report report;
    size_t off = 0;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    vt_stray(&in, (uint64_t)_i);
    vt_number(&in);
    vt_filter(&out, &report, &in, "outliers", "pull");
    ck_assert_uint_eq(out.n, N);
    ck_assert_uint_ge(report.outliers, VT_STRAYS * 49 / 50);
    for (size_t i = 0; i < N; i++) {
        ck_assert_uint_eq(vt_number_of(&out, i), i);
        off += vt_off_sphere(&out, i) > 0.01;
    }
    ck_assert_msg(off <= VT_STRAYS / 50, "%zu are off", off);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(a_resampling_takes_pulled_points_for_a_part_of_the_surface, VT_ONCE(1))
{
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    vt_stray(&in, (uint64_t)_i);
    vt_ask(&out, &report, &(struct vt_ask){&in, "points=800 outliers=pull polish=5", 2});
    ck_assert_uint_eq(out.n, 800);
    ck_assert_uint_ge(report.outliers, VT_STRAYS * 49 / 50);
    ck_assert_double_lt(vt_rms_off_sphere(&out), 0.005);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(mls_before_a_resampling_brings_it_nearer_to_the_surface, VT_ONCE(1))
{
    static const char *const options[2] = {"points=800 neighbors=20 polish=5 filters=none",
                                           "points=800 neighbors=20 polish=5 filters=mls"};
    struct vor_cloud in, out;
    struct vor_report report;
    double off[2];

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    vt_noise_radial(&in, (uint64_t)_i, 0.02, 1);
    for (int k = 0; k < 2; k++) {
        vt_ask(&out, &report, &(struct vt_ask){&in, options[k], 2});
        ck_assert_uint_eq(out.n, 800);
        off[k] = vt_rms_off_sphere(&out);
        vor_cloud_free(&out);
    }
    ck_assert_msg(off[1] < 0.9 * off[0], "%g, without %g", off[1], off[0]);
    vor_cloud_free(&in);
}

/* Half of the sphere has nine times as many points. */
VT_TEST_LOOP(thin_evens_the_density_and_leaves_no_twins, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vor_cloud in, out;
    struct vor_report report;
    size_t north[2] = {0}, south[2] = {0};

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    for (size_t i = 0; i < N; i++)
        if (i % 9 != 0)
            in.xyz[3 * i + 2] = fabsf(in.xyz[3 * i + 2]);
    memcpy(&in.xyz[3], in.xyz, 3 * sizeof *in.xyz);
    vt_filter(&out, &report, &in, "outliers,thin", "drop");
    for (size_t i = 0; i < N; i++)
        (*(in.xyz[3 * i + 2] > 0 ? &north[0] : &south[0]))++;
    for (size_t i = 0; i < out.n; i++)
        (*(out.xyz[3 * i + 2] > 0 ? &north[1] : &south[1]))++;
    ck_assert_uint_lt(out.n, N);
    ck_assert_uint_eq(vt_coincident(&out), 0);
    ck_assert_msg(north[1] * south[0] * 3 < 2 * north[0] * south[1], "%zu and %zu of %zu and %zu",
                  north[1], south[1], north[0], south[0]);
    vt_free_last(&out, &in);
}

/* Two sheets two of their spacings apart, told apart by layers; away from the border, where there
 * are too few points on one side to tell (geom/layers.h). */
VT_TEST_FIGURES(noisy_sheets_are_not_pulled_together, VT_ONCE(1))
{
    enum { MANY = 1500 };
    const double gap = 0.08;
    struct vor_cloud in, out;
    struct vor_report report;
    double sum = 0;
    size_t between = 0, inside = 0;

    vt_cloud_sheets(&in, (uint64_t)_i, MANY, gap);
    for (size_t i = 0; i < MANY; i++)
        in.xyz[3 * i + 2] += (float)(0.05 * gap * vt_normal((uint64_t)_i + 1000, i));
    vt_filter(&out, &report, &in, "mls", "keep");
    for (size_t i = 0; i < MANY; i++) {
        const float *x = &out.xyz[3 * i];
        double off = (double)x[2] - (in.xyz[3 * i + 2] > 0.5 * gap ? gap : 0);

        if (fabsf(x[0] - 0.5f) > 0.4f || fabsf(x[1] - 0.5f) > 0.4f)
            continue;
        inside++;
        sum += off * off;
        between += fabs(off) > 0.3 * gap;
    }
    ck_assert_msg(between <= MANY / 1000, "%zu points in between", between);
    ck_assert_double_lt(sqrt(sum / (double)inside), 0.05 * gap);
    vt_free_last(&out, &in);
}
