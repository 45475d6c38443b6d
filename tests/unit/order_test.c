/* The progressive order, where one can tell by hand what it is, and what it promises of each step.
 */
#include "core/output/order.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>

/* By how much the next point may be nearer than the farthest: MARGIN * NEARLY of order.c. */
#define NEARLY_FARTHEST (0.98 * 0.85)

enum { SEEDS = 4, N = 1500 };

static uint32_t *order_of(const float *xyz, size_t n, double spacing, unsigned threads)
{
    struct vt_engine engine;
    uint32_t *order = malloc(n * sizeof *order);

    ck_assert_ptr_nonnull(order);
    vt_engine_open(&engine, threads);
    vt_assert_ok(vor_order_progressive(order, xyz, n, spacing, &engine.run, &vt_err));
    vt_engine_close(&engine);
    return order;
}

static void expect(const float *xyz, size_t n, double spacing, const uint32_t *wanted)
{
    uint32_t *order = order_of(xyz, n, spacing, 1);

    for (size_t k = 0; k < n; k++)
        ck_assert_msg(order[k] == wanted[k], "of %zu, number %zu is %u, want %u", n, k, order[k],
                      wanted[k]);
    free(order);
}

static void expect_permutation(const uint32_t *order, size_t n)
{
    unsigned char *seen = calloc(n, 1);

    ck_assert_ptr_nonnull(seen);
    for (size_t k = 0; k < n; k++) {
        ck_assert_uint_lt(order[k], n);
        ck_assert_uint_eq(seen[order[k]]++, 0);
    }
    free(seen);
}

VT_TEST(of_three_points_the_farther_one_is_second)
{
    static const float xyz[9] = {0, 0, 0, 0.25f, 0, 0, 1, 0, 0};
    static const uint32_t wanted[3] = {0, 2, 1};

    expect(xyz, 1, 0, wanted);
    expect(xyz, 2, 0, (const uint32_t[2]){0, 1});
    expect(xyz, 3, 0, wanted);
    expect(xyz, 3, 0.25, wanted);
}

VT_TEST(points_in_one_place_come_last_by_index)
{
    static const uint32_t one[6] = {0, 1, 2, 3, 4, 5}, two[6] = {0, 3, 1, 2, 4, 5};
    float xyz[18] = {0};

    expect(xyz, 6, 0, one);
    for (int i = 0; i < 6; i++)
        xyz[3 * i] = xyz[3 * i + 1] = xyz[3 * i + 2] = 7;
    expect(xyz, 6, 0, one);
    xyz[9] = xyz[12] = -7;
    expect(xyz, 6, 0, two);
}

/* The oracle: how far each is from all before it, by looking at every one. */
VT_TEST_FIGURES(every_next_point_is_nearly_the_farthest, SEEDS)
{
    struct vor_cloud cloud;
    uint32_t *order;
    double *reach = malloc(N * sizeof *reach);

    ck_assert_ptr_nonnull(reach);
    vt_cloud_box(&cloud, (uint64_t)_i, N);
    order = order_of(cloud.xyz, N, _i % 2 ? 0 : 0.03, 2);
    expect_permutation(order, N);
    for (size_t i = 0; i < N; i++)
        reach[i] = (double)INFINITY;
    for (size_t k = 0; k < N; k++) {
        const float *x = &cloud.xyz[3 * (size_t)order[k]];
        double farthest = 0;

        for (size_t i = 0; i < N; i++)
            farthest = fmax(farthest, reach[i]);
        if (k > 0)
            ck_assert_msg(reach[order[k]] >= NEARLY_FARTHEST * (1 - 1e-6) * farthest,
                          "number %zu is at %g, the farthest at %g", k, reach[order[k]], farthest);
        for (size_t i = 0; i < N; i++) {
            const float *y = &cloud.xyz[3 * i];
            double d[3] = {(double)y[0] - x[0], (double)y[1] - x[1], (double)y[2] - x[2]};

            reach[i] = fmin(reach[i], sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
        }
    }
    free(reach);
    free(order);
    vor_cloud_free(&cloud);
}

/* One crowd in a corner no wider than 1e-7 of the whole, as an outlier in the input can leave it.
 */
VT_TEST(a_crowd_in_a_corner_comes_after_all_that_is_wide)
{
    enum { FEW = 50 };
    struct vor_cloud cloud;
    uint32_t *order;

    vt_cloud_box(&cloud, 5, N);
    for (size_t i = 3 * FEW; i < 3 * N; i++)
        cloud.xyz[i] = 1 + ldexpf(rintf(64 * cloud.xyz[i]), -23);
    order = order_of(cloud.xyz, N, 1e-6, 2);
    expect_permutation(order, N);
    for (size_t k = 0, crowd = 0; k < FEW; k++) {
        crowd += order[k] >= FEW;
        ck_assert_uint_le(crowd, 1);
    }
    free(order);
    vor_cloud_free(&cloud);
}
