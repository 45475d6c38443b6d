/* The request: every parameter of the table at its default, at its ends and past them, as text, as
 * a number, as a word. */
#include "core/spec.h"
#include "tests/support/vt.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* _i names the parameter in the loops below. */
static const struct vor_parameter_info *info_of(int i)
{
    return vor_parameter_info((enum vor_parameter)i);
}

static double value_of(const struct vor_spec *spec, int i)
{
    return spec->value[i];
}

static int is_number(const struct vor_parameter_info *info)
{
    return info->kind != VOR_KIND_CHOICE;
}

static int is_whole(const struct vor_parameter_info *info)
{
    return info->kind == VOR_KIND_COUNT || info->kind == VOR_KIND_COUNT_OR_AUTO;
}

static const char *print(char out[64], double number)
{
    (void)snprintf(out, 64, "%.17g", number);
    return out;
}

/* Both doors refuse the number, name the parameter and its range, and change nothing. */
static void assert_out_of_range(int i, double number)
{
    const struct vor_parameter_info *info = info_of(i);
    struct vor_spec spec, before;
    char text[64];

    vor_spec_init(&spec);
    before = spec;
    for (int door = 0; door < 2; door++) {
        vor_status status = door == 0
                                ? vor_spec_set(&spec, info->name, print(text, number), &vt_err)
                                : vor_spec_set_number(&spec, info->name, number, &vt_err);

        ck_assert_msg(status == VOR_E_PARAM, "%s takes %.17g", info->name, number);
        ck_assert_str_eq(vt_err.parameter, info->name);
        (void)snprintf(text, sizeof text, "from %.16g to %.16g", info->min, info->max);
        ck_assert_msg(strstr(vt_err.message, text) != NULL, "%s", vt_err.message);
        ck_assert_mem_eq(&spec, &before, sizeof spec);
    }
}

static void assert_taken(int i, double number)
{
    const struct vor_parameter_info *info = info_of(i);
    struct vor_spec spec;
    char text[64];

    vor_spec_init(&spec);
    vt_assert_ok(vor_spec_set(&spec, info->name, print(text, number), &vt_err));
    ck_assert(value_of(&spec, i) == number);
    ck_assert(vor_spec_given(&spec, (enum vor_parameter)i));
    vor_spec_init(&spec);
    vt_assert_ok(vor_spec_set_number(&spec, info->name, number, &vt_err));
    ck_assert(value_of(&spec, i) == number);
}

START_TEST(a_parameter_has_a_name_a_sentence_and_a_default_in_its_range)
{
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;

    ck_assert_uint_gt(strlen(info->name), 2);
    for (const char *c = info->name; *c != '\0'; c++)
        ck_assert(islower((unsigned char)*c));
    ck_assert_uint_lt(strlen(info->name), sizeof vt_err.parameter);
    ck_assert_uint_gt(strlen(info->sentence), 10);
    ck_assert_int_eq(vor_parameter_find(info->name), _i);
    vor_spec_init(&spec);
    ck_assert(value_of(&spec, _i) == info->fallback);
    if (info->fallback != VOR_UNSET && is_number(info))
        ck_assert(info->fallback >= info->min && info->fallback <= info->max);
    if (is_number(info))
        ck_assert(info->min < info->max && info->min > VOR_UNSET);
    ck_assert_int_eq(is_number(info), info->choices[0] == '\0');
}
END_TEST

START_TEST(a_number_is_taken_at_its_ends_and_not_past_them)
{
    const struct vor_parameter_info *info = info_of(_i);
    double step = is_whole(info) ? 1 : 0;

    if (!is_number(info))
        return;
    assert_taken(_i, info->min);
    assert_taken(_i, info->max);
    assert_taken(_i,
                 is_whole(info) ? floor((info->min + info->max) / 2) : (info->min + info->max) / 2);
    assert_out_of_range(_i, step > 0 ? info->max + step : nextafter(info->max, INFINITY));
    assert_out_of_range(_i, step > 0 ? info->min - step : nextafter(info->min, -INFINITY));
    assert_out_of_range(_i, -1e300);
    assert_out_of_range(_i, 1e300);
}
END_TEST

START_TEST(a_whole_number_has_no_fraction)
{
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;

    if (!is_whole(info))
        return;
    assert_out_of_range(_i, info->min + 0.5);
    vor_spec_init(&spec);
    vt_assert_fails(VOR_E_PARAM, vor_spec_set_number(&spec, info->name, NAN, &vt_err));
    vt_assert_fails(VOR_E_PARAM, vor_spec_set_number(&spec, info->name, INFINITY, &vt_err));
}
END_TEST

