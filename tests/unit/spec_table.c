/* The request: every parameter of the table at its default, at its ends and past them, as text, as
 * a number, as a word. */
#include "core/spec.h"
#include "tests/support/vt.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The first four spread points and have a target, the last measures. */
enum { PROCESSES = 8, SPREADING = 4 };

/* _i names the parameter in the loops below. */
static const struct vor_parameter_info *info_of(int i)
{
    return vor_parameter_info((enum vor_parameter)i);
}

static double value_of(const struct vor_spec *spec, int i)
{
    return spec->value[i];
}

static int is_whole(const struct vor_parameter_info *info)
{
    return vor_kind_form(info->kind, 0) == VOR_FORM_WHOLE;
}

static int is_number(const struct vor_parameter_info *info)
{
    return is_whole(info) || vor_kind_form(info->kind, 0) == VOR_FORM_REAL;
}

static int is_flag(const struct vor_parameter_info *info)
{
    return vor_kind_form(info->kind, 0) == VOR_FORM_FLAG;
}

static int has_auto(const struct vor_parameter_info *info)
{
    return vor_kind_form(info->kind, 1) == VOR_FORM_AUTO;
}

/* The status of a refused text: a list's words have one of their own. */
static vor_status refusal_of(const struct vor_parameter_info *info, const char *text)
{
    int is_list = vor_kind_form(info->kind, 0) == VOR_FORM_LIST;

    return is_list && text[0] != '\0' ? VOR_E_WORD : VOR_E_PARAM;
}

/* A request for the first process that takes parameter i. */
static void init_for(struct vor_spec *spec, int i)
{
    unsigned process = 0;

    while (!vor_process_takes(vor_process_info(process), (enum vor_parameter)i))
        process++;
    vor_spec_preset(spec, vor_process_info(process));
}

static const char *print(char *out, double number)
{
    (void)snprintf(out, 32, "%.17g", number);
    return out;
}

/* Both doors refuse the number, name the parameter and its range, and change nothing. */
static void assert_out_of_range(int i, double number)
{
    const struct vor_parameter_info *info = info_of(i);
    struct vor_spec spec, before;
    char text[VOR_SPEC_VALUE_SIZE];

    init_for(&spec, i);
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
    char text[VOR_SPEC_VALUE_SIZE];

    init_for(&spec, i);
    vt_assert_ok(vor_spec_set(&spec, info->name, print(text, number), &vt_err));
    ck_assert(value_of(&spec, i) == number);
    ck_assert(vor_spec_given(&spec, (enum vor_parameter)i));
    init_for(&spec, i);
    vt_assert_ok(vor_spec_set_number(&spec, info->name, number, &vt_err));
    ck_assert(value_of(&spec, i) == number);
}

START_TEST(a_parameter_has_a_name_a_sentence_and_a_default_in_its_range)
{
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;
    const char *word;

    ck_assert_uint_gt(strlen(info->name), 0);
    ck_assert(islower((unsigned char)info->name[0]));
    for (const char *c = info->name; *c != '\0'; c++)
        ck_assert(isalpha((unsigned char)*c));
    ck_assert_uint_lt(strlen(info->name), sizeof vt_err.parameter);
    ck_assert_uint_gt(strlen(info->sentence), 10);
    ck_assert_int_eq(vor_parameter_find(info->name), _i);
    ck_assert_uint_eq(vor_parameter_choice(info, 53, &word), 0); /* a bit each in a double */
    init_for(&spec, _i);
    ck_assert(value_of(&spec, _i) == info->fallback);
    if (info->fallback > VOR_UNSET && is_number(info)) /* and no word */
        ck_assert(info->fallback >= info->min && info->fallback <= info->max);
    if (is_number(info))
        ck_assert(info->min < info->max && info->min > VOR_UNSET);
    ck_assert_int_eq((is_number(info) && info->kind != VOR_KIND_REAL_OR_WORD) || is_flag(info) ||
                         info->kind == VOR_KIND_COUNTS_OR_AUTO,
                     info->choices[0] == '\0');
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
    init_for(&spec, _i);
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
        "Auto",    "keep free sites fill",
        "ply drc", "11111111111111111111111111111111111111111111111"};
    const struct vor_parameter_info *info = info_of(_i);

    for (size_t k = 0; k < sizeof junk / sizeof junk[0]; k++) {
        struct vor_spec spec, before;

        if (strcmp(junk[k], "1,5") == 0 && info->kind == VOR_KIND_COUNTS_OR_AUTO)
            continue;
        if (strcmp(junk[k], "none") == 0 &&
            (info->kind == VOR_KIND_LIST || strstr(info->choices, "none") != NULL))
            continue;
        init_for(&spec, _i);
        before = spec;
        vt_assert_fails(refusal_of(info, junk[k]),
                        vor_spec_set(&spec, info->name, junk[k], &vt_err));
        ck_assert_str_eq(vt_err.parameter, info->name);
        ck_assert_ptr_nonnull(strstr(vt_err.message, info->name));
        ck_assert_mem_eq(&spec, &before, sizeof spec);
        ck_assert_int_eq(vor_spec_set(&spec, info->name, junk[k], NULL), refusal_of(info, junk[k]));
    }
}
END_TEST

