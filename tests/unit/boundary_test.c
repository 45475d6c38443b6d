/* Where the cloud ends: a lattice, one apart, whose right half (x > 0) is missing, and one with a
 * hole. The points nearest to a place come in the order the engine would find them. */
#include "core/geom/boundary.h"
#include "tests/support/vt.h"

#include <stdlib.h>
#include <string.h>

enum { K = 20, MANY = 150, SIDE = 25 };

struct place {
    float near[3 * MANY];
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

/* The k lattice points nearest to (x, y): those with x <= 0, or those outside a hole around 0. */
static void gather(struct place *place, unsigned k, double x, double y, double hole)
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
    memcpy(place->near, all, k * sizeof *all);
    vor_surface_fit(&place->surface, place->near, k);
    ck_assert_int_ne(place->surface.kind, VOR_SURFACE_NONE);
    place->border = (struct vor_border){&place->surface, place->near, k, 1};
}

static int outside(double x, double y, double hole, double spacings)
{
    struct place place;

    gather(&place, K, x, y, hole);
    return vor_boundary_outside(&place.border, spacings, (double[3]){x, y, 0});
}

VT_TEST(a_neighbour_is_within_a_distance_or_none_is)
{
    struct place place;

    gather(&place, K, -0.3, 0.2, 0);
    ck_assert_double_eq_tol(place.surface.spacing, 1, 0.1);
    ck_assert(vor_boundary_within(place.near, K, (double[3]){-1.4, 0.5, 0}, 1));
    ck_assert(vor_boundary_within(place.near, K, (double[3]){0.85, 0, 0}, 1));
    ck_assert(!vor_boundary_within(place.near, K, (double[3]){1.15, 0, 0}, 1));
    ck_assert(!vor_boundary_within(place.near, K, (double[3]){-1, 0, 1.15}, 1));
}

VT_TEST(the_free_side_is_that_where_neighbours_are_missing)
{
    static const double half[][2] = {{1, 0}, {0, 1}, {-1, 0}};
    double six[6][2], side[2];

    ck_assert(vor_boundary_free_side(half, 3, -0.5, side));
    ck_assert_double_eq_tol(side[0], 0, 1e-12);
    ck_assert_double_eq_tol(side[1], -1, 1e-12);
    for (int k = 0; k < 6; k++) {
        six[k][0] = cos(k * M_PI / 3);
        six[k][1] = sin(k * M_PI / 3);
    }
    ck_assert(!vor_boundary_free_side((const double(*)[2])six, 6, -0.5, side));
    /* Without one of them 120 degrees are free. */
    ck_assert(vor_boundary_free_side((const double(*)[2])six, 5, 0.0, side));
    ck_assert_double_eq_tol(side[0], 0.5, 1e-12);
    ck_assert_double_eq_tol(side[1], -sqrt(3) / 2, 1e-12);
}

/* With all neighbours to one side, 0.6 of the spacings asked for are allowed. */
VT_TEST(beyond_the_edge_of_a_half_plane_places_are_outside)
{
    for (double y = -0.5; y <= 0.5; y += 0.25)
        for (double spacings = 1; spacings <= 4; spacings += 0.5) {
            double edge = 0.6 * spacings, along = fabs(y - rint(y));
            double x = sqrt(edge * edge - along * along);

            ck_assert(!outside(x - 0.01, y, 0, spacings));
            ck_assert(outside(x + 0.01, y, 0, spacings));
        }
}

VT_TEST(the_middle_of_a_hole_is_outside_only_beyond_all_the_spacings)
{
    /* the nearest points of the holes are 2, 3 and 4 away */
    for (double hole = 2; hole <= 4; hole++) {
        ck_assert(!outside(0, 0, hole, hole + 0.01));
        ck_assert(outside(0, 0, hole, hole - 0.01));
    }
}

/* Whatever the number of neighbours that a fit takes: many reach around the hole. */
VT_TEST(a_place_in_a_wide_hole_is_beyond_the_end_of_the_input)
{
    struct place place;

    for (unsigned k = K; k <= MANY; k += (MANY - K) / 2) {
        gather(&place, k, 6, 0, 7);
        ck_assert(vor_boundary_beyond(&place.surface, place.near, k, (double[3]){6, 0, 0}));
        gather(&place, k, 8.1, 0.2, 7);
        ck_assert(!vor_boundary_beyond(&place.surface, place.near, k, (double[3]){8.1, 0.2, 0}));
    }
}