START_TEST(junk_is_refused_and_shown)
{
    static const char *const junk[] = {
        "",        " ",
        "abc",     "1x",
        "0x10",    "1,5",
        " 7",      "7 ",
        "nan",     "inf",
        "-inf",    "1e999",
        "--1",     "1e",
        ".",       "+",
        "7\n",     "1 2",
        "1_000",   "\xc2\xb2",
        "1.2.3",   "none",
        "Auto",    "keep free",
        "ply drc", "11111111111111111111111111111111111111111111111"};
    const struct vor_parameter_info *info = info_of(_i);

    for (size_t k = 0; k < sizeof junk / sizeof junk[0]; k++) {
        struct vor_spec spec, before;

        vor_spec_init(&spec);
        before = spec;
        ck_assert_msg(vor_spec_set(&spec, info->name, junk[k], &vt_err) == VOR_E_PARAM,
                      "%s takes \"%s\"", info->name, junk[k]);
        ck_assert_str_eq(vt_err.parameter, info->name);
        ck_assert_ptr_nonnull(strstr(vt_err.message, info->name));
        ck_assert_mem_eq(&spec, &before, sizeof spec);
        ck_assert_int_eq(vor_spec_set(&spec, info->name, junk[k], NULL), VOR_E_PARAM);
    }
}
END_TEST

START_TEST(a_choice_takes_each_of_its_words_and_no_number)
{
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;
    const char *word;
    size_t length, total = 0;
    unsigned k;

    if (is_number(info))
        return;
    for (k = 0; (length = vor_parameter_choice((enum vor_parameter)_i, k, &word)) > 0; k++) {
        char text[32], back[32];

        (void)snprintf(text, sizeof text, "%.*s", (int)length, word);
        vor_spec_init(&spec);
        vt_assert_ok(vor_spec_set(&spec, info->name, text, &vt_err));
        ck_assert(value_of(&spec, _i) == k);
        ck_assert_str_eq(vor_spec_text(&spec, (enum vor_parameter)_i, back, sizeof back), text);
        text[0] = (char)toupper((unsigned char)text[0]);
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, info->name, text, &vt_err));
        ck_assert_ptr_nonnull(strstr(vt_err.message, back)); /* the words are listed */
        total += length + (k > 0);
    }
    ck_assert_uint_gt(k, 0);
    ck_assert_uint_eq(total, strlen(info->choices));
    ck_assert(info->fallback == VOR_UNSET || info->fallback < k);
    vt_assert_fails(VOR_E_PARAM, vor_spec_set_number(&spec, info->name, 0, &vt_err));
    ck_assert_str_eq(vt_err.parameter, info->name);
}
END_TEST

START_TEST(auto_is_taken_where_it_means_something)
{
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;
    char text[32];

    vor_spec_init(&spec);
    if (info->kind != VOR_KIND_COUNT_OR_AUTO) {
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, info->name, "auto", &vt_err));
        return;
    }
    vt_assert_ok(vor_spec_set(&spec, info->name, "auto", &vt_err));
    ck_assert(value_of(&spec, _i) == VOR_UNSET);
    ck_assert(vor_spec_given(&spec, (enum vor_parameter)_i));
    ck_assert_str_eq(vor_spec_text(&spec, (enum vor_parameter)_i, text, sizeof text), "auto");
    vt_assert_fails(VOR_E_PARAM, vor_spec_set_number(&spec, info->name, VOR_UNSET, &vt_err));
}
END_TEST

/* Property: text -> value -> text -> the same value. */
START_TEST(text_of_a_value_reads_back_as_the_value)
{
    const struct vor_parameter_info *info = info_of(_i);

    for (uint64_t k = 0; is_number(info) && k < 200; k++) {
        double number = info->min + vt_unit(k, (uint64_t)_i) * (info->max - info->min);
        struct vor_spec spec, back;
        char text[64];

        if (is_whole(info))
            number = floor(number);
        vor_spec_init(&spec);
        back = spec;
        vt_assert_ok(vor_spec_set_number(&spec, info->name, number, &vt_err));
        vt_assert_ok(vor_spec_set(&back, info->name,
                                  vor_spec_text(&spec, (enum vor_parameter)_i, text, sizeof text),
                                  &vt_err));
        ck_assert_mem_eq(&spec, &back, sizeof spec);
    }
}
END_TEST

