/* Triangles that would make a surface of one side are told from others. */
#include "core/mesh/twosided.h"
#include "tests/support/vt.h"

#include <string.h>

enum { WIDE = 2, LONG = 8, N = WIDE * LONG };

/* A strip of squares between two rows of points, without its last triangle, which joins the last
 * column to the first: turned over, or not. */
static void strip(struct vor_complex *complex, int turned, uint32_t last[3])
{
    vt_assert_ok(vor_complex_init(complex, N, &vt_memory, &vt_err));
    for (uint32_t i = 0; i < LONG; i++) {
        uint32_t a = 2 * i, b = a + 1, c = (a + 2) % N, d = (a + 3) % N;
        uint32_t one[3] = {a, b, c}, two[3] = {b, d, c};

        if (i == LONG - 1 && turned) {
            one[2] = two[2] = d;
            two[1] = c;
        }
        vt_assert_ok(vor_complex_add(complex, one, &vt_err));
        if (i < LONG - 1)
            vt_assert_ok(vor_complex_add(complex, two, &vt_err));
        else
            memcpy(last, two, sizeof two);
    }
}

START_TEST(only_a_triangle_that_turns_a_band_over_is_refused)
{
    struct vor_complex complex = {.n = 0};
    struct vor_twosided sides = {.memory = NULL};
    uint32_t last[3];

    strip(&complex, _i, last);
    vt_assert_ok(vor_twosided_make(&sides, &complex, 1, &vt_err));
    ck_assert_int_eq(vor_twosided_takes(&sides, &complex, last), !_i);
    vor_twosided_free(&sides);
    vor_complex_free(&complex);
    vt_assert_no_leak();
}
END_TEST

static vor_status try_sides(void *ctx)
{
    struct vor_twosided sides = {.memory = NULL};
    vor_status status = vor_twosided_make(&sides, ctx, 1, &vt_err);

    if (status == VOR_OK)
        vor_twosided_free(&sides);
    return status;
}

START_TEST(memory_that_ends_is_an_error_and_leaks_nothing)
{
    struct vor_complex complex = {.n = 0};
    uint32_t last[3];

    strip(&complex, 0, last);
    vt_fail_each(try_sides, &complex);
    vor_complex_free(&complex);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("twosided");

    vt_add_loop(suite, only_a_triangle_that_turns_a_band_over_is_refused, 2);
    vt_add(suite, memory_that_ends_is_an_error_and_leaks_nothing);
    return vt_run(suite);
}
