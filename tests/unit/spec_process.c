/* Processes: what they have for themselves, the number of points they are asked for, and the inputs
 * that must come along. The rows of their parameters: spec_table. */
#include "core/spec.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The first four spread points and have a target, the last measures. */
enum { PROCESSES = 10, SPREADING = 4 };

static struct vor_spec request_for(const char *process)
{
    struct vor_spec spec;

    ck_assert_ptr_nonnull(vor_process_find(process));
    vor_spec_preset(&spec, vor_process_find(process));
    ck_assert_ptr_eq(spec.process, vor_process_find(process));
    return spec;
}

/* All eight ways to give points, ratio and spacing. */
VT_TEST_LOOP(exactly_one_of_points_ratio_and_spacing_is_given, 8)
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

VT_TEST(processes_are_found_by_their_id)
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

/* What a process has for itself; everything else is as in the table of parameters. */
static const struct {
    const char *process, *parameter, *text;
} presets[] = {{"denoise", "ratio", "1"},       {"denoise", "outliers", "drop"},
               {"inspect", "outliers", "drop"}, {"upsample", "ratio", "4"},
               {"upsample", "iterations", "1"}, {"upsample", "polish", "12"},
               {"mesh", "polish", "120"},       {"upsample", "attributes", "blend"}};

enum { PRESETS = sizeof presets / sizeof presets[0] };

static const char *preset_of(const char *process, const char *parameter)
{
    for (int k = 0; k < PRESETS; k++)
        if (strcmp(presets[k].process, process) == 0 &&
            strcmp(presets[k].parameter, parameter) == 0)
            return presets[k].text;
    return NULL;
}

VT_TEST_LOOP(a_process_differs_from_the_table_by_its_preset_alone, PROCESSES)
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
            ck_assert_msg(info.fallback == vor_parameter_info(parameter)->fallback, "%s of %s",
                          info.name, process->id);
        else
            ck_assert_str_eq(vor_spec_text(&shown, parameter, text), preset);
        ck_assert(spec.value[i] == (i == VOR_PARAM_RATIO ? VOR_UNSET : info.fallback));
        ck_assert_str_eq(info.name, vor_parameter_info(parameter)->name);
        ck_assert(i == VOR_PARAM_RATIO || (info.min == vor_parameter_info(parameter)->min &&
                                           info.max == vor_parameter_info(parameter)->max));
    }
}

VT_TEST_LOOP(a_request_without_a_count_gets_that_of_its_process_or_is_refused, SPREADING)
{
    static const struct {
        const char *process;
        double ratio;
    } cases[] = {{"resample", VOR_UNSET}, {"denoise", 1}, {"upsample", 4}, {"simplify", VOR_UNSET}};
    struct vor_spec spec = request_for(cases[_i].process), again;

    vt_assert_fails(VOR_E_PARAM, vor_spec_check(&spec, &vt_err));
    if (cases[_i].ratio == VOR_UNSET) {
        vt_assert_fails(VOR_E_PARAM, vor_spec_complete(&spec, &vt_err));
        ck_assert_ptr_nonnull(strstr(vt_err.message, "points, ratio and spacing: none"));
        return;
    }
    vt_assert_ok(vor_spec_complete(&spec, &vt_err));
    ck_assert(spec.value[VOR_PARAM_RATIO] == cases[_i].ratio);
    ck_assert(vor_spec_target(&spec, 1000) == cases[_i].ratio * 1000);
    again = spec;
    vt_assert_ok(vor_spec_complete(&again, &vt_err));
    ck_assert_mem_eq(&spec, &again, sizeof spec);
}

/* Filters that move or drop points stand for a number of points, except in upsample. */
VT_TEST_LOOP(filters_alone_make_a_result_unless_the_process_has_a_ratio_of_its_own, 4)
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

/* Each of the three counts in each process, and a parameter that has a preset. */
VT_TEST_LOOP(what_a_caller_gives_wins_over_the_preset, SPREADING)
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

VT_TEST_LOOP(a_ratio_that_its_process_does_not_allow_is_refused_with_the_range, SPREADING)
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

        (void)snprintf(text, sizeof text, "%.17g", cases[_i].refused[k]);
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, "ratio", text, &vt_err));
        ck_assert_str_eq(vt_err.parameter, "ratio");
        ck_assert_ptr_nonnull(strstr(vt_err.message, cases[_i].says));
        (void)snprintf(value, sizeof value, "ratio is %.40s,", text);
        ck_assert_ptr_nonnull(strstr(vt_err.message, value));
        vt_assert_fails(VOR_E_PARAM,
                        vor_spec_set_number(&spec, "ratio", cases[_i].refused[k], &vt_err));
        ck_assert_mem_eq(&spec, &before, sizeof spec);
        (void)snprintf(text, sizeof text, "%.17g", cases[_i].taken[k]);
        vt_assert_ok(vor_spec_set(&spec, "ratio", text, &vt_err));
        vt_assert_ok(vor_spec_set_number(&spec, "ratio", cases[_i].taken[k], &vt_err));
    }
}

