/* The parameter origin: which frame a request and an input come to, and which are refused. */
#include "proto/codec.h"
#include "proto/origin.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SEEDS = 200 };

static struct vor_spec asked(const char *origin, const char *points)
{
    struct vor_spec spec;

    vor_spec_init(&spec);
    vt_assert_ok(vor_spec_set(&spec, "origin", origin, &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "points", points, &vt_err));
    return spec;
}

/* 10,000 points of a square of 100 x 100, so about 1.07 apart, with its corner at x, 0, 0. */
static struct vor_extent square_at(double x)
{
    return (struct vor_extent){
        .n = 10000, .low = {x, 0, 0}, .high = {x + 100, 100, 0}, .area = 10000};
}

/* 1.0746 / 200 is 0.00537: float32 has steps of 2^-8 from 2^15 on, of 2^-7 from 2^16 on. */
VT_TEST(auto_is_absolute_as_long_as_float32_is_fine_enough)
{
    static const struct {
        double x, origin;
    } cases[] = {{0, 0},         {65536 - 101, 0},   {65536 - 100, 65486},
                 {65536, 65586}, {637000.4, 637050}, {-637000.4, -636950}};
    struct vor_spec spec = asked("auto", "5000");

    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct vor_extent input = square_at(cases[i].x);
        double origin[3];

        vt_assert_ok(vor_origin_resolve(origin, &spec, &input, 1.5, &vt_err));
        ck_assert_msg(origin[0] == cases[i].origin, "at %g: %g", cases[i].x, origin[0]);
        ck_assert(origin[1] == (cases[i].origin != 0 ? 50 : 0) && origin[2] == 0);
    }
}

VT_TEST_LOOP(the_frame_does_not_depend_on_the_number_of_points, 60)
{
    static const char *const words[] = {"auto", "relative"};
    static const char *const points[] = {"1", "100", "160000"};
    static const double spacing[] = {100, 10, 0.27};
    struct vor_extent input = square_at(300 * (double)_i * _i);
    double first[3], origin[3];

    for (int w = 0; w < 2; w++) {
        struct vor_spec spec = asked(words[w], points[0]);

        vt_assert_ok(vor_origin_resolve(first, &spec, &input, spacing[0], &vt_err));
        for (int k = 1; k < 3; k++) {
            spec = asked(words[w], points[k]);
            vt_assert_ok(vor_origin_resolve(origin, &spec, &input, spacing[k], &vt_err));
            ck_assert_mem_eq(origin, first, sizeof origin);
            vt_assert_ok(vor_origin_check(&spec, &input, &vt_err));
        }
        for (int c = 0; c < 3; c++)
            ck_assert(origin[c] == rint(origin[c]));
    }
}

VT_TEST(numbers_are_taken_as_they_are)
{
    struct vor_spec spec = asked("637000.25,-1e2,+3", "100");
    struct vor_extent input = square_at(637000);
    double origin[3];

    vt_assert_ok(vor_origin_resolve(origin, &spec, &input, 10, &vt_err));
    ck_assert(origin[0] == 637000.25 && origin[1] == -100 && origin[2] == 3);
}

/* Vector: at 849254 the step is 0.0625, a 20th of 1.25. */
VT_TEST(an_origin_that_leaves_float32_too_coarse_is_refused_with_its_step)
{
    static const char *const words[] = {"absolute", "-200000,0,0"};
    struct vor_extent input = square_at(849154);
    double origin[3] = {7, 7, 7};

    for (int w = 0; w < 2; w++) {
        struct vor_spec spec = asked(words[w], "10000");

        vt_assert_ok(vor_origin_resolve(origin, &spec, &input, w == 0 ? 1.25 : 2.5, &vt_err));
        origin[0] = 7;
        vt_assert_fails(VOR_E_ORIGIN, vor_origin_resolve(origin, &spec, &input, 1.2499, &vt_err));
        ck_assert(origin[0] == 7);
        ck_assert_str_eq(vt_err.parameter, "origin");
        ck_assert_ptr_nonnull(strstr(vt_err.message, w == 0 ? " 0.0625 " : " 0.125 "));
        ck_assert_ptr_nonnull(strstr(vt_err.message, "at most 0.0625 (1/20 of the spacing"));
        ck_assert_ptr_nonnull(strstr(vt_err.message, words[w]));
    }
    ck_assert_int_eq(vor_status_http(VOR_E_ORIGIN), 422);
}

