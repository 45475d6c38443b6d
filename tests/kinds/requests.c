/* Requests with parameters of every kind, by tables that have rows of the tests' own: the texts of
 * a request, and what a process describes; that text and JSON say the same: table.c. No file of the
 * product knows these rows. */
#include "proto/json/json.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static struct vor_spec request(void)
{
    struct vor_spec spec;

    ck_assert_ptr_nonnull(vor_process_find("kinds"));
    vor_spec_preset(&spec, vor_process_find("kinds"));
    return spec;
}

/* The request as JSON (static storage). */
static const char *written(const struct vor_spec *spec)
{
    static char kept[4096];
    struct vor_text text;

    vor_text_init(&text, 0);
    vor_json_spec(&text, spec);
    vt_assert_ok(vor_text_status(&text, &vt_err));
    vt_assert_ok(vor_json_scan(text.data, text.size, &vt_err));
    ck_assert_uint_lt(text.size, sizeof kept);
    memcpy(kept, text.data, text.size + 1);
    vor_text_free(&text);
    return kept;
}

static void read_json(struct vor_spec *spec, const char *text)
{
    struct vor_json *json = vt_json(text);

    vt_assert_ok(vor_json_spec_read(spec, json, &vt_err));
    vor_json_free(json);
}

VT_TEST(every_kind_is_read_from_json_and_written_back)
{
    static const char text[] =
        "{\"label\":\"a \\\"b\\\" \xc3\xa9\",\"closed\":false,\"sieves\":[\"mls\",\"thin\"],"
        "\"weight\":\"attribute:a,b:c\",\"title\":\"\",\"rungs\":[],\"angle\":45.5,\"reach\":0}";
    struct vor_spec spec = request(), back = request();

    read_json(&spec, text);
    ck_assert_str_eq(vor_spec_name(&spec, VOR_PARAM_LABEL), "a \"b\" \xc3\xa9");
    ck_assert(spec.value[VOR_PARAM_CLOSED] == 0);
    ck_assert(spec.value[VOR_PARAM_SIEVES] == 5);
    ck_assert(vor_list_has(spec.value[VOR_PARAM_SIEVES], 2));
    ck_assert(!vor_list_has(spec.value[VOR_PARAM_SIEVES], 1));
    ck_assert_str_eq(vor_spec_name(&spec, VOR_PARAM_WEIGHT), "a,b:c");
    ck_assert_str_eq(vor_spec_name(&spec, VOR_PARAM_TITLE), "");
    ck_assert(spec.value[VOR_PARAM_RUNGS] == 0);
    ck_assert(spec.value[VOR_PARAM_ANGLE] == 45.5);
    ck_assert_ptr_null(vor_spec_name(&spec, VOR_PARAM_ANGLE));
    read_json(&back, written(&spec));
    ck_assert_mem_eq(&spec, &back, sizeof spec);
}

/* In whatever order texts are set, and however often, equal requests are equal bytes. */
VT_TEST_LOOP(texts_lie_in_the_order_of_the_parameters, 6)
{
    static const char *const names[3] = {"label", "weight", "title"};
    static const char *const texts[3] = {"one", "attribute:two", "three"};
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                     {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    struct vor_spec wanted = request(), spec = request();

    for (int i = 0; i < 3; i++)
        vt_assert_ok(vor_spec_set(&wanted, names[i], texts[i], &vt_err));
    for (int i = 0; i < 3; i++)
        vt_assert_ok(
            vor_spec_set(&spec, names[orders[_i][i]], "attribute:longer than before", &vt_err));
    for (int i = 0; i < 3; i++)
        vt_assert_ok(vor_spec_set(&spec, names[orders[_i][i]], texts[orders[_i][i]], &vt_err));
    ck_assert_mem_eq(&spec, &wanted, sizeof spec);
    ck_assert_str_eq(vor_spec_name(&spec, VOR_PARAM_LABEL), "one");
    ck_assert_str_eq(vor_spec_name(&spec, VOR_PARAM_WEIGHT), "two");
    ck_assert_str_eq(vor_spec_name(&spec, VOR_PARAM_TITLE), "three");
    vt_assert_ok(vor_spec_set(&spec, "weight", "even", &vt_err));
    ck_assert_ptr_null(vor_spec_name(&spec, VOR_PARAM_WEIGHT));
    ck_assert_str_eq(vor_spec_name(&spec, VOR_PARAM_TITLE), "three");
}

/* 300 bytes for one, 511 for all with a NUL each: the last byte fits, the next one does not. */
VT_TEST(texts_fit_into_a_request_or_are_refused)
{
    struct vor_spec spec = request(), before;
    char text[VOR_SPEC_TEXTS_SIZE];
    const size_t left = VOR_SPEC_TEXTS_SIZE - 301 - 1;

    memset(text, 'x', sizeof text);
    text[300] = '\0';
    vt_assert_ok(vor_spec_set(&spec, "label", text, &vt_err));
    text[left] = '\0';
    vt_assert_ok(vor_spec_set(&spec, "title", text, &vt_err));
    ck_assert_uint_eq(strlen(vor_spec_name(&spec, VOR_PARAM_TITLE)), left);
    before = spec;
    text[left] = 'x';
    text[left + 1] = '\0';
    vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, "title", text, &vt_err));
    ck_assert_str_eq(
        vt_err.message,
        "title has 211 bytes, want at most 512 in all text values of the request together");
    ck_assert_str_eq(vt_err.parameter, "title");
    ck_assert_mem_eq(&spec, &before, sizeof spec);
    vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, "weight", "attribute:a", &vt_err));
    ck_assert_str_eq(vt_err.parameter, "weight");
    ck_assert_mem_eq(&spec, &before, sizeof spec);
    vt_assert_ok(vor_spec_set(&spec, "label", "short", &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "weight", "attribute:a", &vt_err));
}

