/* The generators of noise that the tests of denoising start from: what they say they add. */
#include "tests/support/vt_engine.h"
#include "tests/support/vt_noise.h"

#include <math.h>
#include <stdlib.h>

enum { SEEDS = 3, N = 4000 };

/* Height over the unit sphere of each point, in l: free() it. */
static double *heights(const struct vor_cloud *cloud, const double *length)
{
    double *height = malloc(cloud->n * sizeof *height);

    ck_assert_ptr_nonnull(height);
    for (size_t i = 0; i < cloud->n; i++) {
        double x[3];

        vor_cloud_position(cloud, i, x);
        height[i] = (sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) - 1) / length[i];
    }
    return height;
}

static double *lengths(const struct vor_cloud *cloud)
{
    double *length = malloc(cloud->n * sizeof *length);

    ck_assert_ptr_nonnull(length);
    vt_noise_lengths(length, cloud);
    return length;
}

START_TEST(noise_has_mean_zero_and_the_deviation_asked_for)
{
    static const double deviations[] = {VT_NOISE_LOW, VT_NOISE_HIGH};
    double deviation = deviations[_i % 2], sum = 0, sum2 = 0, *length, *height;
    struct vor_cloud cloud;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    length = lengths(&cloud);
    vt_noise_add(&cloud, (uint64_t)_i, deviation);
    height = heights(&cloud, length);
    for (size_t i = 0; i < N; i++) {
        sum += height[i] / N;
        sum2 += height[i] * height[i] / N;
    }
    ck_assert_double_le(fabs(sum), 4 * deviation / sqrt(N));
    ck_assert_double_eq_tol(sqrt(sum2), deviation, 0.05 * deviation);
    free(height);
    free(length);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

START_TEST(outliers_are_the_share_asked_for_three_to_six_l_off_on_both_sides)
{
    size_t outside = 0, inside = 0;
    unsigned char moved[N];
    double *length, *height;
    struct vor_cloud cloud;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    length = lengths(&cloud);
    vt_noise_outliers(moved, &cloud, (uint64_t)_i, VT_NOISE_OUTLIERS);
    height = heights(&cloud, length);
    for (size_t i = 0; i < N; i++) {
        outside += moved[i] && height[i] > 0;
        inside += moved[i] && height[i] < 0;
        if (moved[i]) { /* the normals are not quite those of the sphere */
            ck_assert_double_ge(fabs(height[i]), 2.8);
            ck_assert_double_le(fabs(height[i]), 6.2);
        } else {
            ck_assert_double_le(fabs(height[i]), 1e-4);
        }
    }
    ck_assert_uint_eq(outside + inside, N / 20);
    ck_assert_uint_ge(outside, N / 60);
    ck_assert_uint_ge(inside, N / 60);
    free(height);
    free(length);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

START_TEST(a_seed_makes_the_same_noise_again_and_another_seed_other_noise)
{
    uint64_t hash[3];

    for (uint64_t i = 0; i < 3; i++) {
        struct vor_cloud cloud;

        vt_cloud_sphere(&cloud, 1, N);
        vt_noise_add(&cloud, i / 2, VT_NOISE_LOW);
        hash[i] = vt_cloud_hash(&cloud);
        vor_cloud_free(&cloud);
    }
    ck_assert(hash[0] == hash[1]);
    ck_assert(hash[0] != hash[2]);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("noise");

    vt_add_loop(suite, noise_has_mean_zero_and_the_deviation_asked_for, VT_FEWER(2 * SEEDS));
    vt_add_loop(suite, outliers_are_the_share_asked_for_three_to_six_l_off_on_both_sides,
                VT_FEWER(SEEDS));
    vt_add(suite, a_seed_makes_the_same_noise_again_and_another_seed_other_noise);
    return vt_run(suite);
}
