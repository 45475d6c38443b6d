/* Where the cloud ends: a lattice, one apart, whose right half (x > 0) is missing, and one with a
 * hole. The points nearest to a place come in the order the engine would find them. */
#include "core/base/linalg.h"
#include "core/geom/boundary.h"
#include "tests/support/vt.h"

#include <stdlib.h>
#include <string.h>

enum { K = 20, SIDE = 25 };

struct place {
    float near[3 * K];
    struct vor_surface surface;
    struct vor_border border;
};

static double origin_x, origin_y; /* what by_distance sorts around */

static int by_distance(const void *a, const void *b)
{
    const float *p = a, *q = b;
    double x = hypot((double)p[0] - origin_x, (double)p[1] - origin_y);
    double y = hypot((double)q[0] - origin_x, (double)q[1] - origin_y);

    return (x > y) - (x < y);
}

/* The K lattice points nearest to (x, y): those with x <= 0, or those outside a hole around 0. */
static void gather(struct place *place, double x, double y, double hole)
{
    static float all[SIDE * SIDE][3];
    size_t n = 0;

    for (int i = 0; i < SIDE; i++)
        for (int j = 0; j < SIDE; j++) {
            float u = (float)(i - SIDE / 2), v = (float)(j - SIDE / 2);

            if (hole > 0 ? hypotf(u, v) < (float)hole : u > 0)
                continue;
            all[n][0] = u;
            all[n][1] = v;
            all[n++][2] = 0;
        }
    origin_x = x;
    origin_y = y;
    qsort(all, n, sizeof all[0], by_distance);
    memcpy(place->near, all, sizeof place->near);
    vor_surface_fit(&place->surface, place->near, K);
    ck_assert_int_ne(place->surface.kind, VOR_SURFACE_NONE);
    place->border = (struct vor_border){&place->surface, place->near, K, 1};
}

static int outside(double x, double y, double hole, double spacings)
{
    struct place place;

    gather(&place, x, y, hole);
    return vor_boundary_outside(&place.border, spacings, (double[3]){x, y, 0});
}

START_TEST(a_neighbour_is_within_a_distance_or_none_is)
{
    struct place place;

    gather(&place, -0.3, 0.2, 0);
    ck_assert_double_eq_tol(place.surface.spacing, 1, 0.1);
    ck_assert(vor_boundary_within(place.near, K, (double[3]){-1.4, 0.5, 0}, 1));
    ck_assert(vor_boundary_within(place.near, K, (double[3]){0.85, 0, 0}, 1));
    ck_assert(!vor_boundary_within(place.near, K, (double[3]){1.15, 0, 0}, 1));
    ck_assert(!vor_boundary_within(place.near, K, (double[3]){-1, 0, 1.15}, 1));
}
END_TEST

/* With all neighbours to one side, 0.6 of the spacings asked for are allowed. */
START_TEST(beyond_the_edge_of_a_half_plane_places_are_outside)
{
    for (double y = -0.5; y <= 0.5; y += 0.25)
        for (double spacings = 1; spacings <= 4; spacings += 0.5) {
            double edge = 0.6 * spacings, along = fabs(y - rint(y));
            double x = sqrt(edge * edge - along * along);

            ck_assert(!outside(x - 0.01, y, 0, spacings));
            ck_assert(outside(x + 0.01, y, 0, spacings));
        }
}
END_TEST

START_TEST(no_place_between_the_points_of_a_half_plane_is_outside)
{
    for (double x = -4; x <= 0; x += 0.125)
        for (double y = -0.5; y <= 0.5; y += 0.125)
            ck_assert(!outside(x, y, 0, VOR_OUTSIDE_IN_RESULT));
}
END_TEST

/* In the middle of a hole the neighbours are all around: the whole of the spacings is allowed. */
START_TEST(the_middle_of_a_hole_is_outside_only_beyond_all_the_spacings)
{
    /* the nearest points of the holes are 2, 3 and 4 away */
    for (double hole = 2; hole <= 4; hole++) {
        ck_assert(!outside(0, 0, hole, hole + 0.01));
        ck_assert(outside(0, 0, hole, hole - 0.01));
    }
}
END_TEST

static int leaves(double x0, double y0, double x1, double y1, double spacings)
{
    struct place place;

    gather(&place, x0, y0, 0);
    return vor_boundary_leaves(&place.border, spacings, (double[3]){x0, y0, 0},
                               (double[3]){x1, y1, 0});
}