/* The schema of an input of the description, in one line (static storage). */
static const char *schema(const char *name)
{
    static char kept[1024];
    struct vor_text text, part;
    struct vor_json *json;

    vor_text_init(&text, 0);
    vor_text_init(&part, 0);
    vor_json_process(&text, vor_process_find("kinds"), NULL, 0);
    json = vt_json(text.data);
    vor_json_copy(&part, vor_json_get(vor_json_get(vor_json_get(json, "inputs"), name), "schema"));
    ck_assert_uint_lt(part.size, sizeof kept);
    memcpy(kept, part.data, part.size + 1);
    vor_json_free(json);
    vor_text_free(&text);
    vor_text_free(&part);
    return kept;
}

static const struct {
    const char *name, *schema;
} schemas[] = {
    {"label", "{\"type\":\"string\",\"minLength\":1,\"maxLength\":300}"},
    {"title", "{\"type\":\"string\",\"minLength\":0,\"maxLength\":300}"},
    {"closed", "{\"type\":\"boolean\",\"default\":true}"},
    {"sieves", "{\"type\":\"array\",\"uniqueItems\":true,\"items\":{\"type\":\"string\",\"enum\":["
               "\"mls\",\"outliers\",\"thin\"]},\"default\":[\"outliers\"]}"},
    {"weight", "{\"oneOf\":[{\"type\":\"string\",\"enum\":[\"even\"]},{\"type\":\"string\","
               "\"pattern\":\"^(attribute):.{1,200}$\"}],\"default\":\"even\"}"},
    {"rungs", "{\"oneOf\":[{\"type\":\"array\",\"uniqueItems\":true,\"items\":{\"type\":\"string\","
              "\"enum\":[\"up\",\"down\"]}},{\"type\":\"string\",\"enum\":[\"auto\"]}],"
              "\"default\":\"auto\"}"},
    {"angle", "{\"oneOf\":[{\"type\":\"number\",\"minimum\":0,\"maximum\":90},{\"type\":\"string\","
              "\"enum\":[\"mean\",\"max\"]}],\"default\":\"mean\",\"x-unit\":\"degrees\"}"},
    {"reach", "{\"oneOf\":[{\"type\":\"number\",\"minimum\":0,\"maximum\":1},{\"type\":\"string\","
              "\"enum\":[\"auto\"]}],\"default\":\"auto\"}"},
    {"method", "{\"type\":\"string\",\"enum\":[\"cvt\",\"slower\"],\"default\":\"cvt\"}"},
};

VT_TEST_LOOP(a_kind_has_its_schema, (int)(sizeof schemas / sizeof schemas[0]))
{
    ck_assert_str_eq(schema(schemas[_i].name), schemas[_i].schema);
}

VT_TEST(inputs_that_are_required_or_needed_must_come_along)
{
    struct vor_spec spec = request();

    vt_assert_fails(VOR_E_PARAM, vor_spec_check_inputs(&spec, 1, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "second");
    vt_assert_ok(vor_spec_check_inputs(&spec, 3, &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "title", "of the third", &vt_err));
    vt_assert_fails(VOR_E_PARAM, vor_spec_check_inputs(&spec, 3, &vt_err));
    ck_assert_str_eq(
        vt_err.message,
        "the parameter title is of the third, which needs a third cloud, but the request has none");
    vt_assert_ok(vor_spec_check_inputs(&spec, 7, &vt_err));
}

/* What the product asks of its requests does not change by rows that it does not know. */
VT_TEST(other_processes_do_not_take_the_new_rows)
{
    struct vor_spec spec;

    vor_spec_init(&spec);
    vt_assert_fails(VOR_E_PARAM, vor_spec_set(&spec, "label", "x", &vt_err));
    ck_assert_ptr_null(strstr(vt_err.message, "weight"));
    ck_assert_ptr_null(strstr(written(&spec), "closed"));
    ck_assert(vor_spec_form(&spec, VOR_PARAM_REACH) == VOR_FORM_NONE);
    ck_assert(spec.value[VOR_PARAM_REACH] == 0.25); /* the table's default, for whatever runs */
    vt_assert_ok(vor_spec_set(&spec, "method", "slow", &vt_err));
    ck_assert(spec.value[VOR_PARAM_METHOD] == VOR_METHOD_SLOW);
}
