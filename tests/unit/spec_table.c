/* The request, row by row of the table of parameters: whatever a row says, its values are the same
 * as text (query, command line), as a number and in JSON, and what is past them is refused with the
 * name and what is wanted. tests/kinds asks the same of rows of every kind. */
#include "core/spec.h"
#include "core/spec/kinds.h"
#include "proto/json/json.h"
#include "tests/support/vt.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { VALUES_MAX = 40, ALL = VOR_PARAMETER_COUNT, PROCESSES_MAX = 16 };

/* A value of a row: as text and in JSON. */
struct sample {
    char text[VOR_SPEC_VALUE_SIZE], json[VOR_SPEC_VALUE_SIZE];
    double number; /* VOR_UNSET where it is none */
};

static enum vor_form first_form(const struct vor_parameter_info *row)
{
    return vor_kind_form(row->kind, 0);
}

static int is_number(const struct vor_parameter_info *row)
{
    return first_form(row) == VOR_FORM_WHOLE || first_form(row) == VOR_FORM_REAL;
}

/* A request for the first process that takes parameter i; its row goes to *row. */
static struct vor_spec request_for(int i, struct vor_parameter_info *row)
{
    struct vor_spec spec;
    unsigned process = 0;

    while (!vor_process_takes(vor_process_info(process), (enum vor_parameter)i))
        process++;
    vor_spec_preset(&spec, vor_process_info(process));
    *row = vor_process_parameter(spec.process, (enum vor_parameter)i);
    return spec;
}

/* quotes: what stands before the text and behind it in JSON. */
static unsigned add(struct sample *to, unsigned count, double number, const char *const quotes[2],
                    const char *format, ...)
{
    va_list args;

    ck_assert_uint_lt(count, VALUES_MAX);
    va_start(args, format);
    (void)vsnprintf(to[count].text, sizeof to->text, format, args);
    va_end(args);
    (void)snprintf(to[count].json, sizeof to->json, "%s%s%s", quotes[0], to[count].text, quotes[1]);
    to[count].number = number;
    return count + 1;
}

/* Values of a row: its ends and one between, each of its words, true and false, a list, auto. */
static unsigned samples_of(const struct vor_parameter_info *row, struct sample *to, double between)
{
    static const char *const plain[2] = {"", ""}, *const string[2] = {"\"", "\""};
    static const char *const words[2] = {"[\"", "\"]"}, *const array[2] = {"[", "]"};
    const char *const *one = first_form(row) == VOR_FORM_LIST ? words : string, *word;
    double middle = row->min + between * (row->max - row->min);
    unsigned count = 0;
    size_t length;

    if (first_form(row) == VOR_FORM_WHOLE)
        middle = floor(middle);
    for (int k = 0; is_number(row) && k < 3; k++) {
        double number = k == 0 ? row->min : k == 1 ? row->max : middle;

        count = add(to, count, number, plain, "%.17g", number);
    }
    for (unsigned k = 0; (length = vor_parameter_choice(row, k, &word)) > 0; k++)
        if ((row->allowed >> k & 1) != 0)
            count = add(to, count, VOR_UNSET, one, "%.*s", (int)length, word);
    if (first_form(row) == VOR_FORM_FLAG) {
        count = add(to, count, VOR_UNSET, plain, "true");
        count = add(to, count, VOR_UNSET, plain, "false");
    }
    if (first_form(row) == VOR_FORM_LIST && count > 1) {
        const char *a = to[0].text, *b = to[1].text;

        count = add(to, count, VOR_UNSET, plain, "%s,%s", a, b);
        (void)snprintf(to[count - 1].json, sizeof to->json, "[\"%.50s\",\"%.50s\"]", a, b);
        count = add(to, count, VOR_UNSET, plain, "none");
        (void)strcpy(to[count - 1].json, "[]");
    }
    if (first_form(row) == VOR_FORM_COUNTS)
        count = add(to, count, VOR_UNSET, array, "%.0f,%.0f", row->min, row->max);
    if (first_form(row) == VOR_FORM_TEXT)
        count = add(to, count, VOR_UNSET, string, "%.*s", (int)row->max, "a word, and {another}");
    if (vor_kind_form(row->kind, 1) == VOR_FORM_VECTOR)
        count = add(to, count, VOR_UNSET, string, "+1e3,-0.5,.25");
    if (vor_kind_form(row->kind, 1) == VOR_FORM_AUTO)
        count = add(to, count, VOR_UNSET, string, "auto");
    ck_assert_uint_gt(count, 0);
    return count;
}

static vor_status read_json(struct vor_spec *spec, const char *text)
{
    struct vor_json *json = vt_json(text);
    vor_status status = vor_json_spec_read(spec, json, &vt_err);

    vor_json_free(json);
    return status;
}

