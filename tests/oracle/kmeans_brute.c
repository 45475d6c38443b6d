/* Oracle: k-means that looks at every seed for every point. */
#include "core/kmeans/kmeans.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 6, N = 500, K = 60, ITERATIONS = 12 };

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
};

/* The input lies in a plane, so that putting the means onto its surface moves none of them. */
static void open_bed(struct bed *bed, uint64_t seed)
{
    vt_engine_open(&bed->engine, 2);
    vt_engine_count(&bed->engine, "seed", (size_t)seed + 1);
    vt_engine_set(&bed->engine, "boundary", "free");
    vt_cloud_square(&bed->cloud, seed, N);
    vt_assert_ok(vor_domain_init(&bed->domain, &bed->cloud, &bed->engine.run, &vt_err));
    ck_assert_uint_eq(bed->domain.n, N);
}

static void close_bed(struct bed *bed)
{
    vor_domain_free(&bed->domain);
    vor_cloud_free(&bed->cloud);
    vt_engine_close(&bed->engine);
}

static void run_kmeans(struct vor_seeds *out, struct vor_outcome *told, struct bed *bed,
                       size_t iterations)
{
    memset(told, 0, sizeof *told);
    vt_engine_count(&bed->engine, "iterations", iterations);
    vt_assert_ok(
        vor_kmeans_run(out, told, &bed->domain, K, &bed->engine.spec, &bed->engine.run, &vt_err));
    ck_assert_uint_eq(out->n, K);
    ck_assert_uint_eq(told->last.step, iterations);
    ck_assert_uint_eq(told->steps[VOR_RUN_STAGE_ITERATE], iterations);
}

static double distance2(const float *a, const double *b)
{
    double sum = 0;

    for (int c = 0; c < 3; c++)
        sum += ((double)a[c] - b[c]) * ((double)a[c] - b[c]);
    return sum;
}

/* The input point nearest to x. */
static size_t nearest_input(const struct vor_domain *domain, const float *x)
{
    double at[3] = {(double)x[0], (double)x[1], (double)x[2]};
    size_t best = 0;

    for (size_t i = 1; i < domain->n; i++)
        if (distance2(&domain->xyz[3 * i], at) < distance2(&domain->xyz[3 * best], at))
            best = i;
    return best;
}

/* The slow twin of one iteration; rounds to float as the seeds are. */
static void iterate(double x[K][3], const struct vor_domain *domain)
{
    double sum[K][3] = {{0}};
    size_t count[K] = {0};

    for (size_t i = 0; i < domain->n; i++) {
        const float *point = &domain->xyz[3 * i];
        size_t best = 0;

        for (size_t k = 1; k < K; k++)
            best = distance2(point, x[k]) < distance2(point, x[best]) ? k : best;
        count[best]++;
        for (int c = 0; c < 3; c++)
            sum[best][c] += (double)point[c];
    }
    for (size_t k = 0; k < K; k++)
        for (int c = 0; c < 3 && count[k] > 0; c++)
            x[k][c] = (double)(float)(sum[k][c] / (double)count[k]);
}

VT_TEST_LOOP(it_starts_at_input_points_no_two_alike, SEEDS)
{
    struct vor_outcome told;
    struct vor_seeds start;
    struct bed bed;
    int taken[N] = {0};

    open_bed(&bed, (uint64_t)_i);
    run_kmeans(&start, &told, &bed, 0);
    for (size_t k = 0; k < K; k++) {
        size_t at = nearest_input(&bed.domain, &start.xyz[3 * k]);
        double x[3] = {(double)start.xyz[3 * k], (double)start.xyz[3 * k + 1],
                       (double)start.xyz[3 * k + 2]};

        ck_assert_double_le(distance2(&bed.domain.xyz[3 * at], x), 1e-12);
        ck_assert_int_eq(taken[at]++, 0);
    }
    vor_seeds_free(&start);
    close_bed(&bed);
}

VT_TEST_LOOP(each_iterate_is_that_of_a_look_at_every_seed, SEEDS)
{
    struct vor_outcome told;
    struct vor_seeds start, end;
    struct bed bed;
    double x[K][3], before[K][3], longest = 0;

    open_bed(&bed, (uint64_t)_i);
    run_kmeans(&start, &told, &bed, 0);
    run_kmeans(&end, &told, &bed, ITERATIONS);
    ck_assert_uint_gt(told.kept.iteration, 0);
    for (size_t k = 0; k < K; k++) {
        size_t at = nearest_input(&bed.domain, &start.xyz[3 * k]);

        for (size_t c = 0; c < 3; c++)
            x[k][c] = (double)bed.domain.xyz[3 * at + c];
    }
    for (uint32_t step = 0; step < told.kept.iteration; step++) {
        memcpy(before, x, sizeof before);
        iterate(x, &bed.domain);
    }
    for (size_t k = 0; k < K; k++) {
        double d2 = 0;

        ck_assert_double_le(distance2(&end.xyz[3 * k], x[k]), 1e-12);
        for (int c = 0; c < 3; c++)
            d2 += (x[k][c] - before[k][c]) * (x[k][c] - before[k][c]);
        longest = fmax(longest, sqrt(d2));
    }
    ck_assert_double_eq_tol(told.kept.max_move, longest * bed.domain.unit, 1e-6 * bed.domain.unit);
    vor_seeds_free(&start);
    vor_seeds_free(&end);
    close_bed(&bed);
}