/* A list that is not well-formed is a wrong value; one with a word too many is not. */
START_TEST(an_unknown_word_of_a_list_has_a_status_of_its_own)
{
    static const struct {
        const char *text;
        vor_status status;
    } cases[] = {{"blur", VOR_E_WORD},       {"mls,blur", VOR_E_WORD}, {"mls,none", VOR_E_WORD},
                 {"mls,mls", VOR_E_PARAM},   {"mls,", VOR_E_PARAM},    {",blur", VOR_E_PARAM},
                 {"blur,,mls", VOR_E_PARAM}, {",", VOR_E_PARAM}};
    struct vor_spec spec, before;

    vor_spec_init(&spec);
    before = spec;
    vt_assert_fails(cases[_i].status, vor_spec_set(&spec, "filters", cases[_i].text, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "filters");
    ck_assert_ptr_nonnull(strstr(vt_err.message, "words of mls, outliers, thin, or none"));
    ck_assert_mem_eq(&spec, &before, sizeof spec);
    vt_assert_fails(VOR_E_PARAM,
                    vor_spec_set_as(&spec, "filters", VOR_SHAPE_STRING, cases[_i].text, &vt_err));
}
END_TEST

static double value_of_word(const struct vor_parameter_info *info, unsigned k)
{
    if (info->kind == VOR_KIND_REAL_OR_WORD)
        return VOR_WORD(k);
    return info->kind == VOR_KIND_LIST ? 1U << k : k;
}

START_TEST(a_choice_takes_each_of_its_words_and_no_number)
{
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;
    const char *word;
    size_t length, total = 0;
    unsigned k;

    if (info->choices[0] == '\0')
        return;
    for (k = 0; (length = vor_parameter_choice(info, k, &word)) > 0; k++) {
        char text[VOR_SPEC_VALUE_SIZE], back[VOR_SPEC_VALUE_SIZE];

        (void)snprintf(text, sizeof text, "%.*s", (int)length, word);
        init_for(&spec, _i);
        vt_assert_ok(vor_spec_set(&spec, info->name, text, &vt_err));
        ck_assert(value_of(&spec, _i) == value_of_word(info, k));
        ck_assert_str_eq(vor_spec_text(&spec, (enum vor_parameter)_i, back), text);
        text[0] = (char)toupper((unsigned char)text[0]);
        vt_assert_fails(refusal_of(info, text), vor_spec_set(&spec, info->name, text, &vt_err));
        ck_assert_ptr_nonnull(strstr(vt_err.message, back)); /* the words are listed */
        total += length + (k > 0);
    }
    ck_assert_uint_gt(k, 0);
    ck_assert_uint_eq(total, strlen(info->choices) - strspn(info->choices, " "));
    ck_assert(info->fallback == VOR_UNSET || info->fallback < k);
    vt_assert_fails(VOR_E_PARAM, vor_spec_set_number(&spec, info->name, 0, &vt_err));
    ck_assert_str_eq(vt_err.parameter, info->name);
}
END_TEST

START_TEST(a_flag_takes_true_and_false_and_nothing_else)
{
    static const char *const refused[] = {"", "1", "0", "True", "yes", "true ", "auto"};
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;
    char text[VOR_SPEC_VALUE_SIZE];

    if (!is_flag(info))
        return;
    init_for(&spec, _i);
    for (unsigned value = 0; value < 2; value++) {
        vt_assert_ok(vor_spec_set(&spec, info->name, value ? "true" : "false", &vt_err));
        ck_assert(value_of(&spec, _i) == value);
        ck_assert_str_eq(vor_spec_text(&spec, (enum vor_parameter)_i, text),
                         value ? "true" : "false");
    }
    for (size_t k = 0; k < sizeof refused / sizeof *refused; k++)
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, info->name, refused[k], &vt_err));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "want true or false"));
}
END_TEST