/* Beyond a border a point goes straight back to it, and does not slide along it. */
VT_TEST(a_place_beyond_is_pulled_towards_the_border)
{
    for (double y = 0; y <= 0.5; y += 0.25) {
        double x[3] = {0.6, y, 0};
        struct place place;

        gather(&place, K, 0, 0, 0);
        ck_assert(vor_boundary_pull(place.near, K, (double[3]){0, 0, 0}, 1, x));
        ck_assert_double_eq_tol(x[0], VOR_HOLE_MARGIN, 1e-12);
        ck_assert_double_eq_tol(x[1], y, 1e-12);
        x[0] -= 1e-6;
        ck_assert(!vor_boundary_pull(place.near, K, (double[3]){0, 0, 0}, 1, x));
    }
}

static double room_at(double x, double y, double side[2], struct place *place)
{
    double world[3] = {x, y, 0}, local[3];

    gather(place, K, x, y, 0);
    vor_surface_to_local(&place->surface, world, local);
    return vor_boundary_room(&place->surface, place->near, K, local, 1.5, side);
}

VT_TEST(a_cell_at_the_border_ends_half_a_spacing_beyond_the_last_point)
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

VT_TEST(the_spacing_is_that_around_the_nearest_point)
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
}

static int ascending(const void *a, const void *b)
{
    const double *x = a, *y = b;

    return (*x > *y) - (*x < *y);
}

/* The slow twin: one neighbour at a time, of each number of them. Places are on a grid, so that
 * some coincide and some are as near as others. */
VT_TEST_LOOP(neighbours_four_at_a_time_say_what_each_says, K)
{
    const unsigned k = (unsigned)_i + 1;

    for (uint64_t seed = 0; seed < 200; seed++) {
        const struct vor_surface frame = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
        double x[3], way[3] = {0.6, 0, 0.8}, foot[3], to[3], from[K] = {0}, within, far = 0,
                     last = -INFINITY;
        float near[3 * K];
        unsigned first = 0;
        int ahead = 0;

        for (unsigned c = 0; c < 3 * k; c++)
            near[c] = (float)floor(5 * vt_unit(seed, c)) / 4;
        for (unsigned c = 0; c < 3; c++)
            x[c] = floor(5 * vt_unit(seed, 900 + c)) / 4;
        within = vt_unit(seed, 910);
        for (unsigned i = 0; i < k; i++) {
            double d[3] = {(double)near[3 * i] - x[0], (double)near[3 * i + 1] - x[1],
                           (double)near[3 * i + 2] - x[2]};
            double on = way[0] * d[0] + way[1] * d[1] + way[2] * d[2];

            from[i] = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            first = from[i] < from[first] ? i : first;
            far = fmax(far, from[i]);
            last = fmax(last, (double)near[3 * i]);
            ahead |= on > 0 && from[i] <= within && on >= VOR_AHEAD_NARROW * from[i];
        }
        ck_assert(vor_boundary_reach(near, k, x) == far);
        ck_assert_int_eq(vor_boundary_goes_on(near, k, x, way, within), ahead);
        ck_assert(vor_boundary_end(&frame, x, (double[2]){1, 0}, near, k) == last - x[0]);
        ck_assert(vor_boundary_foot(near, k, x, foot, to) == from[first]);
        for (unsigned c = 0; c < 3; c++)
            ck_assert(foot[c] == (double)near[3 * first + c]);
        for (unsigned i = 0; i < k; i++)
            from[i] = i == first ? INFINITY
                                 : sqrt(pow((double)near[3 * i] - foot[0], 2) +
                                        pow((double)near[3 * i + 1] - foot[1], 2) +
                                        pow((double)near[3 * i + 2] - foot[2], 2));
        qsort(from, k, sizeof *from, ascending);
        if (k > 3)
            ck_assert(vor_boundary_spacing(near, k, x) == from[2]);
    }
}