START_TEST(what_is_not_given_has_no_text)
{
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;
    char text[32];

    vor_spec_init(&spec);
    if (info->fallback != VOR_UNSET || info->kind == VOR_KIND_COUNT_OR_AUTO) {
        ck_assert(vor_spec_given(&spec, (enum vor_parameter)_i));
        return;
    }
    ck_assert(!vor_spec_given(&spec, (enum vor_parameter)_i));
    ck_assert_str_eq(vor_spec_text(&spec, (enum vor_parameter)_i, text, sizeof text), "");
}
END_TEST

START_TEST(an_unknown_name_lists_the_names_there_are)
{
    static const char *const names[] = {
        "",
        "pints",
        "Points",
        "points ",
        "point",
        "pointss",
        "a_name_that_is_far_too_long_to_be_shown_as_a_whole_in_any_message"};

    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
        for (int door = 0; door < 2; door++) {
            struct vor_spec spec, before;
            vor_status status;

            vor_spec_init(&spec);
            before = spec;
            status = door == 0 ? vor_spec_set(&spec, names[k], "7", &vt_err)
                               : vor_spec_set_number(&spec, names[k], 7, &vt_err);
            ck_assert_int_eq(status, VOR_E_PARAM);
            for (int i = 0; i < VOR_PARAMETER_COUNT; i++)
                ck_assert_msg(strstr(vt_err.message, info_of(i)->name) != NULL, "no %s in: %s",
                              info_of(i)->name, vt_err.message);
            ck_assert_mem_eq(&spec, &before, sizeof spec);
            ck_assert_int_eq(vor_parameter_find(names[k]), VOR_PARAMETER_COUNT);
        }
}
END_TEST

/* All eight ways to give points, ratio and spacing. */
START_TEST(exactly_one_of_points_ratio_and_spacing_is_given)
{
    struct vor_spec spec;

    vor_spec_init(&spec);
    if (_i & 1)
        vt_assert_ok(vor_spec_set(&spec, "points", "100", &vt_err));
    if (_i & 2)
        vt_assert_ok(vor_spec_set(&spec, "ratio", "0.5", &vt_err));
    if (_i & 4)
        vt_assert_ok(vor_spec_set(&spec, "spacing", "0.1", &vt_err));
    if (_i == 1 || _i == 2 || _i == 4) {
        vt_assert_ok(vor_spec_check(&spec, &vt_err));
        return;
    }
    vt_assert_fails(VOR_E_PARAM, vor_spec_check(&spec, &vt_err));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "exactly one"));
}
END_TEST

START_TEST(numbers_may_be_written_in_every_decimal_way)
{
    static const char *const texts[] = {"100", "+100", "1e2", "1.0E+2", "100.", "100.000", "0100"};

    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) {
        struct vor_spec spec;

        vor_spec_init(&spec);
        vt_assert_ok(vor_spec_set(&spec, "points", texts[k], &vt_err));
        ck_assert(spec.value[VOR_PARAM_POINTS] == 100);
    }
}
END_TEST

START_TEST(processes_are_found_by_their_id)
{
    unsigned count = 0;

    for (; vor_process_info(count) != NULL; count++) {
        const struct vor_process_info *info = vor_process_info(count);

        ck_assert_ptr_eq(vor_process_find(info->id), info);
        ck_assert_uint_gt(strlen(info->title), 0);
        ck_assert_uint_gt(strlen(info->sentence), 0);
    }
    ck_assert_uint_ge(count, 1);
    ck_assert_ptr_null(vor_process_info(UINT32_MAX));
    ck_assert_ptr_null(vor_process_find("Resample"));
    ck_assert_ptr_null(vor_process_find(""));
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("spec_table");

    vt_add_loop(suite, a_parameter_has_a_name_a_sentence_and_a_default_in_its_range,
                VOR_PARAMETER_COUNT);
    vt_add_loop(suite, a_number_is_taken_at_its_ends_and_not_past_them, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, a_whole_number_has_no_fraction, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, junk_is_refused_and_shown, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, a_choice_takes_each_of_its_words_and_no_number, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, auto_is_taken_where_it_means_something, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, text_of_a_value_reads_back_as_the_value, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, what_is_not_given_has_no_text, VOR_PARAMETER_COUNT);
    vt_add(suite, an_unknown_name_lists_the_names_there_are);
    vt_add_loop(suite, exactly_one_of_points_ratio_and_spacing_is_given, 8);
    vt_add(suite, numbers_may_be_written_in_every_decimal_way);
    vt_add(suite, processes_are_found_by_their_id);
    return vt_run(suite);
}
