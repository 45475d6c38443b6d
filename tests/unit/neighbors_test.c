/* How many neighbours an input is found to want. */
#include "core/input/neighbors.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 4, N = 20000, EXACT = 20 };

static void find(struct vor_neighbors *neighbors, struct vor_domain *domain,
                 const struct vor_cloud *cloud, unsigned threads)
{
    struct vt_engine engine;

    vt_engine_open(&engine, threads);
    vt_assert_ok(vor_domain_init(domain, cloud, &engine.run, &vt_err));
    memset(neighbors, 0, sizeof *neighbors);
    vt_assert_ok(vor_neighbors_choose(neighbors, domain, &engine.run, &vt_err));
    vt_engine_close(&engine);
}

/* The usual number. */
static unsigned neighbors_of(const struct vor_cloud *cloud, unsigned threads)
{
    struct vor_domain domain;
    struct vor_neighbors neighbors;

    find(&neighbors, &domain, cloud, threads);
    vor_domain_free(&domain);
    return neighbors.usual;
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

/* The same where x > 0 only. */
static void add_noise_to_half(struct vor_cloud *cloud, uint64_t seed, double sigma)
{
    for (size_t i = 0; i < cloud->n; i++) {
        int noisy = cloud->xyz[3 * i] > 0;

        for (size_t c = 0; noisy && c < 3; c++)
            cloud->xyz[3 * i + c] += (float)(sigma * vt_normal(seed, 3 * i + c));
    }
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
    struct vor_domain domain;
    struct vor_neighbors neighbors;

    for (size_t i = 0; i < sizeof makes / sizeof *makes; i++) {
        makes[i](&cloud, (uint64_t)_i, N);
        find(&neighbors, &domain, &cloud, 2);
        ck_assert_msg(neighbors.usual == EXACT && neighbors.most == EXACT && neighbors.places == 0,
                      "shape %zu", i);
        vor_domain_free(&domain);
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

/* Half of it exact, half noisy: at every place as many as that half wants by itself, but for a seam
 * as wide as the places that decide together reach. */
START_TEST(each_region_is_asked_by_itself)
{
    const double seam = 0.7;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_neighbors neighbors;
    unsigned exact = 0, noisy = 0, alone;

    vt_cloud_torus(&cloud, (uint64_t)_i, N);
    add_noise(&cloud, (uint64_t)_i + SEEDS, 0.8 * spacing(&vt_shapes[VT_TORUS], N));
    alone = neighbors_of(&cloud, 2);
    vor_cloud_free(&cloud);
    vt_cloud_torus(&cloud, (uint64_t)_i, N);
    add_noise_to_half(&cloud, (uint64_t)_i + SEEDS, 0.8 * spacing(&vt_shapes[VT_TORUS], N));
    find(&neighbors, &domain, &cloud, 2);
    ck_assert_uint_eq(neighbors.places, VOR_NEIGHBORS_PLACES);
    for (size_t i = 0; i < VOR_NEIGHBORS_PLACES; i++) {
        const float *x = &neighbors.xyz[3 * i];
        double at = (double)x[0] * domain.unit + domain.shift[0];

        ck_assert_uint_eq(vor_neighbors_at(&neighbors, x), neighbors.k[i]);
        if (at < -seam) {
            ck_assert_uint_eq(neighbors.k[i], EXACT);
            exact++;
        } else if (at > seam) {
            ck_assert_msg(2 * neighbors.k[i] > alone && neighbors.k[i] < 2 * alone, "%u, not %u",
                          neighbors.k[i], alone);
            noisy++;
        }
    }
    ck_assert_uint_ge(exact, VOR_NEIGHBORS_PLACES / 8);
    ck_assert_uint_ge(noisy, VOR_NEIGHBORS_PLACES / 8);
    vor_domain_free(&domain);
    vor_cloud_free(&cloud);
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

/* Mean distance to its surface of a result with that many neighbours. */
static double off(const struct vor_cloud *in, const struct vt_shape *shape, const char *neighbors,
                  struct vor_report *report)
{
    struct vt_engine engine;
    struct vor_cloud out;
    double mean;

    vt_engine_open(&engine, 2);
    vt_engine_set(&engine, "points", "2000");
    vt_engine_set(&engine, "neighbors", neighbors);
    vt_engine_set(&engine, "polish", "30");
    vt_engine_resample(&engine, &out, report, in);
    mean = vt_off_mean(shape, &out);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return mean;
}

static double neighbors(const struct vor_report *report)
{
    return report->parameters.value[VOR_PARAM_NEIGHBORS];
}

START_TEST(what_it_finds_denoises_and_the_report_says_what_it_was)
{
    const struct vt_shape *sphere = &vt_shapes[VT_SPHERE];
    struct vor_report report;
    struct vor_cloud cloud;
    double few, found;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    add_noise(&cloud, (uint64_t)_i, 0.8 * spacing(sphere, N));
    few = off(&cloud, sphere, "20", &report);
    ck_assert(neighbors(&report) == 20);
    found = off(&cloud, sphere, "auto", &report);
    ck_assert(neighbors(&report) == neighbors_of(&cloud, 1));
    ck_assert_msg(found < few / 2, "%g off with %g, %g with 20", found, neighbors(&report), few);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

START_TEST(a_cloud_noisy_in_parts_is_off_by_less_than_with_any_one_number)
{
    static const char *const ladder[] = {"20", "30", "45", "70", "100", "150"};
    const struct vt_shape *torus = &vt_shapes[VT_TORUS];
    struct vor_report report;
    struct vor_cloud cloud;
    double found, one;
    uint64_t counted = 0;

    vt_cloud_torus(&cloud, (uint64_t)_i, N);
    add_noise_to_half(&cloud, (uint64_t)_i, 0.8 * spacing(torus, N));
    found = off(&cloud, torus, "auto", &report);
    ck_assert_uint_ge(report.fitted_count, 3);
    for (unsigned i = 0; i < report.fitted_count; i++) {
        ck_assert(i == 0 || report.fitted[i].neighbors > report.fitted[i - 1].neighbors);
        counted += report.fitted[i].points;
    }
    ck_assert_uint_eq(counted, report.points_out);
    for (size_t i = 0; i < sizeof ladder / sizeof *ladder; i++) {
        one = off(&cloud, torus, ladder[i], &report);
        ck_assert_msg(found < one, "%g off, %g with %s", found, one, ladder[i]);
    }
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("neighbors");

    vt_add_figures(suite, an_exact_cloud_is_fitted_closely, VT_FEWER(SEEDS));
    vt_add_figures(suite, noise_asks_for_more, VT_FEWER(SEEDS));
    vt_add_figures(suite, each_region_is_asked_by_itself, VT_FEWER(SEEDS));
    vt_add_figures(suite, a_lattice_is_noise_too, VT_FEWER(SEEDS));
    vt_add(suite, one_two_three_and_eight_threads_and_any_power_of_two_find_the_same);
    vt_add_figures(suite, a_few_points_are_never_asked_for_more_than_an_eighth_of_them,
                   VT_FEWER(SEEDS));
    vt_add_loop(suite, what_it_finds_denoises_and_the_report_says_what_it_was,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_figures(suite, a_cloud_noisy_in_parts_is_off_by_less_than_with_any_one_number,
                   VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    return vt_run(suite);
}