/* {"name":value}, static. */
static const char *member(const char *name, const char *value)
{
    static char json[2 * VOR_SPEC_VALUE_SIZE];

    (void)snprintf(json, sizeof json, "{\"%s\":%s}", name, value);
    return json;
}

/* A request is read from what it is written as. */
static void assert_comes_back(const struct vor_spec *spec)
{
    struct vor_text text;
    struct vor_spec back;

    vor_text_init(&text, 0);
    vor_json_spec(&text, spec);
    vt_assert_ok(vor_text_status(&text, &vt_err));
    vor_spec_preset(&back, spec->process);
    vt_assert_ok(read_json(&back, text.data));
    for (int i = 0; i < ALL; i++)
        ck_assert_msg(back.value[i] == spec->value[i], "%s is %.17g and not %.17g in %s",
                      vor_parameter_info((enum vor_parameter)i)->name, back.value[i],
                      spec->value[i], text.data);
    ck_assert_mem_eq(&back, spec, sizeof back);
    vor_text_free(&text);
}

VT_TEST_LOOP(a_value_is_the_same_as_text_as_number_and_in_json, ALL)
{
    struct sample samples[VALUES_MAX];
    struct vor_parameter_info row;
    struct vor_spec fresh = request_for(_i, &row);
    unsigned count = samples_of(&row, samples, vt_unit(1, (uint64_t)_i));

    for (unsigned k = 0; k < count; k++) {
        const struct sample *sample = &samples[k];
        struct vor_spec spec = fresh, other = fresh;
        char text[VOR_SPEC_VALUE_SIZE];

        vt_assert_ok(vor_spec_set(&spec, row.name, sample->text, &vt_err));
        ck_assert(vor_spec_given(&spec, (enum vor_parameter)_i));
        vt_assert_ok(read_json(&other, member(row.name, sample->json)));
        ck_assert_mem_eq(&other, &spec, sizeof spec);
        assert_comes_back(&spec);
        other = fresh;
        (void)vor_spec_text(&spec, (enum vor_parameter)_i, text);
        vt_assert_ok(vor_spec_set(&other, row.name, text, &vt_err));
        ck_assert_mem_eq(&other, &spec, sizeof spec);
        if (sample->number == VOR_UNSET) {
            ck_assert_str_eq(text, sample->text);
            continue;
        }
        ck_assert(spec.value[_i] == sample->number);
        other = fresh;
        vt_assert_ok(vor_spec_set_number(&other, row.name, sample->number, &vt_err));
        ck_assert_mem_eq(&other, &spec, sizeof spec);
    }
}

/* Property: so is a request of all that its process takes; _i is the process. */
VT_TEST_LOOP(a_whole_request_comes_back, PROCESSES_MAX)
{
    const struct vor_process_info *process = vor_process_info((unsigned)_i);

    for (uint64_t seed = 0; process != NULL && seed < 100; seed++) {
        struct vor_spec spec;

        vor_spec_preset(&spec, process);
        for (int i = 0; i < ALL; i++) {
            struct vor_parameter_info row = vor_process_parameter(process, (enum vor_parameter)i);
            double u = vt_unit(seed, (uint64_t)i);
            struct sample samples[VALUES_MAX];

            if (!vor_process_takes(process, (enum vor_parameter)i) || u < 0.2)
                continue;
            u *= samples_of(&row, samples, u);
            vt_assert_ok(vor_spec_set(&spec, row.name, samples[(int)u].text, &vt_err));
        }
        assert_comes_back(&spec);
    }
}

/* What the last call has refused is named with what is wanted, and nothing is changed. */
static void assert_named(const struct vor_parameter_info *row, const struct vor_spec *spec,
                         const struct vor_spec *before)
{
    char want[VOR_KIND_WORDS_SIZE], words[VOR_KIND_WORDS_SIZE + 10];

    vor_kind_want(row, want);
    (void)snprintf(words, sizeof words, ", want %s", want);
    ck_assert_str_eq(vt_err.parameter, row->name);
    ck_assert_msg(strncmp(vt_err.message, row->name, strlen(row->name)) == 0 &&
                      strstr(vt_err.message, words) != NULL,
                  "%s", vt_err.message);
    ck_assert_mem_eq(spec, before, sizeof *spec);
}