START_TEST(auto_is_taken_where_it_means_something)
{
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;
    char text[VOR_SPEC_VALUE_SIZE];

    if (info->kind != VOR_KIND_LIST_OR_AUTO && strstr(info->choices, "auto") != NULL)
        return; /* a word like the others */
    init_for(&spec, _i);
    if (!has_auto(info)) {
        vt_assert_fails(refusal_of(info, "auto"), vor_spec_set(&spec, info->name, "auto", &vt_err));
        return;
    }
    vt_assert_ok(vor_spec_set(&spec, info->name, "auto", &vt_err));
    ck_assert(value_of(&spec, _i) == VOR_UNSET);
    ck_assert(vor_spec_given(&spec, (enum vor_parameter)_i));
    ck_assert_str_eq(vor_spec_text(&spec, (enum vor_parameter)_i, text), "auto");
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
        char text[VOR_SPEC_VALUE_SIZE];

        if (is_whole(info))
            number = floor(number);
        init_for(&spec, _i);
        back = spec;
        vt_assert_ok(vor_spec_set_number(&spec, info->name, number, &vt_err));
        vt_assert_ok(vor_spec_set(&back, info->name,
                                  vor_spec_text(&spec, (enum vor_parameter)_i, text), &vt_err));
        ck_assert_mem_eq(&spec, &back, sizeof spec);
    }
}
END_TEST

START_TEST(what_is_not_given_has_no_text)
{
    const struct vor_parameter_info *info = info_of(_i);
    struct vor_spec spec;
    char text[VOR_SPEC_VALUE_SIZE];

    init_for(&spec, _i);
    if (info->fallback != VOR_UNSET || has_auto(info)) {
        ck_assert(vor_spec_given(&spec, (enum vor_parameter)_i));
        return;
    }
    ck_assert(!vor_spec_given(&spec, (enum vor_parameter)_i));
    ck_assert_str_eq(vor_spec_text(&spec, (enum vor_parameter)_i, text), "");
}
END_TEST

/* The name of a parameter stands in a message as a word of its own. */
static int names(const char *message, const char *name)
{
    const char *list = strstr(message, " takes ");
    size_t length = strlen(name);

    for (const char *at = list; at != NULL && (at = strstr(at, name)) != NULL; at += length)
        if (at[-1] == ' ' && (at[length] == ',' || at[length] == '\0'))
            return 1;
    return 0;
}

/* Unknown names, and those of parameters that other processes take: _i is the process. */
START_TEST(a_name_that_a_process_does_not_take_is_refused_with_those_it_takes)
{
    static const char *const strangers[] = {
        "",          "pints",
        "Points",    "points ",
        "point",     "pointss",
        "new\nline", "a_name_that_is_far_too_long_to_be_shown_as_a_whole_in_any_message"};
    enum { STRANGERS = sizeof strangers / sizeof strangers[0] };
    const struct vor_process_info *process = vor_process_info((unsigned)_i);

    for (int k = 0; k < STRANGERS + VOR_PARAMETER_COUNT; k++) {
        const char *name = k < STRANGERS ? strangers[k] : info_of(k - STRANGERS)->name;
        struct vor_spec spec, before;

        if (k >= STRANGERS && vor_process_takes(process, (enum vor_parameter)(k - STRANGERS)))
            continue;
        vor_spec_preset(&spec, process);
        before = spec;
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, name, "7", &vt_err));
        vt_assert_fails(VOR_E_PARAM, vor_spec_set_number(&spec, name, 7, &vt_err));
        vt_assert_fails(VOR_E_PARAM, vor_spec_refuse(&spec, name, "a thing", &vt_err));
        ck_assert_int_eq(strncmp(vt_err.message, "no parameter ", 13), 0);
        ck_assert_ptr_nonnull(strstr(vt_err.message, process->id));
        for (int i = 0; i < VOR_PARAMETER_COUNT; i++)
            ck_assert_msg(names(vt_err.message, info_of(i)->name) ==
                              vor_process_takes(process, (enum vor_parameter)i),
                          "%s in: %s", info_of(i)->name, vt_err.message);
        ck_assert_ptr_null(strchr(vt_err.message, '\n'));
        ck_assert_mem_eq(&spec, &before, sizeof spec);
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

