/* Where the seeds start: at points of an input that has plenty, else in cells. */
#include "core/seeds/start.h"
#include "tests/support/vt_engine.h"

#include <string.h>

enum { SEEDS = 5, N = 12000, FEW = 600 };

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_seeds seeds;
};

static void start(struct bed *bed, uint64_t seed, unsigned threads, size_t n)
{
    vt_engine_open(&bed->engine, threads);
    vt_engine_set(&bed->engine, "neighbors", "20");
    vt_engine_count(&bed->engine, "seed", (size_t)seed);
    vt_assert_ok(vor_domain_init(&bed->domain, &bed->cloud, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_start_seeds(&bed->seeds, &bed->domain, n, &bed->engine.spec, &bed->engine.run,
                                 &vt_err));
    ck_assert_uint_eq(bed->seeds.n, n);
}

static void end(struct bed *bed)
{
    vor_seeds_free(&bed->seeds);
    vor_domain_free(&bed->domain);
    vt_engine_close(&bed->engine);
}

/* How many seeds lie where an earlier one does. */
static size_t shared_places(const struct vor_seeds *seeds)
{
    struct vor_cloud places;
    size_t shared;

    vt_cloud_make(&places, seeds->n);
    memcpy(places.xyz, seeds->xyz, 3 * seeds->n * sizeof *seeds->xyz);
    shared = vt_coincident(&places);
    vor_cloud_free(&places);
    return shared;
}

static int is_input(const struct vor_domain *domain, const float *x)
{
    for (size_t i = 0; i < domain->n; i++)
        if (memcmp(&domain->xyz[3 * i], x, 3 * sizeof *x) == 0)
            return 1;
    return 0;
}

START_TEST(of_plenty_of_points_each_seed_takes_its_own)
{
    struct bed bed;

    vt_cloud_box(&bed.cloud, (uint64_t)_i, N);
    start(&bed, (uint64_t)_i + 1, 2, FEW);
    for (size_t i = 0; i < FEW; i++)
        ck_assert(is_input(&bed.domain, &bed.seeds.xyz[3 * i]));
    ck_assert_uint_eq(shared_places(&bed.seeds), 0);
    end(&bed);
    vor_cloud_free(&bed.cloud);
    vt_assert_no_leak();
}
END_TEST

/* Ten points a seed is the least; from fewer, the seeds start inside cells, not at points. */
START_TEST(of_few_points_the_seeds_start_in_cells)
{
    struct bed bed;
    size_t at_points = 0;

    vt_cloud_box(&bed.cloud, (uint64_t)_i, 2000);
    start(&bed, 1, 2, 201);
    for (size_t i = 0; i < 201; i++)
        at_points += (size_t)is_input(&bed.domain, &bed.seeds.xyz[3 * i]);
    ck_assert_uint_lt(at_points, 10);
    end(&bed);
    start(&bed, 1, 2, 200);
    for (size_t i = 0; i < 200; i++)
        ck_assert(is_input(&bed.domain, &bed.seeds.xyz[3 * i]));
    end(&bed);
    vor_cloud_free(&bed.cloud);
}
END_TEST

/* A square whose left half has `times` points for each of the right half's. */
static void uneven_square(struct vor_cloud *cloud, uint64_t seed, size_t n, size_t times)
{
    vt_cloud_square(cloud, seed, n);
    for (size_t i = 0; i < n; i++)
        cloud->xyz[3 * i] = cloud->xyz[3 * i] / 2 + (i % (times + 1) == 0 ? 0.5f : 0);
}

static double share_left(const struct bed *bed)
{
    double left = 0;

    for (size_t i = 0; i < bed->seeds.n; i++)
        left += (double)bed->seeds.xyz[3 * i] * bed->domain.unit + bed->domain.shift[0] < 0.5;
    return left / (double)bed->seeds.n;
}

/* Either half gets half, though one has ten times the points; and nearly so where the other has so
 * few that they would have to be taken twice, and cells are made of a draw that has ten there. */
START_TEST(a_dense_half_gets_no_more_than_its_area)
{
    static const size_t times[2] = {10, 60};
    static const double tolerance[2] = {0.05, 0.15};
    struct bed bed;

    for (int k = 0; k < 2; k++) {
        uneven_square(&bed.cloud, (uint64_t)_i, N, times[k]);
        start(&bed, (uint64_t)_i + 1, 2, FEW);
        ck_assert_double_eq_tol(share_left(&bed), 0.5, tolerance[k]);
        ck_assert_uint_eq(shared_places(&bed.seeds), 0);
        end(&bed);
        vor_cloud_free(&bed.cloud);
    }
}
END_TEST

START_TEST(the_area_is_that_of_the_surface)
{
    struct bed bed;

    vt_cloud_box(&bed.cloud, (uint64_t)_i, N);
    for (size_t n = FEW; n <= 2 * N; n *= 40) {
        start(&bed, 1, 2, n);
        ck_assert_double_eq_tol(bed.seeds.area * bed.domain.unit * bed.domain.unit / 6, 1, 0.1);
        end(&bed);
    }
    vor_cloud_free(&bed.cloud);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("init");

    vt_add_figures(suite, of_plenty_of_points_each_seed_takes_its_own, SEEDS);
    vt_add_figures(suite, of_few_points_the_seeds_start_in_cells, SEEDS);
    vt_add_figures(suite, a_dense_half_gets_no_more_than_its_area, SEEDS);
    vt_add_figures(suite, the_area_is_that_of_the_surface, SEEDS);
    return vt_run(suite);
}
