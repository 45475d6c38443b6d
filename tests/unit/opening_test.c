/* Empty discs beside a point: known answers, and what is true of every disc that was found. */
#include "core/geom/opening.h"

#include "tests/support/vt.h"

#include <math.h>

static const double centre[3] = {0, 0, 0}, up[3] = {0, 0, 1};

/* Distance from the point to the disc's middle, in the plane whose normal is given. */
static double in_plane(const float *p, const double middle[3], const double normal[3])
{
    double d[3], height = 0, sum = 0;

    for (int c = 0; c < 3; c++) {
        d[c] = (double)p[c] - middle[c];
        height += d[c] * normal[c];
    }
    for (int c = 0; c < 3; c++)
        sum += d[c] * d[c];
    return sqrt(fmax(0, sum - height * height));
}

START_TEST(a_straight_border_has_one_opening_that_ends_at_the_next_points_of_it)
{
    float near[3 * 14];
    struct vor_opening out[VOR_OPENINGS];
    unsigned k = 0;

    for (int x = -2; x <= 2; x++)
        for (int y = -2; y <= 0; y++)
            if ((x != 0 || y != 0) && k < 14) {
                near[3 * k] = (float)x;
                near[3 * k + 1] = (float)y;
                near[3 * k++ + 2] = 0;
            }
    ck_assert_uint_eq(k, 14);
    ck_assert_uint_eq(vor_openings_find(out, near, k, centre, up, 2), 1);
    for (int e = 0; e < 2; e++) {
        ck_assert_double_eq(fabs((double)near[3 * out[0].end[e]]), 1);
        ck_assert(near[3 * out[0].end[e] + 1] == 0);
        ck_assert_double_eq_tol(out[0].middle[e][1], sqrt(3.75), 1e-12);
    }
    ck_assert_uint_ne(out[0].end[0], out[0].end[1]);
    ck_assert_double_eq_tol(out[0].outward[1], 1, 1e-12);
}
END_TEST

START_TEST(a_hexagon_is_open_only_to_discs_that_fit_between_its_points)
{
    float near[18];
    struct vor_opening out[VOR_OPENINGS];

    for (int i = 0; i < 6; i++) {
        near[3 * i] = (float)cos(i * M_PI / 3);
        near[3 * i + 1] = (float)sin(i * M_PI / 3);
        near[3 * i + 2] = 0;
    }
    /* The disc through three corners of a triangle of side 1. */
    ck_assert_uint_eq(vor_openings_find(out, near, 6, centre, up, 1 / sqrt(3) + 1e-3), 0);
    ck_assert_uint_eq(vor_openings_find(out, near, 6, centre, up, 1 / sqrt(3) - 1e-3),
                      VOR_OPENINGS);
}
END_TEST

START_TEST(one_neighbour_ends_the_opening_on_both_sides_and_none_leaves_none)
{
    static const float near[] = {1, 0, 0, 0, 0, 0};
    struct vor_opening out[VOR_OPENINGS];

    ck_assert_uint_eq(vor_openings_find(out, near, 2, centre, up, 1), 1);
    ck_assert_uint_eq(out[0].end[0], 0);
    ck_assert_uint_eq(out[0].end[1], 0);
    ck_assert_double_eq_tol(out[0].outward[0], -1, 1e-12);
    ck_assert_uint_eq(vor_openings_find(out, near, 2, centre, up, 0.5), 0);
    ck_assert_uint_eq(vor_openings_find(out, &near[3], 1, centre, up, 1), 0);
}
END_TEST

static int is_empty(const double middle[3], const float *near, unsigned k, const double normal[3],
                    double radius)
{
    for (unsigned j = 0; j < k; j++)
        if (in_plane(&near[3 * j], middle, normal) < radius * (1 - 1e-6))
            return 0;
    return 1;
}

/* Whether one of 720 discs around the origin is empty. */
static int some_disc_is_empty(const float *near, unsigned k, const double normal[3], double radius)
{
    double u[3] = {normal[1], -normal[0], 0}, v[3], length = hypot(u[0], u[1]);

    for (int c = 0; c < 3; c++)
        u[c] /= length;
    for (int c = 0; c < 3; c++)
        v[c] = normal[(c + 1) % 3] * u[(c + 2) % 3] - normal[(c + 2) % 3] * u[(c + 1) % 3];
    for (int i = 0; i < 720; i++) {
        double angle = i * M_PI / 360, middle[3];

        for (int c = 0; c < 3; c++)
            middle[c] = radius * (cos(angle) * u[c] + sin(angle) * v[c]);
        if (is_empty(middle, near, k, normal, radius))
            return 1;
    }
    return 0;
}

/* Property: a disc that was found touches its end and holds no point; and where discs are empty,
 * some are found. */
START_TEST(discs_are_empty_and_touch_their_ends)
{
    uint64_t seed = (uint64_t)_i;
    unsigned k = 3 + (unsigned)_i % 40, found;
    double normal[3] = {0.48, 0.6, 0.64}, radius = 0.3 + vt_unit(seed, 1000);
    float near[3 * VOR_OPENING_NEAR];
    struct vor_opening out[VOR_OPENINGS];

    for (unsigned j = 0; j < 3 * k; j++)
        near[j] = (float)(3 * vt_unit(seed, j) - 1.5);
    found = vor_openings_find(out, near, k, centre, normal, radius);
    for (unsigned o = 0; o < found; o++)
        for (int e = 0; e < 2; e++) {
            ck_assert(is_empty(out[o].middle[e], near, k, normal, radius));
            ck_assert_double_eq_tol(in_plane(&near[3 * out[o].end[e]], out[o].middle[e], normal),
                                    radius, 1e-6);
            ck_assert_double_eq_tol(in_plane((float[3]){0, 0, 0}, out[o].middle[e], normal), radius,
                                    1e-9);
        }
    if (some_disc_is_empty(near, k, normal, radius * (1 + 1e-6)) && found == 0)
        for (unsigned j = 0; j < k; j++)
            ck_assert_double_ge(in_plane(&near[3 * j], centre, normal), 2 * radius);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("opening");

    vt_add(suite, a_straight_border_has_one_opening_that_ends_at_the_next_points_of_it);
    vt_add(suite, a_hexagon_is_open_only_to_discs_that_fit_between_its_points);
    vt_add(suite, one_neighbour_ends_the_opening_on_both_sides_and_none_leaves_none);
    vt_add_loop(suite, discs_are_empty_and_touch_their_ends, 200);
    return vt_run(suite);
}