VT_TEST_LOOP(a_number_past_its_ends_is_refused_with_its_range, ALL)
{
    struct vor_parameter_info row;
    struct vor_spec spec = request_for(_i, &row), before = spec;
    int whole = first_form(&row) == VOR_FORM_WHOLE;
    const double numbers[] = {whole ? row.max + 1 : nextafter(row.max, INFINITY),
                              whole ? row.min - 1 : nextafter(row.min, -INFINITY), 1e300, -1e300,
                              row.min + 0.5};
    char range[80], text[32];

    (void)snprintf(range, sizeof range, "from %.16g to %.16g", row.min, row.max);
    for (int k = 0; is_number(&row) && k < (whole ? 5 : 4); k++) {
        (void)snprintf(text, sizeof text, "%.17g", numbers[k]);
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, row.name, text, &vt_err));
        assert_named(&row, &spec, &before);
        vt_assert_fails(VOR_E_PARAM, vor_spec_set_number(&spec, row.name, numbers[k], &vt_err));
        assert_named(&row, &spec, &before);
        ck_assert_ptr_nonnull(strstr(vt_err.message, range));
    }
    for (int k = 0; is_number(&row) && k < 3; k++)
        vt_assert_fails(VOR_E_PARAM, vor_spec_set_number(&spec, row.name,
                                                         k == 0   ? (double)NAN
                                                         : k == 1 ? (double)INFINITY
                                                                  : VOR_UNSET,
                                                         &vt_err));
}

/* Of a list, words that are none have a status of their own. What each kind refuses: spec_kinds. */
VT_TEST_LOOP(what_is_no_value_is_refused_with_what_is_wanted, ALL)
{
    static const char *const junk[] = {"", "abc", "Auto", "1x", "7\n", "0x10", " 7", "\xc2\xb2"};
    struct vor_parameter_info row;
    struct vor_spec spec = request_for(_i, &row), before = spec;

    for (size_t k = 0; k < sizeof junk / sizeof junk[0]; k++) {
        int is_word = first_form(&row) == VOR_FORM_LIST && junk[k][0] != '\0';

        if (first_form(&row) == VOR_FORM_TEXT && junk[k][0] != '\0')
            continue;
        if (row.min == 0 && first_form(&row) == VOR_FORM_TEXT)
            continue;
        vt_assert_fails(is_word ? VOR_E_WORD : VOR_E_PARAM,
                        vor_spec_set(&spec, row.name, junk[k], &vt_err));
        assert_named(&row, &spec, &before);
        ck_assert_ptr_null(strchr(vt_err.message, '\n'));
        ck_assert_int_eq(vor_spec_set(&spec, row.name, junk[k], NULL), vt_err.status);
    }
    if (is_number(&row) && vor_kind_form(row.kind, 1) == VOR_FORM_NONE)
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, row.name, "auto", &vt_err));
}

VT_TEST(parameters_that_are_no_object_are_refused)
{
    static const char *const texts[] = {"[1]", "[]", "1", "\"a\"", "null", "true"};
    struct vor_spec spec;

    vor_spec_init(&spec);
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++)
        vt_assert_fails(VOR_E_PARAM, read_json(&spec, texts[k]));
}

/* A list that is not well-formed is a wrong value; one with a word too many is not. */
VT_TEST_LOOP(an_unknown_word_of_a_list_has_a_status_of_its_own, 8)
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
    ck_assert_ptr_nonnull(
        strstr(vt_err.message, "each at most once: mls, outliers, thin, or none"));
    ck_assert_mem_eq(&spec, &before, sizeof spec);
}

/* The default, and the schema that a process describes: _i is the parameter. */
VT_TEST_LOOP(a_default_is_a_value_and_what_its_process_describes, ALL)
{
    const struct vor_process_info *process;

    for (unsigned p = 0; (process = vor_process_info(p)) != NULL; p++) {
        struct vor_parameter_info row = vor_process_parameter(process, (enum vor_parameter)_i);
        char text[VOR_SPEC_VALUE_SIZE], bound[80];
        const struct vor_json *schema;
        struct vor_json *json = NULL;
        struct vor_text all, part;
        struct vor_spec spec, again;

        if (!vor_process_takes(process, (enum vor_parameter)_i))
            continue;
        vor_spec_preset(&spec, process);
        again = spec;
        ck_assert(_i == VOR_PARAM_RATIO || spec.value[_i] == row.fallback);
        spec.value[_i] = row.fallback;
        (void)vor_spec_text(&spec, (enum vor_parameter)_i, text);
        if (vor_spec_given(&spec, (enum vor_parameter)_i))
            vt_assert_ok(vor_spec_set(&again, row.name, text, &vt_err));
        else
            ck_assert_str_eq(text, "");
        vor_text_init(&all, 0);
        vor_text_init(&part, 0);
        vor_json_process(&all, process, NULL, 0);
        vt_assert_ok(vor_json_parse(&json, all.data, all.size, &vt_err));
        schema = vor_json_get(vor_json_get(vor_json_get(json, "inputs"), row.name), "schema");
        ck_assert_msg(schema != NULL, "%s does not describe %s", process->id, row.name);
        vor_json_copy(&part, schema);
        (void)snprintf(bound, sizeof bound, "\"minimum\":%.16g,\"maximum\":%.16g", row.min,
                       row.max);
        ck_assert_msg(!is_number(&row) || strstr(part.data, bound) != NULL, "%s in %s", bound,
                      part.data);
        (void)snprintf(bound, sizeof bound, "\"x-unit\":\"%s\"", row.unit);
        ck_assert_int_eq(strstr(part.data, bound) != NULL, row.unit[0] != '\0');
        ck_assert_int_eq(vor_json_get(schema, "default") != NULL, text[0] != '\0');
        for (char *rest = text, *word; (word = strsep(&rest, ",")) != NULL && *word != '\0';)
            ck_assert_msg(strcmp(word, "none") == 0 ||
                              strstr(strstr(part.data, "\"default\":"), word) != NULL,
                          "%s in %s", word, part.data);
        vor_json_free(json);
        vor_text_free(&all);
        vor_text_free(&part);
    }
}