/* A list of which each number was held against all before it, each read from the list's beginning,
 * would not end within the harness's ten minutes. */
START_TEST(a_list_that_is_too_long_is_refused_by_its_length)
{
    enum { NUMBERS = 100000, SIZE = 8 * NUMBERS };
    struct vor_spec spec;
    char *text = vor_malloc(&vt_memory, SIZE, 1), expected[80];
    size_t size = 0;

    for (int distinct = 0; distinct < 2; distinct++) {
        for (int i = 1; i <= NUMBERS; i++)
            size += (size_t)snprintf(text + size, SIZE - size, "%d,", distinct ? i : 1);
        text[--size] = '\0';
        vor_spec_init(&spec);
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, "holes", text, &vt_err));
        (void)snprintf(expected, sizeof expected,
                       "holes has %zu bytes, want at most 512 in all texts of a request", size);
        ck_assert_str_eq(vt_err.message, expected);
        ck_assert_str_eq(vt_err.parameter, "holes");
        size = 0;
    }
    vor_free(&vt_memory, text);
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
    ck_assert_uint_eq(count, PROCESSES);
    ck_assert_ptr_null(vor_process_info(UINT32_MAX));
    ck_assert_ptr_null(vor_process_find("Resample"));
    ck_assert_ptr_null(vor_process_find(""));
}
END_TEST

static struct vor_spec request_for(const char *process)
{
    struct vor_spec spec;

    ck_assert_ptr_nonnull(vor_process_find(process));
    vor_spec_preset(&spec, vor_process_find(process));
    ck_assert_ptr_eq(spec.process, vor_process_find(process));
    return spec;
}

/* What a process has for itself; everything else is as in the table of parameters. */
static const struct {
    const char *process, *parameter, *text;
} presets[] = {{"denoise", "ratio", "1"},       {"denoise", "outliers", "drop"},
               {"inspect", "outliers", "drop"}, {"upsample", "ratio", "4"},
               {"upsample", "iterations", "1"}, {"upsample", "polish", "8"},
               {"mesh", "polish", "120"}};

enum { PRESETS = sizeof presets / sizeof presets[0] };

static const char *preset_of(const char *process, const char *parameter)
{
    for (int k = 0; k < PRESETS; k++)
        if (strcmp(presets[k].process, process) == 0 &&
            strcmp(presets[k].parameter, parameter) == 0)
            return presets[k].text;
    return NULL;
}

START_TEST(a_process_differs_from_the_table_by_its_preset_alone)
{
    const struct vor_process_info *process = vor_process_info((unsigned)_i);
    struct vor_spec spec = request_for(process->id);

    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;
        struct vor_parameter_info info = vor_process_parameter(process, parameter);
        const char *preset = preset_of(process->id, info.name);
        struct vor_spec shown = spec;
        char text[VOR_SPEC_VALUE_SIZE];

        shown.value[i] = info.fallback;
        if (preset == NULL)
            ck_assert_msg(info.fallback == info_of(i)->fallback, "%s of %s", info.name,
                          process->id);
        else
            ck_assert_str_eq(vor_spec_text(&shown, parameter, text), preset);
        ck_assert(value_of(&spec, i) == (i == VOR_PARAM_RATIO ? VOR_UNSET : info.fallback));
        ck_assert_str_eq(info.name, info_of(i)->name);
        ck_assert(i == VOR_PARAM_RATIO ||
                  (info.min == info_of(i)->min && info.max == info_of(i)->max));
    }
}
END_TEST

