/* Requests as JSON, read back as they were written; and the descriptions of the processes. */
#include "proto/json/json.h"
#include "tests/support/vt.h"

#include <string.h>

static struct vor_text text;

VT_TEST(a_vector_comes_back_with_its_text)
{
    static const char *const texts[] = {"637000,849000,0", "+1e3,-0.5,.25", "0,0,0"};

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
        json = vt_json(text.data);
        vt_assert_ok(vor_json_spec_read(&back, json, &vt_err));
        ck_assert_mem_eq(&back, &spec, sizeof spec);
        ck_assert_str_eq(vor_spec_name(&back, VOR_PARAM_ORIGIN), texts[i]);
        vt_assert_ok(vor_spec_set(&back, "origin", "auto", &vt_err));
        ck_assert(!vor_spec_vector(&back, VOR_PARAM_ORIGIN, numbers));
        ck_assert_ptr_null(vor_spec_name(&back, VOR_PARAM_ORIGIN));
        vor_json_free(json);
        vor_text_free(&text);
    }
}

static const struct vor_json *at(const struct vor_json *json, const char *a, const char *b,
                                 const char *c)
{
    return vor_json_get(vor_json_get(vor_json_get(json, a), b), c);
}

/* A cloud has no members; the schema of a document names all of its own. _i is the process. */
VT_TEST_LOOP(a_process_describes_the_documents_that_it_gives, 5)
{
    const struct vor_process_info *process = vor_process_info((unsigned)_i);
    struct vor_json *json;

    vor_text_init(&text, 0);
    vor_json_process(&text, process, NULL, 0);
    json = vt_json(text.data);
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

/* Each parameter by itself: spec_table. _i is the process. */
VT_TEST_LOOP(a_process_describes_what_it_takes, 5)
{
    const struct vor_process_info *process = vor_process_info((unsigned)_i);
    size_t inputs = 0;
    struct vor_json *json;

    vor_text_init(&text, 0);
    vor_json_process(&text, process, NULL, 0);
    json = vt_json(text.data);
    ck_assert_str_eq(vor_json_get_string(vor_json_get(json, "id")), process->id);
    ck_assert_str_eq(vor_json_get_string(vor_json_get(json, "version")), VOR_VERSION);
    ck_assert_uint_eq(vt_json_count(vor_json_get(json, "jobControlOptions")), 3);
    for (; process->inputs[inputs].name != NULL; inputs++)
        ck_assert_ptr_nonnull(at(json, "inputs", process->inputs[inputs].name, "schema"));
    for (int i = 0; process->outputs[i].name != NULL; i++)
        ck_assert_ptr_nonnull(at(json, "outputs", process->outputs[i].name, "schema"));
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++)
        inputs += (size_t)vor_process_takes(process, (enum vor_parameter)i);
    ck_assert_uint_eq(vt_json_count(vor_json_get(json, "inputs")), inputs);
    vor_json_free(json);
    vor_text_free(&text);
}
