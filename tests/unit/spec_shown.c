/* Titles, levels and presets: what people are shown of a request. */
#include "core/spec.h"
#include "tests/support/vt.h"

#include <stdio.h>
#include <string.h>

enum { TITLE_MAX = 32 }; /* bytes: a title stands beside a field */

VT_TEST_LOOP(a_parameter_has_a_title_of_its_own, VOR_PARAMETER_COUNT)
{
    const char *title = vor_parameter_title((enum vor_parameter)_i);
    const char *name = vor_parameter_info((enum vor_parameter)_i)->name;

    ck_assert_msg(strcmp(title, name) != 0, "%s has no row in VOR_TITLE_TABLE", name);
    ck_assert_uint_le(strlen(title), TITLE_MAX);
    for (int i = 0; i < _i; i++)
        ck_assert_str_ne(title, vor_parameter_title((enum vor_parameter)i));
}

VT_TEST_LOOP(few_parameters_of_a_process_are_basic, 16)
{
    const struct vor_process_info *process = vor_process_info((unsigned)_i);
    int basic = 0, taken = 0;

    for (int i = 0; process != NULL && i < VOR_PARAMETER_COUNT; i++) {
        if (!vor_process_takes(process, (enum vor_parameter)i))
            continue;
        taken++;
        basic += vor_parameter_level((enum vor_parameter)i) == VOR_LEVEL_BASIC;
    }
    ck_assert_int_le(basic, 12); /* a form that is read at a glance */
    if (process != NULL && vor_process_takes(process, VOR_PARAM_POINTS))
        ck_assert_int_lt(3 * basic, taken);
}

/* Whether a preset's request can be made; it counts the values that it sets. */
static int values_of(const struct vor_process_info *process, const struct vor_named_preset *preset)
{
    const char *at = preset->values;
    char value[VOR_PRESET_VALUE_SIZE];
    enum vor_parameter parameter;
    struct vor_spec spec;
    int count = 0;

    vor_spec_preset(&spec, process);
    while (vor_named_preset_next(&at, &parameter, value)) {
        ck_assert_msg(parameter != VOR_PARAMETER_COUNT, "%s: a name of no parameter", preset->name);
        vt_assert_ok(vor_spec_set(&spec, vor_parameter_info(parameter)->name, value, &vt_err));
        ck_assert(vor_spec_given(&spec, parameter));
        count++;
    }
    vt_assert_ok(vor_spec_complete(&spec, &vt_err));
    return count;
}

VT_TEST_LOOP(a_preset_is_a_request_that_can_be_made, 5)
{
    static const char *const wanted[] = {"resample", "denoise", "upsample", "simplify", "mesh"};
    const struct vor_process_info *process = vor_process_find(wanted[_i]);
    const struct vor_named_preset *preset;
    unsigned count = 0;

    ck_assert_ptr_nonnull(process);
    for (; (preset = vor_named_preset(process->id, count)) != NULL; count++) {
        ck_assert(process->on_http);
        ck_assert_int_ge(values_of(process, preset), strcmp(preset->name, "denoise") == 0 ? 0 : 1);
        ck_assert_ptr_eq(vor_named_preset_find(process->id, preset->name), preset);
    }
    ck_assert_uint_ge(count, 1);
}

VT_TEST(every_preset_is_of_a_process_that_there_is)
{
    const struct vor_process_info *process;
    unsigned of_processes = 0, rows = 0;

#define COUNT_ROW(name, title, process, values, sentence) rows++;
    VOR_NAMED_PRESET_TABLE(COUNT_ROW)
#undef COUNT_ROW
    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++)
        for (unsigned k = 0; vor_named_preset(process->id, k) != NULL; k++)
            of_processes++;
    ck_assert_uint_eq(of_processes, rows);
    ck_assert_ptr_null(vor_named_preset("resample", rows));
    ck_assert_ptr_null(vor_named_preset_find("resample", "mesh"));
}

static int has_choice(const struct vor_parameter_info *info, const char *word)
{
    const char *choice;
    size_t length;

    for (unsigned i = 0; (length = vor_parameter_choice(info, i, &choice)) > 0; i++)
        if (length == strlen(word) && strncmp(choice, word, length) == 0)
            return 1;
    return 0;
}

VT_TEST_LOOP(a_parameter_hangs_on_words_of_another, VOR_PARAMETER_COUNT)
{
    const struct vor_when *when = vor_parameter_when((enum vor_parameter)_i);
    const struct vor_parameter_info *other;
    char words[128], *rest = words, *word;
    const char *choice;
    unsigned count = 0;

    if (when == NULL)
        return;
    other = vor_parameter_info(when->other);
    ck_assert_int_eq(when->parameter, _i);
    ck_assert_int_ne(when->other, _i);
    (void)snprintf(words, sizeof words, "%s", when->words);
    while ((word = strtok_r(NULL, " ", &rest)) != NULL) {
        ck_assert_msg(has_choice(other, word), "%s", word);
        count++;
    }
    ck_assert_uint_ge(count, 1);
    ck_assert_uint_gt(vor_parameter_choice(other, count, &choice), 0); /* not all of its words */
}

VT_TEST(a_walk_over_values_ends)
{
    const char *at = " points=5  boundary=keep ";
    char value[VOR_PRESET_VALUE_SIZE];
    enum vor_parameter parameter;

    ck_assert(vor_named_preset_next(&at, &parameter, value));
    ck_assert_int_eq(parameter, VOR_PARAM_POINTS);
    ck_assert_str_eq(value, "5");
    ck_assert(vor_named_preset_next(&at, &parameter, value));
    ck_assert_int_eq(parameter, VOR_PARAM_BOUNDARY);
    ck_assert_str_eq(value, "keep");
    ck_assert(!vor_named_preset_next(&at, &parameter, value));
    ck_assert(!vor_named_preset_next(&at, &parameter, value));
    at = "nonsense=1";
    ck_assert(vor_named_preset_next(&at, &parameter, value));
    ck_assert_int_eq(parameter, VOR_PARAMETER_COUNT);
}