/* With all neighbours to one side the edge is at 0.6 of the spacings asked for. */
START_TEST(a_point_leaves_where_it_ends_outside_and_farther_than_it_began)
{
    ck_assert(leaves(-0.2, 0, 1.21, 0, 2));
    ck_assert(leaves(1.19, 0, 1.21, 0, 2));
    ck_assert(leaves(1.5, 0, 1.51, 0, 2)); /* from outside, still farther */
    ck_assert(!leaves(-0.2, 0, 1.19, 0, 2));
    ck_assert(!leaves(-3, 0.5, -2, 0, 2));
    ck_assert(!leaves(1.51, 0, 1.5, 0, 2)); /* outside, and on its way back */
    ck_assert(!leaves(1.5, 0, 1.5, 0, 2));
    ck_assert(!leaves(1.5, 0.25, 1.5, -0.25, 2)); /* along the edge */
    ck_assert(leaves(1.5, 0.25, 1.5, 0.5, 2));    /* along it, away from a point */
    ck_assert(leaves(-0.2, 0, 0.7, 0, 1) && !leaves(-0.2, 0, 0.7, 0, 2));
}
END_TEST

START_TEST(a_point_held_back_stops_at_the_distance_allowed)
{
    for (double x = 0.1; x < 9; x += 0.3)
        for (double z = -1; z <= 1; z++) {
            struct place place;
            double from[3] = {x, 0.125, z}, to[3], d[3], e[3], gap;
            double length = sqrt((x * x) + 0.125 * 0.125 + z * z);
            int held;

            gather(&place, x, 0.125, 0);
            memcpy(to, from, sizeof to);
            held = vor_boundary_restrict(&place.border, 2, to);
            ck_assert_int_eq(held, length > 1.2);
            if (!held) {
                ck_assert(memcmp(to, from, sizeof to) == 0);
                continue;
            }
            for (int c = 0; c < 3; c++) { /* straight towards the nearest point, the origin */
                d[c] = to[c];
                e[c] = from[c];
            }
            gap = sqrt(vor_dot(d, d));
            ck_assert_double_eq_tol(gap, 1.2, 1e-12);
            ck_assert_double_eq_tol(vor_dot(d, e), gap * length, 1e-12 * length);
        }
}
END_TEST

static double room_at(double x, double y, double side[2], struct place *place)
{
    double world[3] = {x, y, 0}, local[3];

    gather(place, x, y, 0);
    vor_surface_to_local(&place->surface, world, local);
    return vor_boundary_room(&place->surface, place->near, K, local, 1.5, side);
}

START_TEST(a_cell_at_the_border_ends_half_a_spacing_beyond_the_last_point)
{
    struct place place;
    double side[2];

    for (double x = -0.2; x <= 0.41; x += 0.1) {
        double room = room_at(x, 0, side, &place), world[2];

        world[0] = side[0] * place.surface.axis[0][0] + side[1] * place.surface.axis[1][0];
        world[1] = side[0] * place.surface.axis[0][1] + side[1] * place.surface.axis[1][1];
        ck_assert_double_gt(world[0], 0.95);
        ck_assert_double_le(fabs(hypot(world[0], world[1]) - 1), 1e-12);
        ck_assert_double_eq_tol(room, fmax(-x, 0) + 0.4, 0.2);
    }
}
END_TEST

/* A lattice of 5 x 5 with spacing 0.25, and the place of its point (column, row), a little moved.
 */
static double lattice_spacing(float near[75], double column, double row)
{
    for (unsigned i = 0; i < 25; i++) {
        near[3 * i] = 0.25F * (float)(i % 5);
        near[3 * i + 1] = 0.25F * (float)(i / 5);
        near[3 * i + 2] = 0;
    }
    return vor_boundary_spacing(near, 25, (double[3]){0.25 * column + 0.03, 0.25 * row, 0.1});
}

START_TEST(the_spacing_is_that_around_the_nearest_point)
{
    float near[75];
    double foot[3], out[3];

    ck_assert_double_eq_tol(lattice_spacing(near, 2, 2), 0.25, 1e-7);
    ck_assert_double_eq_tol(lattice_spacing(near, 2, 0), 0.25, 1e-7);
    ck_assert_double_eq_tol(lattice_spacing(near, 0, 0), 0.25 * sqrt(2), 1e-7);
    /* Far out, or in the middle of a hole, it is still that of the rim. */
    ck_assert_double_eq_tol(lattice_spacing(near, 2, -9), 0.25, 1e-7);
    ck_assert_double_eq_tol(vor_boundary_foot(near, 25, (double[3]){0.53, 0.5, -0.04}, foot, out),
                            0.05, 1e-7);
    ck_assert_double_eq_tol(out[0], 0.6, 1e-12);
    ck_assert_double_eq_tol(out[1], 0, 1e-12);
    ck_assert_double_eq_tol(out[2], -0.8, 1e-12);
    ck_assert(vor_boundary_foot(near, 25, (double[3]){0.5, 0.5, 0}, foot, out) == 0);
    ck_assert(out[0] == 0 && out[1] == 0 && out[2] == 0);
    ck_assert_int_eq(vor_boundary_within(near, 25, (double[3]){0.5, 0.5, 0.2}, 0.2001), 1);
    ck_assert_int_eq(vor_boundary_within(near, 25, (double[3]){0.5, 0.5, 0.2}, 0.1999), 0);
}
END_TEST