VT_TEST_LOOP(a_row_is_well_formed, ALL)
{
    struct vor_parameter_info row;
    struct vor_spec spec = request_for(_i, &row);
    const char *word;

    ck_assert(islower((unsigned char)row.name[0]));
    for (const char *c = row.name; *c != '\0'; c++)
        ck_assert(isalpha((unsigned char)*c));
    ck_assert_uint_lt(strlen(row.name), sizeof vt_err.parameter);
    ck_assert_uint_gt(strlen(row.sentence), 5);
    ck_assert_int_eq(vor_parameter_find(row.name), _i);
    ck_assert_uint_eq(vor_parameter_choice(&row, 53, &word), 0); /* a bit each in a double */
    if (is_number(&row))
        ck_assert(row.min < row.max && row.min > VOR_UNSET);
    ck_assert_ptr_eq(vor_process_find(spec.process->id), spec.process);
}

/* The name of a parameter stands in a message as a word of its own. */
static int names(const char *message, const char *name)
{
    const char *list = strstr(message, "; ");
    size_t length = strlen(name);

    for (const char *at = list; at != NULL && (at = strstr(at, name)) != NULL; at += length)
        if (at[-1] == ' ' && (at[length] == ',' || at[length] == '\0'))
            return 1;
    return 0;
}

/* Unknown names, and those of parameters that other processes take: _i is the process. At most
 * three that it takes are named, the nearest; none where the name is empty, or too long to be
 * compared. */
VT_TEST_LOOP(a_name_that_a_process_does_not_take_is_refused_with_those_it_takes, PROCESSES_MAX)
{
    static const char *const strangers[] = {
        "",          "pints",
        "Points",    "points ",
        "point",     "pointss",
        "new\nline", "a_name_that_is_far_too_long_to_be_shown_as_a_whole_in_any_message"};
    enum { STRANGERS = sizeof strangers / sizeof strangers[0] };
    const struct vor_process_info *process = vor_process_info((unsigned)_i);

    for (int k = 0; process != NULL && k < STRANGERS + ALL; k++) {
        const char *name = k < STRANGERS
                               ? strangers[k]
                               : vor_parameter_info((enum vor_parameter)(k - STRANGERS))->name;
        struct vor_spec spec, before;
        int some = 0, named = 0;

        if (k >= STRANGERS && vor_process_takes(process, (enum vor_parameter)(k - STRANGERS)))
            continue;
        vor_spec_preset(&spec, process);
        before = spec;
        vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, name, "7", &vt_err));
        vt_assert_fails(VOR_E_PARAM, vor_spec_set_number(&spec, name, 7, &vt_err));
        vt_assert_fails(VOR_E_PARAM, vor_spec_refuse(&spec, name, "a thing", &vt_err));
        ck_assert_int_eq(strncmp(vt_err.message, "unknown parameter \"", 19), 0);
        ck_assert_ptr_nonnull(strstr(vt_err.message, process->id));
        for (int i = 0; i < ALL; i++) {
            int is_taken = vor_process_takes(process, (enum vor_parameter)i);
            int is_named = names(vt_err.message, vor_parameter_info((enum vor_parameter)i)->name);

            ck_assert_msg(is_taken || !is_named, "parameter %d in: %s", i, vt_err.message);
            some |= is_taken;
            named += is_named;
        }
        ck_assert_msg(!some || named > 0 || name[0] == '\0' || k == STRANGERS - 1, "no name in: %s",
                      vt_err.message);
        ck_assert_int_le(named, 3);
        ck_assert_ptr_null(strchr(vt_err.message, '\n'));
        ck_assert_mem_eq(&spec, &before, sizeof spec);
    }
}
