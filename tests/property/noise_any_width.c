/* Noise that is several spacings wide: as many neighbours as a fit takes form a ball then, unless
 * they are taken from fewer points. */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_filter.h"

#include <math.h>
#include <stdio.h>

enum { SIZES = 2, WIDTHS = 2 };
#define LEFT 0.4 /* of the noise, at most */
#define FLUKE 1.1

/* Of the radius: 1 % of the diagonal, and 4 spacings of the larger input. */
static const double noises[WIDTHS] = {0.035, 0.07};
static const size_t sizes[SIZES] = {13000, 39000};

/* The rms distance to the sphere of a result over that of its input. */
static double left_of(size_t n, double noise, uint64_t seed, const char *options)
{
    struct vor_report report;
    struct vor_cloud in, out;
    double before, after;

    vt_cloud_sphere(&in, seed, n);
    vt_noise_radial(&in, seed + 1, noise, 1);
    vt_ask(&out, &report, &(struct vt_ask){&in, options, 2});
    ck_assert_uint_eq(report.warnings_count, 0);
    before = vt_rms_off_sphere(&in);
    after = vt_rms_off_sphere(&out);
    printf("# %s, %zu points: %.4f of %.4f\n", options, n, after, before);
    fflush(stdout);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    return after / before;
}

VT_TEST_LOOP(more_points_of_a_noisy_sphere_leave_no_more_of_the_noise, WIDTHS)
{
    double least = LEFT;

    for (size_t i = 0; i < SIZES; i++) {
        double left = left_of(sizes[i], noises[_i], 31, "points=1500 polish=0 iterations=2");

        ck_assert_double_le(left, LEFT);
        if (i > 0)
            ck_assert_double_le(left, FLUKE * least);
        least = left < least ? left : least;
    }
}

/* Points that fill a cube have no surface, and nothing can bring them nearer to one. */
VT_TEST_LOOP(a_run_says_that_noise_hides_the_surface, 1)
{
    enum { N = 3000 };
    struct vor_report report;
    struct vor_cloud in, out;

    vt_cloud_sphere(&in, 1, N);
    for (size_t i = 0; i < 3 * (size_t)N; i++)
        in.xyz[i] = (float)vt_unit(7, i);
    vt_ask(&out, &report, &(struct vt_ask){&in, "points=500 polish=0 iterations=1", 2});
    ck_assert_uint_eq(report.warnings_count, 1);
    ck_assert_int_eq(report.warnings[0].says, VOR_WARNING_NOISE);
    ck_assert_double_lt(report.warnings[0].value, report.warnings[0].limit);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}

/* Two spheres, a tenth of their radius apart, with noise and one point in twenty anywhere: results
 * that still hold noise push each other outwards, and strays between the two must not stay. */
VT_TEST_LOOP(denoise_leaves_less_of_the_noise_than_resample_without_outliers, 1)
{
    enum { N = 6000 };
    double left[2], noise = 0.04, apart = 2.1;
    struct vor_cloud in, out;

    vt_cloud_sphere(&in, 1 + (uint64_t)_i, N);
    vt_noise_radial(&in, 2 + (uint64_t)_i, noise, 1);
    for (size_t i = 0; i < N; i++)
        in.xyz[3 * i] += i % 2 == 0 ? (float)apart : 0;
    for (size_t i = 0; i < 3 * N / 20; i++)
        in.xyz[i] = (float)((i % 3 == 0 ? 4.7 : 2.6) * vt_unit(7 + (uint64_t)_i, i) - 1.3);
    for (int denoised = 0; denoised < 2; denoised++) {
        struct vt_engine engine;
        struct vor_report report;
        double sum = 0;

        vt_engine_open(&engine, 2);
        vor_spec_preset(&engine.spec, vor_process_find(denoised ? "denoise" : "resample"));
        vt_ask_set(&engine, "points=1500 polish=0 iterations=2 outliers=drop");
        vt_engine_resample(&engine, &out, &report, &in);
        for (size_t i = 0; i < out.n; i++) {
            double x = (double)out.xyz[3 * i], y = (double)out.xyz[3 * i + 1],
                   z = (double)out.xyz[3 * i + 2], off = sqrt(x * x + y * y + z * z) - 1,
                   other = sqrt((x - apart) * (x - apart) + y * y + z * z) - 1;

            sum += fmin(off * off, other * other);
        }
        left[denoised] = sqrt(sum / (double)out.n) / noise;
        vor_cloud_free(&out);
        vt_engine_close(&engine);
    }
    printf("# of the noise %.3f is left, without the filters %.3f\n", left[1], left[0]);
    ck_assert_double_le(left[1], 0.35);
    ck_assert_double_le(left[1], 0.85 * left[0]);
    vor_cloud_free(&in);
}
