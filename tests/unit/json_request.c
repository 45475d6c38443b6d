/* Requests as JSON: read back as they were written, refused by name; and the descriptions of the
 * processes. */
#include "proto/json/json.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

static struct vor_text text;

static struct vor_json *parsed(const char *json)
{
    struct vor_json *out = NULL;

    vt_assert_ok(vor_json_parse(&out, json, strlen(json), &vt_err));
    return out;
}

/* Whether a choice is written with a name after a colon. */
static int takes_name(const struct vor_parameter_info *info, unsigned choice)
{
    const char *word;
    size_t length = vor_parameter_choice(info, choice, &word);

    return memchr(word, ':', length) != NULL;
}

/* A value for a parameter, drawn at random: within its range, at its ends, or one of its words. */
static double draw(const struct vor_process_info *process, enum vor_parameter parameter,
                   uint64_t seed)
{
    struct vor_parameter_info row = vor_process_parameter(process, parameter), *info = &row;
    int is_whole = vor_kind_form(info->kind, 0) == VOR_FORM_WHOLE;
    uint64_t index = (uint64_t)parameter;
    double u = vt_unit(seed, index), value;
    const char *word;
    unsigned words = 0;

    if (u < 0.2)
        return info->fallback;
    if (vor_kind_form(info->kind, 0) == VOR_FORM_CHOICE) { /* of those that need no text */
        unsigned fitting[32], count = 0;

        for (; vor_parameter_choice(info, words, &word) > 0; words++)
            if ((info->allowed >> words & 1) != 0 && !takes_name(info, words))
                fitting[count++] = words;
        return (double)fitting[vor_rng_below(seed, 7, index, count)];
    }
    if (vor_kind_form(info->kind, 0) == VOR_FORM_COUNTS) /* numbers need a text */
        return VOR_UNSET;
    if (vor_kind_form(info->kind, 1) == VOR_FORM_AUTO && u < 0.3)
        return VOR_UNSET;
    value = info->min + (info->max - info->min) * vt_unit(seed, 100 + index);
    if (u > 0.9)
        value = u > 0.95 ? info->min : info->max;
    return is_whole ? floor(value) : value;
}

START_TEST(a_vector_comes_back_with_its_text)
{
    static const char *const texts[] = {"637000,849000,0", "+1e3,-0.5,.25", "0,0,0"};
    char pointer[VOR_JSON_POINTER_MAX];

    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct vor_spec spec, back;
        struct vor_json *json;
        double numbers[3];

        vor_spec_init(&spec);
        vor_spec_init(&back);
        vt_assert_ok(vor_spec_set(&spec, "origin", texts[i], &vt_err));
        ck_assert(vor_spec_vector(&spec, VOR_PARAM_ORIGIN, numbers));
        vor_text_init(&text, 0);
        vor_json_spec(&text, &spec);
        json = parsed(text.data);
        vt_assert_ok(vor_json_spec_read(&back, json, pointer, &vt_err));
        ck_assert_mem_eq(&back, &spec, sizeof spec);
        ck_assert_str_eq(vor_spec_name(&back, VOR_PARAM_ORIGIN), texts[i]);
        vt_assert_ok(vor_spec_set(&back, "origin", "auto", &vt_err));
        ck_assert(!vor_spec_vector(&back, VOR_PARAM_ORIGIN, numbers));
        ck_assert_ptr_null(vor_spec_name(&back, VOR_PARAM_ORIGIN));
        vor_json_free(json);
        vor_text_free(&text);
    }
}
END_TEST

/* Property: what a request is written as, it is read from; the processes take turns. */
START_TEST(every_request_comes_back)
{
    for (uint64_t i = 0; i < 100; i++) {
        const struct vor_process_info *process = vor_process_info((unsigned)(i % 5));
        struct vor_spec spec, back;
        struct vor_json *json;
        char pointer[VOR_JSON_POINTER_MAX];

        vor_spec_preset(&spec, process);
        vor_spec_preset(&back, process);
        for (int p = 0; p < VOR_PARAMETER_COUNT; p++) {
            if (!vor_process_takes(process, (enum vor_parameter)p))
                continue;
            spec.value[p] = draw(process, (enum vor_parameter)p, (uint64_t)_i * 1000 + i);
            back.value[p] = VOR_UNSET;
        }
        vor_text_init(&text, 0);
        vor_json_spec(&text, &spec);
        json = parsed(text.data);
        vt_assert_ok(vor_json_spec_read(&back, json, pointer, &vt_err));
        ck_assert_str_eq(pointer, "");
        for (int p = 0; p < VOR_PARAMETER_COUNT; p++)
            ck_assert_msg(spec.value[p] == back.value[p], "%s: %.17g is not %.17g in %s",
                          vor_parameter_info((enum vor_parameter)p)->name, back.value[p],
                          spec.value[p], text.data);
        vor_json_free(json);
        vor_text_free(&text);
    }
}
END_TEST

