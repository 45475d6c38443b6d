/* The Morton order. */
#include "core/base/morton.h"
#include "tests/support/vt_engine.h"

enum { SEEDS = 20, N = 1000 };

static void order_of(uint32_t *order, const struct vor_cloud *cloud)
{
    struct vt_engine engine;

    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_morton_order(order, cloud->xyz, cloud->n, &engine.run, &vt_err));
    vt_engine_close(&engine);
}

VT_TEST(the_corners_of_a_cube_come_with_x_fastest)
{
    struct vor_cloud cloud;
    uint32_t order[8];

    vt_cloud_make(&cloud, 8);
    for (size_t i = 0; i < 8; i++)
        for (size_t c = 0; c < 3; c++)
            cloud.xyz[3 * i + c] = (float)((7 - i) >> c & 1);
    order_of(order, &cloud);
    for (uint32_t i = 0; i < 8; i++)
        ck_assert_uint_eq(order[i], 7 - i);
    vor_cloud_free(&cloud);
}

/* Property: what it is for. Steps along the order are far shorter than between random points, whose
 * mean distance in a cube is 0.66. */
VT_TEST_LOOP(neighbours_in_the_order_are_near_in_space, SEEDS)
{
    struct vor_cloud cloud;
    uint32_t order[N];
    double sum = 0;

    vt_cloud_cube(&cloud, (uint64_t)_i, N);
    order_of(order, &cloud);
    for (size_t i = 1; i < N; i++) {
        double d2 = 0;

        for (size_t c = 0; c < 3; c++) {
            double d = (double)cloud.xyz[3 * (size_t)order[i] + c] -
                       (double)cloud.xyz[3 * (size_t)order[i - 1] + c];

            d2 += d * d;
        }
        sum += d2;
    }
    ck_assert_double_lt(sum / (N - 1), 0.2 * 0.2);
    vor_cloud_free(&cloud);
}
