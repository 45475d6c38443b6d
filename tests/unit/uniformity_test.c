/* delta, sigma and epsilon: hand values and what must hold for any distances. */
#include "core/metrics/uniformity.h"
#include "tests/support/vt_engine.h"

#include <math.h>

enum { SEEDS = 40, N = 400 };

static void random_distances(uint64_t seed, float *d, size_t n)
{
    for (size_t i = 0; i < n; i++)
        d[i] = (float)(0.01 + vt_unit(seed, i));
}

/* Vector: mean 4/3, relative deviations -1/4, -1/4, 1/2. */
VT_TEST(three_distances_have_their_hand_computed_uniformity)
{
    const float d[3] = {1, 1, 2};
    struct vor_uniformity u;

    vor_uniformity_from(&u, d, 3);
    ck_assert_double_eq_tol(u.delta, sqrt(0.125), 1e-15);
    ck_assert_double_eq_tol(u.sigma, 4.0 / 9, 1e-15);
    ck_assert_double_eq_tol(u.epsilon, 1 / sqrt(1.125), 1e-15);
    ck_assert_double_eq_tol(u.mean, 4.0 / 3, 1e-15);
    ck_assert(u.min == 1 && u.max == 2 && u.coincident == 0);
}

VT_TEST(points_all_in_one_place_have_no_distances)
{
    const float d[3] = {0, 0, 0};
    struct vor_uniformity u;

    vor_uniformity_from(&u, d, 3);
    ck_assert(u.delta == 0 && u.sigma == 0 && u.epsilon == 1 && u.mean == 0);
    ck_assert(u.min == 0 && u.max == 0);
    ck_assert_uint_eq(u.coincident, 3);
}

VT_TEST(coincident_points_are_counted)
{
    const float d[4] = {0, 0, 1, 3};
    struct vor_uniformity u;

    vor_uniformity_from(&u, d, 4);
    ck_assert_uint_eq(u.coincident, 2);
    ck_assert_double_eq_tol(u.delta, sqrt(6.0 / 4), 1e-15);
    ck_assert(u.min == 0 && u.max == 3);
}

/* Property, Xiao 2024 Eq. 6: a cloud in feet is as even as in metres; sigma carries the unit. */
VT_TEST_LOOP(delta_and_epsilon_have_no_scale, SEEDS)
{
    float d[N], scaled[N];
    struct vor_uniformity u, v;

    random_distances((uint64_t)_i, d, N);
    for (size_t i = 0; i < N; i++)
        scaled[i] = d[i] * 0x1p-20f;
    vor_uniformity_from(&u, d, N);
    vor_uniformity_from(&v, scaled, N);
    ck_assert_double_eq_tol(v.delta, u.delta, 1e-14);
    ck_assert_double_eq_tol(v.epsilon, u.epsilon, 1e-14);
    ck_assert_double_eq_tol(v.sigma * 0x1p20, u.sigma, 1e-14);
    ck_assert_double_eq_tol(v.mean * 0x1p20, u.mean, 1e-14);
}

/* Property, Xiao 2024 Sec. V-B and row X21: the cosine itself, not the identity it follows. */
VT_TEST_LOOP(epsilon_is_the_cosine_between_the_distances_and_their_mean, SEEDS)
{
    float d[N];
    double sum = 0, square = 0;
    struct vor_uniformity u;

    random_distances((uint64_t)_i, d, N);
    for (size_t i = 0; i < N; i++) {
        sum += (double)d[i];
        square += (double)d[i] * (double)d[i];
    }
    vor_uniformity_from(&u, d, N);
    ck_assert_double_eq_tol(u.epsilon, sum / sqrt(N * square), 1e-13);
    ck_assert_double_eq_tol(u.epsilon, 1 / sqrt(1 + u.delta * u.delta), 1e-15);
    ck_assert_double_gt(u.delta, 0.3);
}

static void measure(struct vor_uniformity *u, const struct vor_cloud *cloud)
{
    struct vt_engine engine;
    struct vor_knn *knn;
    float *nearest = vor_malloc(&vt_memory, cloud->n, sizeof *nearest);

    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_knn_build(&knn, cloud->xyz, cloud->n, &vt_memory, &vt_err));
    vt_assert_ok(vor_nearest_distances(nearest, cloud->xyz, cloud->n, knn, &engine.run, &vt_err));
    vor_uniformity_from(u, nearest, cloud->n);
    vor_knn_free(knn);
    vor_free(&vt_memory, nearest);
    vt_engine_close(&engine);
}

VT_TEST(a_lattice_is_perfectly_even_and_its_spacing_is_its_own)
{
    struct vor_cloud cloud;
    struct vor_uniformity u;

    vt_cloud_lattice(&cloud, 40);
    measure(&u, &cloud);
    ck_assert(u.delta == 0 && u.sigma == 0 && u.mean == 1 && u.min == 1 && u.max == 1);
    vor_cloud_free(&cloud);
}

/* White noise in the plane: d is Rayleigh, whose deviation over mean is sqrt(4/pi - 1) = 0.5227. */
VT_TEST_LOOP(white_noise_has_the_uniformity_of_a_rayleigh_distance, 3)
{
    struct vor_cloud cloud;
    struct vor_uniformity u;

    vt_cloud_square(&cloud, (uint64_t)_i, 20000);
    measure(&u, &cloud);
    ck_assert_double_eq_tol(u.delta, sqrt(4 / M_PI - 1), 0.02);
    ck_assert_double_eq_tol(u.mean, 0.5 / sqrt(20000), 0.02 * 0.5 / sqrt(20000));
    vor_cloud_free(&cloud);
}