struct refused {
    const char *json, *pointer, *parameter, *message;
};

static const struct refused refused[] = {
    {"[]", "", "", "the parameters are an array, want an object"},
    {"{\"points\":\"100\"}", "/points", "points",
     "points is a string, want a whole number from 1 to 10000000"},
    {"{\"points\":null}", "/points", "points",
     "points is null, want a whole number from 1 to 10000000"},
    {"{\"seed\":2,\"points\":0}", "/points", "points",
     "points is 0, want a whole number from 1 to 10000000"},
    {"{\"points\":1.5}", "/points", "points",
     "points is 1.5, want a whole number from 1 to 10000000"},
    {"{\"points\":[1]}", "/points", "points",
     "points is an array, want a whole number from 1 to 10000000"},
    {"{\"points\":true}", "/points", "points",
     "points is a boolean, want a whole number from 1 to 10000000"},
    {"{\"neighbors\":\"Auto\"}", "/neighbors", "neighbors",
     "neighbors is Auto, want a whole number from 6 to 500 or auto"},
    {"{\"boundary\":1}", "/boundary", "boundary",
     "boundary is a number, want one of keep, free, sites, fill"},
    {"{\"boundary\":{}}", "/boundary", "boundary",
     "boundary is an object, want one of keep, free, sites, fill"},
    {"{\"boundary\":\"kee\\np\"}", "/boundary", "boundary",
     "boundary is \"kee\\x0ap\", want one of keep, free, sites, fill"},
    {"{\"a/b~c\":1}", "/a~1b~0c", "a/b~c", NULL},
    {"{\"new\\nline\":1}", "/new\nline", "new\\x0aline", NULL},
    {"{\"Points\":1}", "/Points", "Points", NULL},
};

START_TEST(a_wrong_member_is_named_and_nothing_is_set)
{
    const struct refused *r = &refused[_i];
    struct vor_json *json = parsed(r->json);
    struct vor_spec spec, before;
    char pointer[VOR_JSON_POINTER_MAX];

    vor_spec_init(&spec);
    before = spec;
    vt_assert_fails(VOR_E_PARAM, vor_json_spec_read(&spec, json, pointer, &vt_err));
    ck_assert_str_eq(pointer, r->pointer);
    ck_assert_str_eq(vt_err.parameter, r->parameter);
    if (r->message != NULL)
        ck_assert_str_eq(vt_err.message, r->message);
    ck_assert_ptr_null(strchr(vt_err.message, '\n'));
    ck_assert_mem_eq(&spec, &before, sizeof spec);
    vor_json_free(json);
}
END_TEST

static const struct vor_json *at(const struct vor_json *json, const char *a, const char *b,
                                 const char *c)
{
    return vor_json_get(vor_json_get(vor_json_get(json, a), b), c);
}

static double number_at(const struct vor_json *json, const char *name, const char *word)
{
    double number = NAN;

    (void)vor_json_get_number(vor_json_get(at(json, "inputs", name, "schema"), word), &number);
    return number;
}

/* Ranges and defaults of the process, and not those of the table; NaN: there is none. */
START_TEST(a_process_describes_its_preset)
{
    static const struct {
        const char *id;
        double least, most, ratio;
        const char *outliers;
    } cases[] = {{"resample", 1e-6, 16, NAN, "keep"},
                 {"denoise", 1e-6, 16, 1, "drop"},
                 {"upsample", 1, 16, 4, "keep"},
                 {"simplify", 1e-6, 1, NAN, "keep"}};
    struct vor_json *json;
    double ratio;

    vor_text_init(&text, 0);
    vor_json_process(&text, vor_process_find(cases[_i].id), NULL, 0);
    json = parsed(text.data);
    ck_assert_str_eq(vor_json_get_string(vor_json_get(json, "id")), cases[_i].id);
    ck_assert_double_eq(number_at(json, "ratio", "minimum"), cases[_i].least);
    ck_assert_double_eq(number_at(json, "ratio", "maximum"), cases[_i].most);
    ratio = number_at(json, "ratio", "default");
    ck_assert(ratio == cases[_i].ratio || (isnan(ratio) && isnan(cases[_i].ratio)));
    ck_assert_str_eq(
        vor_json_get_string(vor_json_get(at(json, "inputs", "outliers", "schema"), "default")),
        cases[_i].outliers);
    vor_json_free(json);
    vor_text_free(&text);
}
END_TEST

/* A cloud has no members; the schema of a document names all of its own. _i is the process. */
START_TEST(a_process_describes_the_documents_that_it_gives)
{
    const struct vor_process_info *process = vor_process_info((unsigned)_i);
    struct vor_json *json;

    vor_text_init(&text, 0);
    vor_json_process(&text, process, NULL, 0);
    json = parsed(text.data);
    for (const struct vor_artefact_info *output = process->outputs; output->name != NULL;
         output++) {
        const struct vor_json *schema = at(json, "outputs", output->name, "schema");

        ck_assert_int_eq(vor_json_get(vor_json_get(schema, "properties"), "delta") != NULL,
                         output->kind == VOR_ARTEFACT_DOCUMENT);
    }
    ck_assert_ptr_nonnull(at(json, "x-record", "properties", "run_stage"));
    vor_json_free(json);
    vor_text_free(&text);
}
END_TEST

