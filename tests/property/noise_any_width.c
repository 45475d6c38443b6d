/* Noise that is several spacings wide: as many neighbours as a fit takes form a ball then, unless
 * they are taken from fewer points. */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_filter.h"

#include <math.h>
#include <stdio.h>

enum { SIZES = 3, SEEDS = 1 };
#define NOISE 0.07 /* of the radius: 4 spacings of the largest input */
#define LEFT 0.4   /* of the noise, at most */
#define FLUKE 1.1

static const size_t sizes[SIZES] = {5000, 15000, 40000};

/* The rms distance to the sphere of a result over that of its input. */
static double left_of(size_t n, uint64_t seed, const char *options)
{
    struct vor_report report;
    struct vor_cloud in, out;
    double before, after;

    vt_cloud_sphere(&in, seed, n);
    vt_noise_radial(&in, seed + 1, NOISE, 1);
    vt_ask(&out, &report, &(struct vt_ask){&in, options, 2});
    before = vt_rms_off_sphere(&in);
    after = vt_rms_off_sphere(&out);
    printf("# %s, %zu points: %.4f of %.4f\n", options, n, after, before);
    fflush(stdout);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    return after / before;
}

static void check(uint64_t seed, const char *options)
{
    double least = LEFT;

    for (size_t i = 0; i < SIZES; i++) {
        double left = left_of(sizes[i], seed, options);

        ck_assert_double_le(left, LEFT);
        if (i > 0)
            ck_assert_double_le(left, FLUKE * least);
        least = left < least ? left : least;
    }
}

START_TEST(more_points_of_a_noisy_sphere_leave_no_more_of_the_noise)
{
    check(31 + 10 * (uint64_t)_i, "points=1500 polish=0 iterations=2");
    vt_assert_no_leak();
}
END_TEST

/* Two spheres, a tenth of their radius apart, with noise and one point in twenty anywhere: results
 * that still hold noise push each other outwards, and strays between the two must not stay. */
START_TEST(denoise_leaves_less_of_the_noise_than_resample_without_outliers)
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
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("noise_any_width");

    vt_add_loop(suite, more_points_of_a_noisy_sphere_leave_no_more_of_the_noise, SEEDS);
    vt_add_loop(suite, denoise_leaves_less_of_the_noise_than_resample_without_outliers, SEEDS);
    return vt_run(suite);
}