/* The lattice points nearest to (x, y), and how far they go on from there towards (u, v). */
static double ahead(double x, double y, double hole, double u, double v, double width,
                    double within)
{
    struct place place;
    double length = hypot(u - x, v - y), way[3] = {(u - x) / length, (v - y) / length, 0};

    gather(&place, x, y, hole);
    return vor_boundary_ahead(place.near, K, (double[3]){x, y, 0}, way, width, within);
}

START_TEST(the_input_goes_on_ahead_as_far_as_its_last_point)
{
    const double narrow = VOR_AHEAD_NARROW, all = VOR_AHEAD_ALL, any = INFINITY;

    /* the half plane ends at x = 0 */
    ck_assert_double_eq(ahead(-2, 0, 0, -1.6, 0, narrow, any), 2);
    ck_assert_double_eq(ahead(-2, 0, 0, -1.6, 0, narrow, 1), 1);
    ck_assert_double_eq(ahead(-1, 0, 0, -0.6, 0, narrow, 0.99), 0);
    ck_assert_double_eq(ahead(0, 0, 0, 0.4, 0, narrow, any), 0);
    ck_assert_double_ge(ahead(0, 0, 0, 0, 0.4, narrow, any), 2);
    /* seen from beyond the last points they are behind, which a narrow look does not see */
    ck_assert_double_eq_tol(ahead(0.4, 0, 0, 0.6, 0, all, any), -0.4, 1e-12);
    ck_assert_double_eq(ahead(0.4, 0, 0, 0.6, 0, narrow, any), -INFINITY);
    /* a hole, from its rim: the other side is at 4 and not among the neighbours, but the rim is */
    ck_assert_double_eq(ahead(-2, 0, 2, -1.5, 0, narrow, any), 0);
    ck_assert_double_ge(ahead(-2, 0, 2, -1.5, 0, all, any), 1);
    ck_assert_double_ge(ahead(-2, 0, 2, -2.5, 0, narrow, any), 2);
}
END_TEST

static int goes_on(double x, double y, double u, double v)
{
    struct place place;

    gather(&place, x, y, 0);
    return vor_boundary_goes_on(place.near, K, (double[3]){x, y, 0}, (double[3]){u, v, 0},
                                INFINITY);
}

START_TEST(the_input_goes_on_from_a_foot_or_it_does_not)
{
    ck_assert(goes_on(-2, 0, 1, 0));
    ck_assert(!goes_on(0, 0, 1, 0));
    /* a point at 45 degrees is not ahead, one at 27 is */
    ck_assert(!goes_on(0, 0, sqrt(0.5), sqrt(0.5)));
    ck_assert(goes_on(0, 0, sqrt(0.2), 2 * sqrt(0.2)));
}
END_TEST

START_TEST(a_foot_is_the_nearest_neighbour_and_the_reach_the_farthest)
{
    struct place place;
    double foot[3], way[3], x[3] = {-1.3, 0.4, 0.5};

    gather(&place, -1.3, 0.4, 0);
    ck_assert_double_eq_tol(vor_boundary_foot(place.near, K, x, foot, way),
                            sqrt(0.09 + 0.16 + 0.25), 1e-12);
    ck_assert(foot[0] == -1 && foot[1] == 0 && foot[2] == 0);
    ck_assert_double_eq_tol(vor_dot(way, way), 1, 1e-12);
    ck_assert_double_eq_tol(way[0] * 0.4, way[1] * -0.3, 1e-12);
    x[2] = 0;
    ck_assert_double_eq_tol(
        vor_boundary_reach(place.near, K, x),
        hypot((double)place.near[3 * K - 3] - x[0], (double)place.near[3 * K - 2] - x[1]), 1e-12);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("boundary");

    vt_add(suite, a_neighbour_is_within_a_distance_or_none_is);
    vt_add(suite, beyond_the_edge_of_a_half_plane_places_are_outside);
    vt_add(suite, no_place_between_the_points_of_a_half_plane_is_outside);
    vt_add(suite, the_middle_of_a_hole_is_outside_only_beyond_all_the_spacings);
    vt_add(suite, a_point_leaves_where_it_ends_outside_and_farther_than_it_began);
    vt_add(suite, a_point_held_back_stops_at_the_distance_allowed);
    vt_add(suite, a_cell_at_the_border_ends_half_a_spacing_beyond_the_last_point);
    vt_add(suite, the_spacing_is_that_around_the_nearest_point);
    vt_add(suite, the_input_goes_on_ahead_as_far_as_its_last_point);
    vt_add(suite, the_input_goes_on_from_a_foot_or_it_does_not);
    vt_add(suite, a_foot_is_the_nearest_neighbour_and_the_reach_the_farthest);
    return vt_run(suite);
}