START_TEST(a_request_without_a_count_gets_that_of_its_process_or_is_refused)
{
    static const struct {
        const char *process;
        double ratio;
    } cases[] = {{"resample", VOR_UNSET}, {"denoise", 1}, {"upsample", 4}, {"simplify", VOR_UNSET}};
    struct vor_spec spec = request_for(cases[_i].process), again;

    vt_assert_fails(VOR_E_PARAM, vor_spec_check(&spec, &vt_err));
    if (cases[_i].ratio == VOR_UNSET) {
        vt_assert_fails(VOR_E_PARAM, vor_spec_complete(&spec, &vt_err));
        ck_assert_ptr_nonnull(strstr(vt_err.message, "0 of points, ratio and spacing"));
        return;
    }
    vt_assert_ok(vor_spec_complete(&spec, &vt_err));
    ck_assert(spec.value[VOR_PARAM_RATIO] == cases[_i].ratio);
    ck_assert(vor_spec_target(&spec, 1000) == cases[_i].ratio * 1000);
    again = spec;
    vt_assert_ok(vor_spec_complete(&again, &vt_err));
    ck_assert_mem_eq(&spec, &again, sizeof spec);
}
END_TEST

/* Filters that move or drop points stand for a number of points, except in upsample. */
START_TEST(filters_alone_make_a_result_unless_the_process_has_a_ratio_of_its_own)
{
    static const char *const processes[4] = {"resample", "denoise", "simplify", "upsample"};
    static const char *const filters[4] = {"mls", "outliers", "thin,mls", "thin"};

    for (int k = 0; k < 4; k++) {
        struct vor_spec spec = request_for(processes[_i]);
        int only = k < 3 && _i < 3, has_ratio = _i == 1 || _i == 3;

        vt_assert_ok(vor_spec_set(&spec, "filters", filters[k], &vt_err));
        if (only || has_ratio)
            vt_assert_ok(vor_spec_complete(&spec, &vt_err));
        else
            vt_assert_fails(VOR_E_PARAM, vor_spec_complete(&spec, &vt_err));
        ck_assert_int_eq(vor_spec_only_filters(&spec), only);
        ck_assert_int_eq(vor_spec_given(&spec, VOR_PARAM_RATIO), has_ratio && !only);
        if (only) {
            ck_assert(vor_spec_target(&spec, 100) == VOR_UNSET);
            vt_assert_ok(vor_spec_check_target(&spec, VOR_UNSET, 100, &vt_err));
        }
        spec.value[VOR_PARAM_RATIO] = VOR_UNSET;
        vt_assert_ok(vor_spec_set(&spec, "points", "10", &vt_err));
        ck_assert_int_eq(vor_spec_only_filters(&spec), 0);
    }
}
END_TEST

/* Each of the three counts in each process, and a parameter that has a preset. */
START_TEST(what_a_caller_gives_wins_over_the_preset)
{
    static const char *const counts[3] = {"points", "ratio", "spacing"};
    static const enum vor_parameter parameters[3] = {VOR_PARAM_POINTS, VOR_PARAM_RATIO,
                                                     VOR_PARAM_SPACING};
    const struct vor_process_info *process = vor_process_info((unsigned)_i);

    for (int k = 0; k < 3; k++) {
        struct vor_spec spec = request_for(process->id);

        vt_assert_ok(vor_spec_set(&spec, counts[k], "1", &vt_err));
        vt_assert_ok(vor_spec_set(&spec, "outliers", "keep", &vt_err));
        vt_assert_ok(vor_spec_complete(&spec, &vt_err));
        for (int j = 0; j < 3; j++)
            ck_assert(spec.value[parameters[j]] == (j == k ? 1 : VOR_UNSET));
        ck_assert(spec.value[VOR_PARAM_OUTLIERS] == VOR_OUTLIERS_KEEP);
        vt_assert_ok(vor_spec_set(&spec, counts[(k + 1) % 3], "1", &vt_err));
        vt_assert_fails(VOR_E_PARAM, vor_spec_complete(&spec, &vt_err));
    }
}
END_TEST

