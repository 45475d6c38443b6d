/* How many neighbours an input is found to want. */
#include "core/method/scale.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>

enum { SEEDS = 4, N = 20000, EXACT = 20 };

static unsigned neighbors_of(const struct vor_cloud *cloud, unsigned threads)
{
    struct vt_engine engine;
    struct vor_domain domain;
    unsigned k = 0;

    vt_engine_open(&engine, threads);
    vt_assert_ok(vor_domain_init(&domain, cloud, &engine.run, &vt_err));
    vt_assert_ok(vor_scale_neighbors(&k, &domain, &engine.run, &vt_err));
    vor_domain_free(&domain);
    vt_engine_close(&engine);
    return k;
}

/* Distance between neighbours of n points on that area, in a square lattice. */
static double spacing(const struct vt_shape *shape, size_t n)
{
    return sqrt(shape->area / (double)n);
}

static void add_noise(struct vor_cloud *cloud, uint64_t seed, double sigma)
{
    for (size_t i = 0; i < 3 * cloud->n; i++)
        cloud->xyz[i] += (float)(sigma * vt_normal(seed, i));
}

static void snap(struct vor_cloud *cloud, double cell)
{
    for (size_t i = 0; i < 3 * cloud->n; i++)
        cloud->xyz[i] = (float)(cell * floor((double)cloud->xyz[i] / cell + 0.5));
}

START_TEST(an_exact_cloud_is_fitted_closely)
{
    static void (*const makes[])(struct vor_cloud *, uint64_t, size_t) = {
        vt_cloud_sphere, vt_cloud_torus, vt_cloud_box, vt_cloud_dome, vt_cloud_square};
    struct vor_cloud cloud;

    for (size_t i = 0; i < sizeof makes / sizeof *makes; i++) {
        makes[i](&cloud, (uint64_t)_i, N);
        ck_assert_msg(neighbors_of(&cloud, 2) == EXACT, "shape %zu", i);
        vor_cloud_free(&cloud);
    }
    vt_assert_no_leak();
}
END_TEST

START_TEST(noise_asks_for_more)
{
    static const double sigmas[] = {0, 0.3, 0.8, 2};
    unsigned before = 0, k = 0;

    for (size_t i = 0; i < 4; i++) {
        struct vor_cloud cloud;

        vt_cloud_sphere(&cloud, (uint64_t)_i, N);
        add_noise(&cloud, (uint64_t)_i + SEEDS, sigmas[i] * spacing(&vt_shapes[VT_SPHERE], N));
        k = neighbors_of(&cloud, 2);
        ck_assert_msg(i == 3 || k >= before, "%u neighbours after %u", k, before);
        before = k;
        vor_cloud_free(&cloud);
    }
    ck_assert_uint_ge(k, 70);
    vt_assert_no_leak();
}
END_TEST

START_TEST(a_lattice_is_noise_too)
{
    struct vor_cloud cloud;

    vt_cloud_torus(&cloud, (uint64_t)_i, N);
    snap(&cloud, 1.5 * spacing(&vt_shapes[VT_TORUS], N));
    ck_assert_uint_gt(neighbors_of(&cloud, 2), EXACT);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

START_TEST(one_two_three_and_eight_threads_and_any_power_of_two_find_the_same)
{
    struct vor_cloud cloud;
    unsigned k;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    add_noise(&cloud, 1, 0.02);
    k = neighbors_of(&cloud, 1);
    ck_assert_uint_eq(neighbors_of(&cloud, 2), k);
    ck_assert_uint_eq(neighbors_of(&cloud, 3), k);
    ck_assert_uint_eq(neighbors_of(&cloud, 8), k);
    for (size_t i = 0; i < 3 * cloud.n; i++)
        cloud.xyz[i] *= 1024;
    ck_assert_uint_eq(neighbors_of(&cloud, 2), k);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

START_TEST(a_few_points_are_never_asked_for_more_than_an_eighth_of_them)
{
    for (size_t n = 4; n < 2000; n = n * 3 / 2) {
        struct vor_cloud cloud;
        unsigned k;

        vt_cloud_cube(&cloud, (uint64_t)_i, n);
        k = neighbors_of(&cloud, 2);
        ck_assert(k == EXACT || k <= n / 8);
        vor_cloud_free(&cloud);
    }
    vt_assert_no_leak();
}
END_TEST

/* Mean distance to the unit sphere of a result with that many neighbours. */
static double off(const struct vor_cloud *in, const char *neighbors, double *resolved)
{
    struct vt_engine engine;
    struct vor_cloud out;
    struct vor_report report;
    double mean;

    vt_engine_open(&engine, 2);
    vt_engine_set(&engine, "points", "2000");
    vt_engine_set(&engine, "neighbors", neighbors);
    vt_engine_set(&engine, "polish", "30");
    vt_engine_resample(&engine, &out, &report, in);
    mean = vt_off_mean(&vt_shapes[VT_SPHERE], &out);
    *resolved = report.parameters.value[VOR_PARAM_NEIGHBORS];
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return mean;
}

START_TEST(what_it_finds_denoises_and_the_report_says_what_it_was)
{
    struct vor_cloud cloud;
    double few, found, k20, k;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    add_noise(&cloud, (uint64_t)_i, 0.8 * spacing(&vt_shapes[VT_SPHERE], N));
    few = off(&cloud, "20", &k20);
    found = off(&cloud, "auto", &k);
    ck_assert(k20 == 20);
    ck_assert(k == neighbors_of(&cloud, 1));
    ck_assert_msg(found < few / 2, "%g off with %g, %g with 20", found, k, few);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("scale");

    vt_add_loop(suite, an_exact_cloud_is_fitted_closely, VT_FEWER(SEEDS));
    vt_add_loop(suite, noise_asks_for_more, VT_FEWER(SEEDS));
    vt_add_loop(suite, a_lattice_is_noise_too, VT_FEWER(SEEDS));
    vt_add(suite, one_two_three_and_eight_threads_and_any_power_of_two_find_the_same);
    vt_add_loop(suite, a_few_points_are_never_asked_for_more_than_an_eighth_of_them,
                VT_FEWER(SEEDS));
    vt_add_loop(suite, what_it_finds_denoises_and_the_report_says_what_it_was, VT_FEWER(SEEDS));
    return vt_run(suite);
}