/* The description is what the tables say, parameter by parameter: _i is the process. */
START_TEST(a_process_describes_what_it_takes)
{
    const struct vor_process_info *process = vor_process_info((unsigned)_i);
    size_t inputs = 0;
    struct vor_json *json;

    vor_text_init(&text, 0);
    vor_json_process(&text, process, NULL, 0);
    json = parsed(text.data);
    ck_assert_str_eq(vor_json_get_string(vor_json_get(json, "id")), process->id);
    ck_assert_str_eq(vor_json_get_string(vor_json_get(json, "version")), VOR_VERSION);
    ck_assert_uint_eq(vor_json_count(vor_json_get(json, "jobControlOptions")), 3);
    for (; process->inputs[inputs].name != NULL; inputs++)
        ck_assert_ptr_nonnull(at(json, "inputs", process->inputs[inputs].name, "schema"));
    for (int i = 0; process->outputs[i].name != NULL; i++)
        ck_assert_ptr_nonnull(at(json, "outputs", process->outputs[i].name, "schema"));
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        struct vor_parameter_info row = vor_process_parameter(process, (enum vor_parameter)i);
        const struct vor_parameter_info *info = &row;
        const struct vor_json *schema = at(json, "inputs", info->name, "schema");
        const struct vor_json *range = vor_json_first(vor_json_get(schema, "oneOf"));
        double number = NAN;

        ck_assert_int_eq(schema != NULL, vor_process_takes(process, (enum vor_parameter)i));
        if (schema == NULL)
            continue;
        inputs++;
        if (vor_kind_form(info->kind, 0) == VOR_FORM_CHOICE) {
            const struct vor_json *words = range != NULL ? range : schema;

            ck_assert_str_eq(vor_json_get_string(vor_json_get(words, "type")), "string");
            ck_assert_uint_ge(vor_json_count(vor_json_get(words, "enum")), 1);
            continue;
        }
        if (info->kind == VOR_KIND_LIST) {
            ck_assert_str_eq(vor_json_get_string(vor_json_get(schema, "type")), "array");
            ck_assert_uint_ge(vor_json_count(vor_json_get(vor_json_get(schema, "items"), "enum")),
                              1);
            continue;
        }
        if (info->kind == VOR_KIND_FLAG) {
            ck_assert_str_eq(vor_json_get_string(vor_json_get(schema, "type")), "boolean");
            continue;
        }
        range = range != NULL ? range : schema;
        if (vor_kind_form(info->kind, 0) == VOR_FORM_COUNTS)
            range = vor_json_get(range, "items");
        ck_assert(vor_json_get_number(vor_json_get(range, "minimum"), &number));
        ck_assert_double_eq(number, info->min);
        ck_assert(vor_json_get_number(vor_json_get(range, "maximum"), &number));
        ck_assert_double_eq(number, info->max);
        ck_assert_str_eq(vor_json_get_string(vor_json_get(range, "type")),
                         vor_kind_form(info->kind, 0) == VOR_FORM_REAL ? "number" : "integer");
    }
    ck_assert_uint_eq(vor_json_count(vor_json_get(json, "inputs")), inputs);
    vor_json_free(json);
    vor_text_free(&text);
}
END_TEST

START_TEST(a_description_has_units_and_defaults)
{
    struct vor_json *json;

    vor_text_init(&text, 0);
    vor_json_process(&text, vor_process_find("resample"), NULL, 0);
    json = parsed(text.data);
    ck_assert_double_eq(number_at(json, "polish", "default"), 100);
    ck_assert_double_eq(number_at(json, "seed", "default"), 1);
    ck_assert_str_eq(
        vor_json_get_string(vor_json_get(at(json, "inputs", "seconds", "schema"), "x-unit")), "s");
    ck_assert_str_eq(
        vor_json_get_string(vor_json_get(at(json, "inputs", "quantization", "schema"), "default")),
        "auto");
    vor_json_free(json);
    vor_text_free(&text);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("json_request");

    vt_add_loop(suite, every_request_comes_back, 10);
    vt_add(suite, a_vector_comes_back_with_its_text);
    vt_add_loop(suite, a_wrong_member_is_named_and_nothing_is_set,
                (int)(sizeof refused / sizeof refused[0]));
    vt_add_loop(suite, a_process_describes_its_preset, 4);
    vt_add_loop(suite, a_process_describes_the_documents_that_it_gives, 5);
    vt_add_loop(suite, a_process_describes_what_it_takes, 5);
    vt_add(suite, a_description_has_units_and_defaults);
    return vt_run(suite);
}