START_TEST(a_ratio_that_its_process_does_not_allow_is_refused_with_the_range)
{
    static const struct {
        const char *process;
        double taken[2], refused[2];
        const char *says;
    } cases[] = {{"resample", {1e-6, 16}, {9e-7, 16.001}, "from 1e-06 to 16"},
                 {"denoise", {1e-6, 16}, {9e-7, 16.001}, "from 1e-06 to 16"},
                 {"upsample", {1, 16}, {0.999, 16.001}, "from 1 to 16"},
                 {"simplify", {1e-6, 1}, {9e-7, 1.001}, "from 1e-06 to 1"}};

    for (int k = 0; k < 2; k++) {
        struct vor_spec spec = request_for(cases[_i].process), before = spec;
        char text[VOR_SPEC_VALUE_SIZE], value[64];

        print(text, cases[_i].refused[k]);
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, "ratio", text, &vt_err));
        ck_assert_str_eq(vt_err.parameter, "ratio");
        ck_assert_ptr_nonnull(strstr(vt_err.message, cases[_i].says));
        (void)snprintf(value, sizeof value, "ratio is %.40s,", text);
        ck_assert_ptr_nonnull(strstr(vt_err.message, value));
        vt_assert_fails(VOR_E_PARAM,
                        vor_spec_set_number(&spec, "ratio", cases[_i].refused[k], &vt_err));
        ck_assert_mem_eq(&spec, &before, sizeof spec);
        vt_assert_ok(vor_spec_set(&spec, "ratio", print(text, cases[_i].taken[k]), &vt_err));
        vt_assert_ok(vor_spec_set_number(&spec, "ratio", cases[_i].taken[k], &vt_err));
    }
}
END_TEST

/* The least and the most that each process allows for an input, and one point past either. */
START_TEST(a_target_is_held_against_the_input_as_its_process_wants)
{
    static const struct {
        const char *process;
        uint64_t input;
        double least, most;
        const char *says;
    } cases[] = {{"resample", 1000, 1, 16000,
                  "want 1 to 16000: resample gives up to 16 for each of the input's 1000"},
                 {"resample", 9000000, 1, 1e7, "want 1 to 10000000"},
                 {"denoise", 1000, 1, 16000, "want 1 to 16000: denoise gives up to 16"},
                 {"upsample", 1000, 1000, 16000,
                  "want 1000 to 16000: upsample gives 1 to 16 for each of the input's 1000"},
                 {"upsample", 10000000, 1e7, 1e7, "want 10000000 to 10000000"},
                 {"simplify", 1000, 1, 1000,
                  "want 1 to 1000: simplify gives up to 1 for each of the input's 1000"},
                 {"simplify", 20000000, 1, 1e7, "want 1 to 10000000"}};

    struct vor_spec spec = request_for(cases[_i].process);

    spec.value[VOR_PARAM_POINTS] = 1234;
    vt_assert_ok(vor_spec_check_target(&spec, cases[_i].least, cases[_i].input, &vt_err));
    vt_assert_ok(vor_spec_check_target(&spec, cases[_i].most, cases[_i].input, &vt_err));
    for (int k = 0; k < 3; k++) {
        const double targets[3] = {cases[_i].least - 1, cases[_i].most + 1, NAN};

        vt_assert_fails(VOR_E_TARGET,
                        vor_spec_check_target(&spec, targets[k], cases[_i].input, &vt_err));
        ck_assert_msg(strstr(vt_err.message, cases[_i].says) != NULL, "%s", vt_err.message);
        ck_assert_ptr_nonnull(strstr(vt_err.message, "points is 1234, "));
        ck_assert_str_eq(vt_err.parameter, "points");
    }
}
END_TEST

