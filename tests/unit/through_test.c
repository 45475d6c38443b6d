/* The height through a few points: it goes through them, and is a plane through points of one. */
#include "core/geom/through.h"

#include "core/base/rng.h"
#include "tests/support/vt.h"

#include <math.h>

/* Random places in a square of side 2 `size`, with the height of a plane, or of a sphere of radius
 * 2 `size`. */
static void scatter(double local[VOR_THROUGH_MOST][3], uint64_t seed, double size, int sphere)
{
    for (uint64_t i = 0; i < VOR_THROUGH_MOST; i++) {
        double u = 2 * vor_rng_unit(seed, 1, 2 * i) - 1;
        double v = 2 * vor_rng_unit(seed, 1, 2 * i + 1) - 1;

        local[i][0] = size * u;
        local[i][1] = size * v;
        local[i][2] = size * (sphere ? sqrt(4 - u * u - v * v) : 3 - 0.5 * u + 0.25 * v);
    }
}

START_TEST(a_height_goes_through_its_points_at_any_scale)
{
    static const double sizes[] = {1e-6, 1, 1e6};

    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        double local[VOR_THROUGH_MOST][3], here;
        struct vor_through through;

        scatter(local, (uint64_t)_i, sizes[s], 1);
        ck_assert(vor_through_fit(&through, (const double(*)[3])local, VOR_THROUGH_MOST));
        for (int k = 0; k < VOR_THROUGH_MOST; k++) {
            here = vor_through_height(&through, local[k][0], local[k][1]);
            ck_assert_double_eq_tol(here / sizes[s], local[k][2] / sizes[s], 1e-9);
        }
    }
}
END_TEST

START_TEST(between_points_of_a_plane_the_height_is_that_of_the_plane)
{
    double local[VOR_THROUGH_MOST][3];
    struct vor_through through;

    scatter(local, (uint64_t)_i, 1, 0);
    ck_assert(vor_through_fit(&through, (const double(*)[3])local, VOR_THROUGH_MOST));
    ck_assert_double_eq_tol(vor_through_height(&through, 0.3, -0.2), 3 - 0.15 - 0.05, 1e-9);
}
END_TEST

START_TEST(points_on_a_line_at_one_place_or_too_few_determine_no_height)
{
    double line[5][3], twice[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}, {1, 1, 2}};
    struct vor_through through = {.n = 77};

    for (int k = 0; k < 5; k++) {
        line[k][0] = k;
        line[k][1] = 2 * k;
        line[k][2] = k * k;
    }
    ck_assert(!vor_through_fit(&through, (const double(*)[3])line, 5));
    ck_assert(!vor_through_fit(&through, (const double(*)[3])twice, 5));
    ck_assert(!vor_through_fit(&through, (const double(*)[3])twice, 3));
    ck_assert_uint_eq(through.n, 77);
    ck_assert(vor_through_fit(&through, (const double(*)[3])twice, 4));
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("through");

    vt_add_loop(suite, a_height_goes_through_its_points_at_any_scale, 20);
    vt_add_loop(suite, between_points_of_a_plane_the_height_is_that_of_the_plane, 20);
    vt_add(suite, points_on_a_line_at_one_place_or_too_few_determine_no_height);
    return vt_run(suite);
}