/* Property: what is refused before the work would be refused after it, at any spacing that the
 * estimate is not wrong about by more than the margin. */
VT_TEST_LOOP(an_early_refusal_is_never_wrong, SEEDS)
{
    char points[16];
    struct vor_extent input = square_at(pow(10, 3 + 5 * vt_unit((uint64_t)_i, 0)));
    double n = floor(100 * pow(10, 3 * vt_unit((uint64_t)_i, 1))), origin[3];
    double most = VOR_ORIGIN_MARGIN * vor_extent_spacing(&input, n);
    struct vor_spec spec;

    (void)snprintf(points, sizeof points, "%.0f", n);
    spec = asked("absolute", points);
    ck_assert_int_eq(vor_origin_check(&spec, &input, NULL),
                     vor_origin_resolve(origin, &spec, &input, most, NULL));
}

VT_TEST(a_spacing_that_is_asked_for_decides_early)
{
    struct vor_extent input = square_at(849154);
    struct vor_spec spec;

    vor_spec_init(&spec);
    vt_assert_ok(vor_spec_set(&spec, "origin", "absolute", &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "spacing", "1.25", &vt_err));
    vt_assert_ok(vor_origin_check(&spec, &input, &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "spacing", "1.2", &vt_err));
    vt_assert_fails(VOR_E_ORIGIN, vor_origin_check(&spec, &input, &vt_err));
}

VT_TEST(an_origin_beyond_float32_is_refused_whatever_the_spacing)
{
    struct vor_extent input = square_at(0);
    struct vor_spec spec = asked("1e30,0,0", "100");
    double origin[3];

    vt_assert_fails(VOR_E_ORIGIN, vor_origin_resolve(origin, &spec, &input, 10, &vt_err));
    input.high[0] = 1e39;
    spec = asked("absolute", "100");
    vt_assert_fails(VOR_E_ORIGIN, vor_origin_resolve(origin, &spec, &input, 0, &vt_err));
}

VT_TEST(an_origin_is_written_as_it_is_read)
{
    static const double origins[][3] = {{0, 0, 0},
                                        {637000, -849000, 12},
                                        {0.1, 1.0 / 3, -1e-300},
                                        {1e300, -1.7976931348623157e308, 5e-324}};
    char text[VOR_ORIGIN_TEXT_SIZE];

    ck_assert_str_eq(vor_origin_text(origins[0], text), "0,0,0");
    ck_assert_str_eq(vor_origin_text(origins[1], text), "637000,-849000,12");
    for (size_t i = 0; i < sizeof origins / sizeof *origins; i++) {
        double back[3];

        ck_assert_int_eq(
            sscanf(vor_origin_text(origins[i], text), "%lf,%lf,%lf", &back[0], &back[1], &back[2]),
            3);
        ck_assert_mem_eq(back, origins[i], sizeof back);
    }
}

VT_TEST(only_draco_takes_an_origin)
{
    struct vor_result_facts facts = {square_at(849154), 0.5};
    struct vor_spec spec = asked("absolute", "100000");
    struct vor_write_options options = {.has_origin = 9};

    vt_assert_fails(VOR_E_ORIGIN, vor_write_options_from(&options, vor_format(VOR_FORMAT_DRC),
                                                         &spec, &facts, &vt_err));
    ck_assert_int_eq(options.has_origin, 9);
    vt_assert_fails(VOR_E_ORIGIN, vor_write_check(vor_format(VOR_FORMAT_DRC),
                                                  (spec = asked("absolute", "1000000"), &spec),
                                                  &facts.input, &vt_err));
    vt_assert_ok(vor_write_check(vor_format(VOR_FORMAT_PLY), &spec, &facts.input, &vt_err));
    vt_assert_ok(
        vor_write_options_from(&options, vor_format(VOR_FORMAT_PLY), &spec, &facts, &vt_err));
    ck_assert_int_eq(options.has_origin, 0);
    spec = asked("auto", "100000");
    vt_assert_ok(
        vor_write_options_from(&options, vor_format(VOR_FORMAT_DRC), &spec, &facts, &vt_err));
    ck_assert_int_eq(options.has_origin, 1);
    ck_assert(options.origin[0] == 849204 && options.origin[1] == 50 && options.origin[2] == 0);
}
