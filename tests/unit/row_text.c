/* The parts of a job's row that a store keeps as text: what is written is read, and what another
 * version wrote is read as far as it can be. */
#include "server/store/row_text.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <stdio.h>
#include <string.h>

/* Else a job of another version would run with defaults that nobody asked for. */
VT_TEST(a_request_that_cannot_be_read_is_not_made_up)
{
    static const struct {
        const char *process, *request;
    } cases[] = {{"resample", "{\"points\":\"many\"}"},
                 {"upsample", "{\"points\":\"many\"}"},
                 {"denoise", "{\"ratio\":99}"},
                 {"upsample", "{\"ratio\":0.5}"},
                 {"simplify", "{\"ratio\":2}"},
                 {"upsample", NULL},
                 {"denoise", "{"},
                 {"measure", "{\"peak\":0}"},
                 {"measure", NULL},
                 {"remesh", "{\"points\":50}"},
                 {"", "{\"points\":50}"}};
    struct vor_job_view row;

    memset(&row, 0, sizeof row);
    (void)snprintf(row.process, sizeof row.process, "resample");
    vor_row_read(&row, &(struct vor_row_columns){.request = "{\"points\":50}"});
    vt_assert_ok(vor_spec_check(&row.spec, &vt_err));
    ck_assert(!row.request_lost);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        (void)snprintf(row.process, sizeof row.process, "%s", cases[k].process);
        vor_row_read(&row, &(struct vor_row_columns){.request = cases[k].request});
        ck_assert_msg(row.request_lost, "%s %s", cases[k].process,
                      cases[k].request != NULL ? cases[k].request : "without a request");
    }
}

/* No process has two blobs among its outputs yet: one with three is written, and read as one that
 * has the second of them. What this version does not know is left out. */
VT_TEST(outputs_beside_the_main_one_are_kept_by_name)
{
    static const char kept[] =
        "{\"mesh\":{\"format\":1,\"points\":7,\"bytes\":99,\"sha256\":\"cafe\"},"
        "\"measure\":{\"format\":0,\"points\":0,\"bytes\":12,\"sha256\":\"beef\"}}";
    static const struct vor_process_info process = {
        .inputs = {{"cloud", VOR_ARTEFACT_CLOUD, 1, ""}},
        .outputs = {{"cloud", VOR_ARTEFACT_CLOUD, 1, ""},
                    {"report", VOR_ARTEFACT_DOCUMENT, 1, ""},
                    {"mesh", VOR_ARTEFACT_CLOUD, 1, ""},
                    {"measure", VOR_ARTEFACT_DOCUMENT, 1, ""}}};
    struct vor_job_view row = vt_row(10);
    struct vor_row_text text;

    row.status = VOR_JOB_SUCCESSFUL;
    row.spec.process = &process;
    row.output[2] =
        (struct vor_job_output){.format = 1, .points = 7, .bytes = 99, .sha256 = "cafe"};
    row.output[3] = (struct vor_job_output){.bytes = 12, .sha256 = "beef"};
    vt_assert_ok(vor_row_write(&text, &row, &vt_err));
    ck_assert_str_eq(text.outputs.data, kept);
    vor_row_text_free(&text);
    row.status = VOR_JOB_FAILED;
    vt_assert_ok(vor_row_write(&text, &row, &vt_err));
    ck_assert_ptr_null(text.outputs.data);
    vor_row_text_free(&text);
    memset(&row, 0, sizeof row);
    strcpy(row.process, "resample");
    vor_row_read(&row, &(struct vor_row_columns){
                           .outputs = "{\"mesh\":{\"bytes\":99},\"report\":{\"format\":1,"
                                      "\"points\":7,\"bytes\":12,\"sha256\":\"beef\"}}"});
    ck_assert_uint_eq(row.output[1].format, 1);
    ck_assert_uint_eq(row.output[1].points, 7);
    ck_assert_uint_eq(row.output[1].bytes, 12);
    ck_assert_str_eq(row.output[1].sha256, "beef");
    ck_assert_uint_eq(row.output[2].bytes, 0);
}

/* Of the main output too, whose other members are columns. */
VT_TEST(origins_of_outputs_are_kept_to_the_bit)
{
    static const double origin[3] = {637000.1, -1.0 / 3, 1e-300};
    static const char *const strange[] = {
        "{\"cloud\":{\"origin\":[1,2]}}", "{\"cloud\":{\"origin\":[1,2,null]}}",
        "{\"cloud\":{\"origin\":\"1,2,3\"}}", "{\"cloud\":7}", "[]"};
    struct vor_job_view row = vt_row(10), back;
    struct vor_row_text text;

    row.status = VOR_JOB_SUCCESSFUL;
    row.output[0].has_origin = 1;
    memcpy(row.output[0].origin, origin, sizeof origin);
    vt_assert_ok(vor_row_write(&text, &row, &vt_err));
    memset(&back, 0, sizeof back);
    strcpy(back.process, "resample");
    vor_row_read(&back, &(struct vor_row_columns){.outputs = text.outputs.data});
    ck_assert_int_eq(back.output[0].has_origin, 1);
    ck_assert_mem_eq(back.output[0].origin, origin, sizeof origin);
    vor_row_text_free(&text);
    for (size_t i = 0; i < sizeof strange / sizeof *strange; i++) {
        memset(&back, 0, sizeof back);
        strcpy(back.process, "resample");
        vor_row_read(&back, &(struct vor_row_columns){.outputs = strange[i]});
        ck_assert_msg(!back.output[0].has_origin, "%s", strange[i]);
    }
}
