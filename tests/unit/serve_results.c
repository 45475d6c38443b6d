/* The outputs of a job over HTTP, by name. HTTP does not start a job of measure, which takes two
 * clouds: the worker makes it, and a daemon has it. */
#include "proto/json/json.h"
#include "server/base/log.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"
#include "tests/support/vt_serve.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A job of measure that is over, and a daemon that has it. */
struct measured {
    struct vt_serve serve;
    struct vor_uuid id;
    struct vor_job_view view;
    uint8_t *document;
    size_t size;
};

static void make_job(struct measured *measured, const char *dir)
{
    struct vor_cloud cloud, reference;
    struct vt_input inputs[] = {{"cloud", &cloud}, {"reference", &reference}, {NULL, NULL}};
    struct vt_daemon daemon;
    struct vor_spec spec;

    vt_cloud_sphere(&cloud, 1, 200);
    vt_cloud_sphere(&reference, 2, 300);
    vor_spec_preset(&spec, vor_process_find("measure"));
    vt_daemon_start(&daemon, dir, NULL);
    ck_assert_int_eq(vt_daemon_submit_inputs(&daemon, inputs, &spec, &measured->id), VOR_DONE);
    measured->view = vt_daemon_wait_over(&daemon, &measured->id);
    ck_assert_int_eq(measured->view.status, VOR_JOB_SUCCESSFUL);
    measured->document = vt_daemon_output(&daemon, &measured->id, "measure", &measured->size);
    vt_daemon_stop(&daemon);
    vor_cloud_free(&cloud);
    vor_cloud_free(&reference);
}

static void begin(struct measured *measured)
{
    const char *dir;

    dir = vt_dir_make();
    make_job(measured, dir);
    vt_serve_start(&measured->serve, dir);
}

static void end(struct measured *measured)
{
    ck_assert_int_eq(vt_serve_stop(&measured->serve), 0);
    free(measured->document);
}

/* METHOD of the job and what follows it in its path. */
static int call(struct measured *measured, const char *method, const char *path,
                const char *headers, const char **text)
{
    char line[256];

    (void)snprintf(line, sizeof line, "%s /v1/jobs/%s%s", method, measured->id.text, path);
    return vt_serve_call(&measured->serve, line, headers, text);
}

static const char *body_of(const char *text)
{
    const char *end = strstr(text, "\r\n\r\n");

    ck_assert_ptr_nonnull(end);
    return end + 4;
}

static struct vor_json *json_of(const char *text)
{
    struct vor_json *json = NULL;

    vt_assert_ok(vor_json_parse(&json, body_of(text), strlen(body_of(text)), &vt_err));
    return json;
}

static void expect_header(const char *text, const char *header)
{
    const char *at = strstr(text, header);

    ck_assert_msg(at != NULL && at < body_of(text), "no %s in %.600s", header, text);
}

static void expect_text(const struct vor_json *object, const char *name, const char *wanted)
{
    const char *text = vor_json_get_string(vor_json_get(object, name));

    ck_assert_msg(text != NULL && strcmp(text, wanted) == 0, "%s is %s", name,
                  text != NULL ? text : "not there");
}

/* "http://127.0.0.1:PORT/v1/jobs/ID/results/measure", by its end. */
static void expect_address(const struct vor_json *object, const char *name)
{
    static const char wanted[] = "/results/measure";
    const char *text = vor_json_get_string(vor_json_get(object, name));

    ck_assert_ptr_nonnull(text);
    ck_assert_uint_gt(strlen(text), sizeof wanted);
    ck_assert_str_eq(text + strlen(text) - strlen(wanted), wanted);
}

START_TEST(a_document_is_served_as_any_output)
{
    struct measured measured;
    char header[256];
    const char *text;

    begin(&measured);
    ck_assert_int_eq(call(&measured, "GET", "/results/measure", "", &text), 200);
    ck_assert_str_eq(body_of(text), (char *)measured.document);
    expect_header(text, "Content-Type: application/json");
    expect_header(text, "Accept-Ranges: bytes");
    (void)snprintf(header, sizeof header, "ETag: \"%s\"", measured.view.output[0].sha256);
    expect_header(text, header);
    (void)snprintf(header, sizeof header, "Content-Disposition: attachment; filename=\"%s.json\"",
                   measured.id.text);
    expect_header(text, header);

    ck_assert_int_eq(call(&measured, "HEAD", "/results/measure", "", &text), 200);
    (void)snprintf(header, sizeof header, "Content-Length: %zu", measured.size);
    expect_header(text, header);
    ck_assert_str_eq(body_of(text), "");
    ck_assert_int_eq(call(&measured, "GET", "/results/measure", "Range: bytes=0-4\r\n", &text),
                     206);
    ck_assert_str_eq(body_of(text), "{\"n\":");
    (void)snprintf(header, sizeof header, "If-None-Match: \"%s\"\r\n",
                   measured.view.output[0].sha256);
    ck_assert_int_eq(call(&measured, "GET", "/results/measure", header, NULL), 304);
    end(&measured);
}
END_TEST

