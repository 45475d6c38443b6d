/* The Morton order. */
#include "core/base/morton.h"
#include "tests/support/vt_engine.h"

#include <string.h>

enum { SEEDS = 20, N = 1000 };

static void order_of(uint32_t *order, const struct vor_cloud *cloud)
{
    struct vt_engine engine;

    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_morton_order(order, cloud->xyz, cloud->n, &engine.run, &vt_err));
    vt_engine_close(&engine);
}

static void assert_permutation(const uint32_t *order, size_t n)
{
    unsigned char *seen = vor_calloc(&vt_memory, n, 1);

    for (size_t i = 0; i < n; i++) {
        ck_assert_uint_lt(order[i], n);
        ck_assert(!seen[order[i]]);
        seen[order[i]] = 1;
    }
    vor_free(&vt_memory, seen);
}

START_TEST(the_order_holds_every_point_once)
{
    struct vor_cloud cloud;
    uint32_t order[N];

    vt_cloud_cube(&cloud, (uint64_t)_i, N - (size_t)_i);
    order_of(order, &cloud);
    assert_permutation(order, cloud.n);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

/* Vector: the corners of a cube, x running fastest. */
START_TEST(the_corners_of_a_cube_come_with_x_fastest)
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
END_TEST

/* Every place three times, far apart in the input. */
START_TEST(coincident_points_follow_each_other_first_one_first)
{
    struct vor_cloud cloud;
    uint32_t order[N];
    size_t places = N / 3, n = 3 * places;

    vt_cloud_cube(&cloud, (uint64_t)_i, n);
    memcpy(&cloud.xyz[3 * places], cloud.xyz, 3 * places * sizeof *cloud.xyz);
    memcpy(&cloud.xyz[6 * places], cloud.xyz, 3 * places * sizeof *cloud.xyz);
    order_of(order, &cloud);
    assert_permutation(order, n);
    for (size_t i = 0; i < n; i += 3) {
        ck_assert_uint_lt(order[i], places);
        ck_assert_uint_eq(order[i + 1], order[i] + places);
        ck_assert_uint_eq(order[i + 2], order[i] + 2 * places);
    }
    vor_cloud_free(&cloud);
}
END_TEST

/* Points nearer to each other than a cell of the grid is wide still get an order of their own. */
START_TEST(points_of_one_cell_are_sorted_by_their_coordinates)
{
    struct vor_cloud cloud;
    uint32_t order[N];

    vt_cloud_cube(&cloud, (uint64_t)_i, N);
    for (size_t i = 0; i < 3 * (N - 1); i++)
        cloud.xyz[i] *= 1e-8f;
    for (size_t c = 0; c < 3; c++)
        cloud.xyz[3 * (N - 1) + c] = 1;
    order_of(order, &cloud);
    assert_permutation(order, N);
    for (size_t i = 1; i < N; i++)
        ck_assert(cloud.xyz[3 * (size_t)order[i - 1]] <= cloud.xyz[3 * (size_t)order[i]]);
    ck_assert_uint_eq(order[N - 1], N - 1);
    vor_cloud_free(&cloud);
}
END_TEST

/* Property: what it is for. Steps along the order are far shorter than between random points, whose
 * mean distance in a cube is 0.66. */
START_TEST(neighbours_in_the_order_are_near_in_space)
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
END_TEST

START_TEST(one_place_and_one_point_are_ordered_by_index)
{
    struct vor_cloud cloud;
    uint32_t order[5];

    vt_cloud_make(&cloud, 5);
    for (size_t i = 0; i < 15; i++)
        cloud.xyz[i] = -3;
    order_of(order, &cloud);
    for (uint32_t i = 0; i < 5; i++)
        ck_assert_uint_eq(order[i], i);
    cloud.n = 1;
    order_of(order, &cloud);
    ck_assert_uint_eq(order[0], 0);
    vor_cloud_free(&cloud);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("morton");

    vt_add_loop(suite, the_order_holds_every_point_once, SEEDS);
    vt_add(suite, the_corners_of_a_cube_come_with_x_fastest);
    vt_add_loop(suite, coincident_points_follow_each_other_first_one_first, SEEDS);
    vt_add_loop(suite, points_of_one_cell_are_sorted_by_their_coordinates, SEEDS);
    vt_add_loop(suite, neighbours_in_the_order_are_near_in_space, SEEDS);
    vt_add(suite, one_place_and_one_point_are_ordered_by_index);
    return vt_run(suite);
}
