/* Where a cloud lies, about how much surface it has, and the steps of float32 from an origin. */
#include "core/cloud/extent.h"
#include "tests/support/vt.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { SEEDS = 20 };

static const double zero[3] = {0, 0, 0};

VT_TEST(the_box_is_in_absolute_coordinates)
{
    static const float xyz[] = {1, -2, 3, -4, 5, 0.5F};
    struct vor_extent extent;
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 2);
    memcpy(cloud.xyz, xyz, sizeof xyz);
    cloud.origin[0] = 637000.25;
    cloud.origin[2] = -1e7;
    vor_extent_measure(&extent, &cloud);
    ck_assert_uint_eq(extent.n, 2);
    ck_assert(extent.low[0] == 637000.25 - 4 && extent.high[0] == 637000.25 + 1);
    ck_assert(extent.low[1] == -2 && extent.high[1] == 5);
    ck_assert(extent.low[2] == -1e7 + 0.5 && extent.high[2] == -1e7 + 3);
    vor_cloud_free(&cloud);
}

/* Vector: n points of a unit square lie 1.0746 / sqrt(n) apart in a hexagonal lattice, and those of
 * the unit sphere sqrt(4 pi) times as far. */
VT_TEST_LOOP(the_spacing_is_estimated_within_a_factor, SEEDS)
{
    static const size_t counts[] = {40, 200, 1000, 10000, 60000};
    size_t n = counts[_i % 5];
    struct vor_extent extent;
    struct vor_cloud cloud;
    double square, sphere;

    vt_cloud_square(&cloud, (uint64_t)_i, n);
    vor_extent_measure(&extent, &cloud);
    square = vor_extent_spacing(&extent, (double)n) * sqrt((double)n) / 1.0746;
    vor_cloud_free(&cloud);
    vt_cloud_sphere(&cloud, (uint64_t)_i, n);
    vor_extent_measure(&extent, &cloud);
    sphere =
        vor_extent_spacing(&extent, (double)n) * sqrt((double)n) / 1.0746 / sqrt(4 * 3.14159265);
    vor_cloud_free(&cloud);
    ck_assert_msg(square > 0.6 && square < 1.05, "%zu points of a square: %g", n, square);
    ck_assert_msg(sphere > 0.6 && sphere < 1.3, "%zu points of a sphere: %g", n, sphere);
    ck_assert_double_eq_tol(vor_extent_spacing(&extent, (double)n / 4),
                            2 * vor_extent_spacing(&extent, (double)n), 1e-12);
}

VT_TEST_LOOP(pieces_of_a_walk_measure_the_same, SEEDS)
{
    size_t n = 1 + (size_t)_i * 53, piece = 1 + (size_t)_i % 7 * 31;
    struct vor_extent whole, walked;
    struct vor_extent_walk walk;
    struct vor_cloud cloud;

    vt_cloud_sphere(&cloud, (uint64_t)_i, n);
    vor_extent_measure(&whole, &cloud);
    vor_extent_begin(&walk, &cloud);
    for (size_t i = 0; i < (size_t)_i % 3 * n; i += piece) /* none, half, all, and beyond */
        vor_extent_walk(&walk, piece);
    vor_extent_end(&walked, &walk);
    ck_assert_mem_eq(&walked, &whole, sizeof whole);
    vor_cloud_free(&cloud);
}

VT_TEST(points_in_one_place_have_no_area)
{
    struct vor_extent extent;
    struct vor_cloud cloud;
    double middle[3];

    vt_cloud_cube(&cloud, 3, 7);
    for (int i = 0; i < 21; i++)
        cloud.xyz[i] = (float)(i % 3);
    cloud.origin[0] = 637000.4;
    vor_extent_measure(&extent, &cloud);
    ck_assert(extent.area == 0);
    ck_assert(vor_extent_spacing(&extent, 7) == 0);
    vor_extent_middle(middle, &extent, 0);
    ck_assert(middle[0] == 637000 && middle[1] == 1 && middle[2] == 2);
    vor_extent_middle(middle, &extent, 1e-9);
    ck_assert(middle[0] == 637000 && middle[1] == 1 && middle[2] == 2);
    vor_cloud_free(&cloud);
}

/* Vector: the distance from a float to the next larger one. */
VT_TEST(the_step_is_that_of_float32_at_the_farthest_coordinate)
{
    static const double far[] = {1, 1.5, 637123.4, 849254.25, 4e6, 1e-30, 3e38, 0, 1e-45, 0.1};

    for (size_t i = 0; i < sizeof far / sizeof *far; i++) {
        struct vor_extent extent = {
            .n = 2, .low = {-far[i] / 2, 0, 0}, .high = {0, far[i], far[i] / 3}};
        float there = (float)far[i];
        double step = (double)nextafterf(there, INFINITY) - (double)there;

        if (there < FLT_MIN)
            step = (double)nextafterf(0, 1);
        ck_assert_msg(vor_extent_step(&extent, zero) == step, "at %g: %g and not %g", far[i],
                      vor_extent_step(&extent, zero), step);
    }
}

VT_TEST(the_step_counts_from_the_origin_and_ends_with_float32)
{
    struct vor_extent extent = {.n = 2, .low = {637000, 0, 0}, .high = {637100, 3, 0}};
    static const double origin[3] = {637050, 0, 0}, far[3] = {1e39, 0, 0};

    ck_assert(vor_extent_step(&extent, zero) == 0.0625);
    ck_assert(vor_extent_step(&extent, origin) == 0x1p-18);
    ck_assert(isinf(vor_extent_step(&extent, far)));
}

VT_TEST(the_middle_is_whole)
{
    struct vor_extent extent = {
        .n = 9, .low = {637177.98, 849393.5, -10.2}, .high = {639003.73, 853536.2, 10.1}};
    double middle[3];

    vor_extent_middle(middle, &extent, 0.007);
    ck_assert(middle[0] == 638091 && middle[1] == 851465 && middle[2] == 0);
    ck_assert(!signbit(middle[2]));
}

/* A cloud of a millionth across, a third from 0: whole numbers would leave nothing of it. */
VT_TEST(the_middle_of_a_tiny_cloud_is_as_fine_as_it_must_be)
{
    struct vor_extent extent = {.n = 9, .low = {0.3333333, 0, 0}, .high = {0.3333343, 1e-6, 1e-6}};
    double middle[3];

    vor_extent_middle(middle, &extent, 1e-8 / 200);
    ck_assert(vor_extent_step(&extent, middle) <= 1e-8 / 200);
    for (int c = 0; c < 3; c++)
        ck_assert(fmod(middle[c], 0x1p-30) == 0);
    vor_extent_middle(middle, &extent, 1e-7); /* a step that whole numbers reach */
    ck_assert(middle[0] == 0);
}