START_TEST(the_results_of_a_process_are_its_outputs_and_no_others)
{
    static const char *const others[] = {"cloud", "report", "measur", "measures", "input"};
    const struct vor_json *output;
    struct measured measured;
    struct vor_json *json;
    const char *text;
    char path[64];

    begin(&measured);
    ck_assert_int_eq(call(&measured, "GET", "/results", "", &text), 200);
    json = json_of(text);
    ck_assert_uint_eq(vor_json_count(json), 1);
    output = vor_json_get(json, "measure");
    expect_address(output, "href");
    expect_text(output, "type", "application/json");
    vor_json_free(json);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        (void)snprintf(path, sizeof path, "/results/%s", others[i]);
        ck_assert_int_eq(call(&measured, "GET", path, "", &text), 404);
        ck_assert_ptr_nonnull(strstr(text, "/no-such-output\""));
        (void)snprintf(path, sizeof path, "there is no output %s, want measure\"", others[i]);
        ck_assert_ptr_nonnull(strstr(text, path));
    }
    end(&measured);
}
END_TEST

START_TEST(a_job_tells_its_inputs_and_where_its_outputs_are)
{
    const struct vor_json *inputs, *link;
    struct measured measured;
    struct vor_json *json;
    const char *text;
    double number;
    int items = 0;

    begin(&measured);
    ck_assert_int_eq(call(&measured, "GET", "", "", &text), 200);
    json = json_of(text);
    inputs = vor_json_get(vor_json_get(json, "voronoid"), "inputs");
    ck_assert_uint_eq(vor_json_count(inputs), 2);
    ck_assert(vor_json_get_number(vor_json_get(vor_json_get(inputs, "cloud"), "points"), &number));
    ck_assert_double_eq(number, 200);
    ck_assert(
        vor_json_get_number(vor_json_get(vor_json_get(inputs, "reference"), "points"), &number));
    ck_assert_double_eq(number, 300);
    ck_assert_ptr_null(vor_json_get(vor_json_get(json, "voronoid"), "target"));
    for (link = vor_json_first(vor_json_get(json, "links")); link != NULL;
         link = vor_json_next(link)) {
        const char *title = vor_json_get_string(vor_json_get(link, "title"));

        if (strcmp(vor_json_get_string(vor_json_get(link, "rel")), "item") != 0)
            continue;
        items++;
        ck_assert_str_eq(title, "measure");
        expect_text(link, "type", "application/json");
        ck_assert(vor_json_get_number(vor_json_get(link, "length"), &number));
        ck_assert_double_eq(number, (double)measured.size);
    }
    ck_assert_int_eq(items, 1);
    vor_json_free(json);
    end(&measured);
}
END_TEST

/* Its END has the address of the main output, no report, and all outputs by name. */
START_TEST(the_events_of_a_job_without_a_report_end_with_its_outputs)
{
    struct measured measured;
    struct vor_json *json = NULL;
    const char *text, *data;

    begin(&measured);
    ck_assert_int_eq(call(&measured, "GET", "/events", "Last-Event-ID: 1.1\r\n", &text), 200);
    data = strstr(text, "event: end");
    data = strstr(data != NULL ? data : "", "data: ");
    ck_assert_ptr_nonnull(data);
    data += strlen("data: ");
    vt_assert_ok(vor_json_parse(&json, data, strcspn(data, "\n"), &vt_err));
    expect_text(json, "status", "successful");
    expect_address(json, "href");
    ck_assert_ptr_null(vor_json_get(json, "report"));
    ck_assert_uint_eq(vor_json_count(vor_json_get(json, "outputs")), 1);
    expect_address(vor_json_get(json, "outputs"), "measure");
    vor_json_free(json);
    ck_assert_int_eq(call(&measured, "GET", "/trace", "", &text), 200);
    ck_assert_ptr_nonnull(strstr(text, "\"records\":[]"));
    end(&measured);
}
END_TEST

START_TEST(a_job_is_deleted_with_all_its_bytes)
{
    struct measured measured;

    begin(&measured);
    ck_assert_int_eq(call(&measured, "DELETE", "", "", NULL), 200);
    ck_assert_int_eq(call(&measured, "GET", "/results/measure", "", NULL), 404);
    ck_assert_int_eq(vt_dir_count(measured.serve.dir, "blobs/keep"), 0);
    end(&measured);
}
END_TEST

START_TEST(a_process_of_several_inputs_is_started_over_http_as_any_other)
{
    static const char *const lines[] = {"POST /v1/measure", "POST /v1/processes/measure/execution"};
    struct measured measured;
    const char *text;

    begin(&measured);
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        ck_assert_int_eq(vt_serve_call(&measured.serve, lines[i], "", &text), 422);
        ck_assert_ptr_nonnull(strstr(text, "empty-cloud"));
    }
    ck_assert_int_eq(vt_serve_call(&measured.serve, "GET /v1/processes/measure", "", &text), 200);
    ck_assert_ptr_nonnull(strstr(text, "\"reference\""));
    end(&measured);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("serve_results");

    vor_log_open(2, VOR_LOG_ERROR);
    vt_add(suite, a_document_is_served_as_any_output);
    vt_add(suite, the_results_of_a_process_are_its_outputs_and_no_others);
    vt_add(suite, a_job_tells_its_inputs_and_where_its_outputs_are);
    vt_add(suite, the_events_of_a_job_without_a_report_end_with_its_outputs);
    vt_add(suite, a_job_is_deleted_with_all_its_bytes);
    vt_add(suite, a_process_of_several_inputs_is_started_over_http_as_any_other);
    return vt_run(suite);
}
