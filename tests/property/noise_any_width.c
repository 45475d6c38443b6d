/* Noise that is several spacings wide: as many neighbours as a fit takes form a ball then, unless
 * they are taken from fewer points. */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_filter.h"

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

int main(void)
{
    Suite *suite = suite_create("noise_any_width");

    vt_add_loop(suite, more_points_of_a_noisy_sphere_leave_no_more_of_the_noise, SEEDS);
    return vt_run(suite);
}
