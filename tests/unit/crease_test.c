/* The crease that is fitted to the points around one: what it recovers and where it is none. */
#include "core/base/linalg.h"
#include "core/geom/crease.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 20, K = 24 };

static double upright[3][3] = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}; /* v is y, u is x, w is z */

/* The first point at the origin of the plane, the others in a disc of radius 2.8 around it. */
static void scatter(float *near, uint64_t seed)
{
    memset(near, 0, 3 * K * sizeof *near);
    for (size_t j = 1, drawn = 0; j < K; drawn++) {
        double x = 5.6 * vt_unit(seed, 2 * drawn) - 2.8,
               y = 5.6 * vt_unit(seed, 2 * drawn + 1) - 2.8;

        if (x * x + y * y > 2.8 * 2.8)
            continue;
        near[3 * j] = (float)x;
        near[3 * j++ + 1] = (float)y;
    }
}

/* Folds the plane along x = at + slant y: heights fall by `slope` on either side. */
static void fold(float *near, double at, double slant, double slope)
{
    for (size_t j = 0; j < K; j++)
        near[3 * j + 2] =
            (float)(-slope * fabs((double)near[3 * j] - at - slant * (double)near[3 * j + 1]));
}

static double sine_of_half(double slope)
{
    return slope / sqrt(1 + slope * slope);
}

START_TEST(a_folded_plane_has_its_edge_where_it_is_folded)
{
    double at = 1.6 * vt_unit((uint64_t)_i, 500) - 0.8, slope = 0.3 + vt_unit((uint64_t)_i, 501);
    struct vor_crease crease;
    float near[3 * K];

    scatter(near, (uint64_t)_i);
    fold(near, at, 0, slope);
    vor_crease_fit(&crease, near, K, upright, 1);
    ck_assert_double_eq_tol(crease.distance, fabs(at), 0.03); /* the rounds are few */
    ck_assert_double_le(crease.crease2, 0.01 * crease.smooth2);
    ck_assert_double_ge(fabs(crease.along[1]), 0.999);
    ck_assert_double_eq_tol(crease.turn, sine_of_half(slope), 0.08);
}
END_TEST

START_TEST(an_edge_askew_to_the_axis_is_found_askew)
{
    double slant = 0.6 * vt_unit((uint64_t)_i, 502) - 0.3, length = sqrt(1 + slant * slant);
    struct vor_crease crease;
    float near[3 * K];

    scatter(near, (uint64_t)_i);
    fold(near, 0, slant, 1);
    vor_crease_fit(&crease, near, K, upright, 1);
    ck_assert_double_le(crease.distance, 0.25);
    ck_assert_double_ge(fabs(crease.along[0] * slant + crease.along[1]) / length, 0.98);
}
END_TEST

START_TEST(lengths_are_in_spacings)
{
    struct vor_crease one, half;
    float near[3 * K];

    scatter(near, (uint64_t)_i);
    fold(near, 0.5, 0, 1);
    vor_crease_fit(&one, near, K, upright, 1);
    vor_crease_fit(&half, near, K, upright, 0.5);
    ck_assert_double_eq_tol(one.distance, 0.5, 1e-3);
    ck_assert_double_eq_tol(half.distance, 1, 0.05);
    ck_assert_double_eq_tol(half.smooth2, 4 * one.smooth2, 1e-9);
}
END_TEST

START_TEST(a_curved_surface_is_no_crease)
{
    struct vor_crease crease;
    float near[3 * K];

    scatter(near, (uint64_t)_i);
    for (size_t j = 0; j < K; j++) {
        double x = (double)near[3 * j], y = (double)near[3 * j + 1];

        near[3 * j + 2] = (float)(0.1 * x * x + 0.05 * x * y - 0.08 * y * y);
    }
    vor_crease_fit(&crease, near, K, upright, 1);
    ck_assert_double_le(crease.smooth2, 1e-9);
    ck_assert_double_ge(crease.crease2, 1e-4);
}
END_TEST

START_TEST(a_plane_and_a_line_have_no_kink)
{
    struct vor_crease crease;
    float near[3 * K];

    scatter(near, (uint64_t)_i);
    vor_crease_fit(&crease, near, K, upright, 1);
    ck_assert_double_le(crease.turn, 1e-6);
    for (size_t j = 0; j < K; j++)
        near[3 * j] = near[3 * j + 2] = 0;
    vor_crease_fit(&crease, near, K, upright, 1);
    ck_assert_double_le(crease.turn, 1e-6);
    ck_assert(isfinite(crease.distance) && isfinite(crease.smooth2));
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("crease");

    vt_add_loop(suite, a_folded_plane_has_its_edge_where_it_is_folded, SEEDS);
    vt_add_loop(suite, an_edge_askew_to_the_axis_is_found_askew, SEEDS);
    vt_add_loop(suite, lengths_are_in_spacings, SEEDS);
    vt_add_loop(suite, a_curved_surface_is_no_crease, SEEDS);
    vt_add_loop(suite, a_plane_and_a_line_have_no_kink, SEEDS);
    return vt_run(suite);
}