START_TEST(a_target_that_comes_of_ratio_or_spacing_is_said_beside_them)
{
    struct vor_spec spec = request_for("simplify");

    vt_assert_ok(vor_spec_set(&spec, "spacing", "0.25", &vt_err));
    ck_assert(vor_spec_target(&spec, 100) == VOR_UNSET);
    vt_assert_fails(VOR_E_TARGET, vor_spec_check_target(&spec, 101, 100, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "spacing");
    ck_assert_ptr_nonnull(
        strstr(vt_err.message, "spacing is 0.25 and asks for 101 points, want 1 to 100"));
    spec = request_for("denoise");
    vt_assert_ok(vor_spec_set(&spec, "ratio", "0.004", &vt_err));
    ck_assert(vor_spec_target(&spec, 100) == 0);
    vt_assert_fails(VOR_E_TARGET, vor_spec_check_target(&spec, 0, 100, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "ratio");
    ck_assert_ptr_nonnull(
        strstr(vt_err.message, "ratio is 0.004 and asks for 0 points, want 1 to"));
}
END_TEST

/* More points than any result may have cannot be upsampled: there is no range to name. */
START_TEST(an_input_too_large_for_its_process_is_told_so)
{
    struct vor_spec spec = request_for("upsample");

    vt_assert_ok(vor_spec_complete(&spec, &vt_err));
    vt_assert_fails(VOR_E_TARGET, vor_spec_check_target(&spec, vor_spec_target(&spec, 20000000),
                                                        20000000, &vt_err));
    ck_assert_str_eq(
        vt_err.message,
        "upsample of 20000000 points asks for 20000000 or more, want at most 10000000");
}
END_TEST

START_TEST(iterations_not_given_are_fewer_before_a_polish)
{
    struct vor_spec spec = request_for("resample");

    ck_assert_uint_eq(vor_spec_iterations(&spec), 12);
    vt_assert_ok(vor_spec_set(&spec, "polish", "1", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 12);
    vt_assert_ok(vor_spec_set(&spec, "polish", "0", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 100);
    vt_assert_ok(vor_spec_set(&spec, "iterations", "37", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 37);
    vt_assert_ok(vor_spec_set(&spec, "polish", "5", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 37);
    vt_assert_ok(vor_spec_set(&spec, "iterations", "0", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 0);
}
END_TEST

/* Of wlop and ear they are projection steps; where the input's points stay, there are none. */
START_TEST(projection_steps_are_rounds_times_steps)
{
    struct vor_spec spec = request_for("resample");

    vt_assert_ok(vor_spec_set(&spec, "method", "wlop", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 36);
    vt_assert_ok(vor_spec_set(&spec, "method", "ear", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 12); /* a polish follows */
    vt_assert_ok(vor_spec_set(&spec, "polish", "0", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 36);
    vt_assert_ok(vor_spec_set(&spec, "rounds", "2", &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "steps", "5", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 10);
    vt_assert_ok(vor_spec_set(&spec, "phases", "resample", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 10);
    vt_assert_ok(vor_spec_set(&spec, "phases", "insert", &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 0);
    vt_assert_ok(vor_spec_set(&spec, "method", "wlop", &vt_err)); /* which has one phase */
    ck_assert_uint_eq(vor_spec_iterations(&spec), 10);
}
END_TEST

/* A process that takes no points has no target to miss. */
START_TEST(a_measure_asks_for_no_number_of_points)
{
    struct vor_spec spec = request_for("measure");

    vt_assert_ok(vor_spec_complete(&spec, &vt_err));
    vt_assert_ok(vor_spec_check(&spec, &vt_err));
    ck_assert(vor_spec_target(&spec, 100) == VOR_UNSET);
    vt_assert_ok(vor_spec_check_target(&spec, VOR_UNSET, 100, &vt_err));
}
END_TEST

START_TEST(a_process_has_inputs_and_outputs_with_names_of_their_own)
{
    const struct vor_process_info *process = vor_process_info((unsigned)_i);

    ck_assert_ptr_nonnull(process->inputs[0].name);
    ck_assert_int_eq(process->inputs[0].is_required, 1);
    ck_assert_ptr_nonnull(process->outputs[0].name);
    for (int k = 0; process->inputs[k].name != NULL; k++) {
        ck_assert_int_lt(k, VOR_INPUTS_MAX);
        ck_assert_uint_gt(strlen(process->inputs[k].sentence), 10);
        ck_assert_int_eq(vor_parameter_find(process->inputs[k].name), VOR_PARAMETER_COUNT);
        for (int j = 0; j < k; j++)
            ck_assert_str_ne(process->inputs[j].name, process->inputs[k].name);
    }
    for (int k = 0; process->outputs[k].name != NULL; k++) {
        ck_assert_int_lt(k, VOR_OUTPUTS_MAX);
        ck_assert_uint_gt(strlen(process->outputs[k].sentence), 10);
        for (int j = 0; j < k; j++)
            ck_assert_str_ne(process->outputs[j].name, process->outputs[k].name);
    }
}
END_TEST

START_TEST(an_input_that_is_required_must_come_along)
{
    struct vor_spec spec = request_for(_i == 0 ? "resample" : "measure");

    vt_assert_ok(vor_spec_check_inputs(&spec, 1, &vt_err));
    vt_assert_fails(VOR_E_PARAM, vor_spec_check_inputs(&spec, 0, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "cloud");
    vt_assert_fails(VOR_E_PARAM, vor_spec_check_inputs(&spec, 2, &vt_err));
    ck_assert_str_eq(vt_err.message, _i == 0 ? "resample has no cloud, and needs one"
                                             : "measure has no cloud, and needs one");
}
END_TEST

START_TEST(a_peak_needs_a_reference)
{
    struct vor_spec spec = request_for("measure");

    vt_assert_ok(vor_spec_set(&spec, "peak", "auto", &vt_err));
    vt_assert_ok(vor_spec_check_inputs(&spec, 1, &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "peak", "1023", &vt_err));
    vt_assert_ok(vor_spec_check_inputs(&spec, 3, &vt_err));
    vt_assert_fails(VOR_E_PARAM, vor_spec_check_inputs(&spec, 1, &vt_err));
    ck_assert_str_eq(vt_err.message, "peak is 1023 without a reference");
    ck_assert_str_eq(vt_err.parameter, "peak");
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("spec_table");

    vt_add(suite, a_measure_asks_for_no_number_of_points);
    vt_add_loop(suite, a_process_has_inputs_and_outputs_with_names_of_their_own, PROCESSES);
    vt_add_loop(suite, an_input_that_is_required_must_come_along, 2);
    vt_add(suite, a_peak_needs_a_reference);

    vt_add_loop(suite, a_parameter_has_a_name_a_sentence_and_a_default_in_its_range,
                VOR_PARAMETER_COUNT);
    vt_add_loop(suite, a_number_is_taken_at_its_ends_and_not_past_them, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, a_whole_number_has_no_fraction, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, junk_is_refused_and_shown, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, a_choice_takes_each_of_its_words_and_no_number, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, a_flag_takes_true_and_false_and_nothing_else, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, auto_is_taken_where_it_means_something, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, text_of_a_value_reads_back_as_the_value, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, what_is_not_given_has_no_text, VOR_PARAMETER_COUNT);
    vt_add_loop(suite, a_name_that_a_process_does_not_take_is_refused_with_those_it_takes,
                PROCESSES);
    vt_add_loop(suite, exactly_one_of_points_ratio_and_spacing_is_given, 8);
    vt_add(suite, numbers_may_be_written_in_every_decimal_way);
    vt_add(suite, a_list_that_is_too_long_is_refused_by_its_length);
    vt_add(suite, processes_are_found_by_their_id);
    vt_add_loop(suite, a_process_differs_from_the_table_by_its_preset_alone, PROCESSES);
    vt_add_loop(suite, a_request_without_a_count_gets_that_of_its_process_or_is_refused, SPREADING);
    vt_add_loop(suite, an_unknown_word_of_a_list_has_a_status_of_its_own, 8);
    vt_add_loop(suite, filters_alone_make_a_result_unless_the_process_has_a_ratio_of_its_own, 4);
    vt_add_loop(suite, what_a_caller_gives_wins_over_the_preset, SPREADING);
    vt_add_loop(suite, a_ratio_that_its_process_does_not_allow_is_refused_with_the_range,
                SPREADING);
    vt_add_loop(suite, a_target_is_held_against_the_input_as_its_process_wants, 7);
    vt_add(suite, a_target_that_comes_of_ratio_or_spacing_is_said_beside_them);
    vt_add(suite, an_input_too_large_for_its_process_is_told_so);
    vt_add(suite, iterations_not_given_are_fewer_before_a_polish);
    vt_add(suite, projection_steps_are_rounds_times_steps);
    return vt_run(suite);
}