/* The least and the most that each process allows for an input, and one point past either. */
VT_TEST_LOOP(a_target_is_held_against_the_input_as_its_process_wants, 7)
{
    static const struct {
        const char *process;
        uint64_t input;
        double least, most;
        const char *says;
    } cases[] = {
        {"resample", 1000, 1, 16000,
         "want 1 to 16000: the result of resample may have up to 16 times as many points as "
         "the input (1000)"},
        {"resample", 9000000, 1, 1e7, "want 1 to 10000000"},
        {"denoise", 1000, 1, 16000, "want 1 to 16000: the result of denoise may have up to 16"},
        {"upsample", 1000, 1000, 16000,
         "want 1000 to 16000: the result of upsample may have 1 to 16 times as many points "
         "as the input (1000)"},
        {"upsample", 10000000, 1e7, 1e7, "want 10000000 to 10000000"},
        {"simplify", 1000, 1, 1000,
         "want 1 to 1000: simplify cannot give more points than the input has (1000)"},
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

VT_TEST(a_target_that_comes_of_ratio_or_spacing_is_said_beside_them)
{
    struct vor_spec spec = request_for("simplify");

    vt_assert_ok(vor_spec_set(&spec, "spacing", "0.25", &vt_err));
    ck_assert(vor_spec_target(&spec, 100) == VOR_UNSET);
    vt_assert_fails(VOR_E_TARGET, vor_spec_check_target(&spec, 101, 100, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "spacing");
    ck_assert_ptr_nonnull(
        strstr(vt_err.message, "spacing is 0.25 and needs 101 points, want 1 to 100"));
    spec = request_for("denoise");
    vt_assert_ok(vor_spec_set(&spec, "ratio", "0.004", &vt_err));
    ck_assert(vor_spec_target(&spec, 100) == 0);
    vt_assert_fails(VOR_E_TARGET, vor_spec_check_target(&spec, 0, 100, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "ratio");
    ck_assert_ptr_nonnull(strstr(vt_err.message, "ratio is 0.004 and needs 0 points, want 1 to"));
}

/* More points than any result may have cannot be upsampled: there is no range to name. */
VT_TEST(an_input_too_large_for_its_process_is_told_so)
{
    struct vor_spec spec = request_for("upsample");

    vt_assert_ok(vor_spec_complete(&spec, &vt_err));
    vt_assert_fails(VOR_E_TARGET, vor_spec_check_target(&spec, vor_spec_target(&spec, 20000000),
                                                        20000000, &vt_err));
    ck_assert_str_eq(
        vt_err.message,
        "the result of upsample has at least as many points as the input (20000000), so "
        "20000000 or more, but a result may have at "
        "most 10000000 points");
}

VT_TEST(iterations_not_given_are_fewer_before_a_polish)
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

/* Of wlop and ear they are projection steps; where the input's points stay, there are none. */
VT_TEST(projection_steps_are_rounds_times_steps)
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

/* A process that takes no points has no target to miss. */
VT_TEST(a_measure_asks_for_no_number_of_points)
{
    struct vor_spec spec = request_for("measure");

    vt_assert_ok(vor_spec_complete(&spec, &vt_err));
    vt_assert_ok(vor_spec_check(&spec, &vt_err));
    ck_assert(vor_spec_target(&spec, 100) == VOR_UNSET);
    vt_assert_ok(vor_spec_check_target(&spec, VOR_UNSET, 100, &vt_err));
}

VT_TEST_LOOP(a_process_has_inputs_and_outputs_with_names_of_their_own, PROCESSES)
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

VT_TEST_LOOP(an_input_that_is_required_must_come_along, 2)
{
    struct vor_spec spec = request_for(_i == 0 ? "resample" : "measure");

    vt_assert_ok(vor_spec_check_inputs(&spec, 1, &vt_err));
    vt_assert_fails(VOR_E_PARAM, vor_spec_check_inputs(&spec, 0, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "cloud");
    vt_assert_fails(VOR_E_PARAM, vor_spec_check_inputs(&spec, 2, &vt_err));
    ck_assert_str_eq(vt_err.message, _i == 0 ? "resample needs a cloud, but the request has none"
                                             : "measure needs a cloud, but the request has none");
}

VT_TEST(a_peak_needs_a_reference)
{
    struct vor_spec spec = request_for("measure");

    vt_assert_ok(vor_spec_set(&spec, "peak", "auto", &vt_err));
    vt_assert_ok(vor_spec_check_inputs(&spec, 1, &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "peak", "1023", &vt_err));
    vt_assert_ok(vor_spec_check_inputs(&spec, 3, &vt_err));
    vt_assert_fails(VOR_E_PARAM, vor_spec_check_inputs(&spec, 1, &vt_err));
    ck_assert_str_eq(
        vt_err.message,
        "the parameter peak is 1023, which needs a reference cloud, but the request has none");
    ck_assert_str_eq(vt_err.parameter, "peak");
}
