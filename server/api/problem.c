#include "server/api/problem.h"

#include "server/api/accept.h"
#include "server/api/route_table.h"
#include "server/base/disk.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define OGC "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/"

struct problem_row {
    const char *slug;
    int http, retryable, is_ogc;
    const char *title;
};

static const struct problem_row rows[] = {
#define PROBLEM_ROW(slug, http, retryable, ogc, title) {slug, http, retryable, ogc, title},
    VOR_PROBLEM_TABLE(PROBLEM_ROW)
#undef PROBLEM_ROW
#define STATUS_ROW(name, http, slug, retryable, sentence)                                          \
    {slug, http, retryable, VOR_##name == VOR_E_PARAM, sentence},
        VOR_STATUS_TABLE(STATUS_ROW)
#undef STATUS_ROW
};

enum { ROW_COUNT = sizeof rows / sizeof rows[0] };

static const unsigned retry_seconds = 5; /* where a problem does not say how long */

static const struct problem_row *find_row(const char *slug, size_t length)
{
    for (int i = 0; i < ROW_COUNT; i++)
        if (strlen(rows[i].slug) == length && memcmp(rows[i].slug, slug, length) == 0)
            return &rows[i];
    return NULL;
}

void vor_problem_write(const struct vor_request *request, const struct vor_problem *problem,
                       struct vor_text *text)
{
    const struct problem_row *row = find_row(problem->slug, strlen(problem->slug));
    const struct vor_problem_error own = {.parameter = problem->parameter};
    bool has_own = problem->parameter != NULL && problem->parameter[0] != '\0';
    const struct vor_problem_error *errors = has_own ? &own : problem->errors;
    size_t count = has_own ? 1 : problem->error_count;
    char path[96], type[VOR_URL_MAX];

    assert(row != NULL);
    vor_json_begin_object(text);
    (void)snprintf(path, sizeof path, "/problems/%s", row->slug);
    if (row->is_ogc)
        (void)snprintf(type, sizeof type, OGC "%s", row->slug);
    else
        (void)vor_app_url(request, path, type);
    vor_json_put_string(text, "type", type);
    vor_json_put_string(text, "title", row->title);
    vor_json_put_i64(text, "status", row->http);
    vor_json_put_given(text, "detail", problem->detail);
    if (problem->job_id != NULL)
        (void)snprintf(path, sizeof path, "/v1/jobs/%s", problem->job_id);
    else
        (void)snprintf(path, sizeof path, "urn:request:%s", request->id);
    vor_json_put_string(text, "instance", path);
    vor_json_put_bool(text, "retryable", row->retryable);
    vor_json_put_given(text, "requestId", problem->is_of_job ? NULL : request->id);
    vor_json_put_given(text, "jobID", problem->job_id);
    if (problem->attempt > 0)
        vor_json_put_u64(text, "attempt", problem->attempt);
    if (problem->limit > 0) {
        vor_json_put_u64(text, "limit", problem->limit);
        vor_json_put_u64(text, "got", problem->got);
    }
    if (problem->byte_offset >= 0)
        vor_json_put_i64(text, "byteOffset", problem->byte_offset);
    if (problem->queue_depth >= 0)
        vor_json_put_i64(text, "queueDepth", problem->queue_depth);
    if (count > 0)
        vor_json_put_array(text, "errors");
    for (size_t i = 0; i < count; i++) {
        vor_json_begin_object(text);
        vor_json_put_given(text, "pointer", errors[i].pointer);
        vor_json_put_given(text, "parameter", errors[i].parameter);
        vor_json_put_given(text, "detail", errors[i].detail);
        vor_json_end_object(text);
    }
    if (count > 0)
        vor_json_end_array(text);
    vor_json_end_object(text);
}

enum vor_next vor_problem_reply(struct vor_request *request, const struct vor_problem *problem)
{
    const struct problem_row *row = find_row(problem->slug, strlen(problem->slug));
    struct vor_text text;
    char seconds[16];

    assert(row != NULL);
    vor_text_init(&text, 0);
    vor_problem_write(request, problem, &text);
    vor_text_puts(&text, "\n");
    request->problem = problem->slug;
    (void)snprintf(seconds, sizeof seconds, "%u",
                   problem->retry_seconds > 0 ? problem->retry_seconds : retry_seconds);
    vor_reply_header(request, "Retry-After", row->retryable ? seconds : NULL);
    vor_reply_header(request, "Allow", problem->allow);
    vor_reply_header(request, "WWW-Authenticate", problem->challenge);
    vor_reply_header(request, "Cache-Control", "no-store");
    /* A strict client of OGC's standard that asks for application/json takes nothing else. */
    vor_reply_bytes(request, row->http,
                    vor_accepts(request, "application/json") &&
                            !vor_accepts(request, "application/problem+json")
                        ? "application/json"
                        : "application/problem+json",
                    text.data, text.failed ? 0 : text.size);
    vor_text_free(&text);
    return VOR_NEXT_REPLY;
}

enum vor_next vor_problem_say(struct vor_request *request, const char *slug, const char *format,
                              ...)
{
    char detail[512];
    va_list args;

    va_start(args, format);
    (void)vsnprintf(detail, sizeof detail, format, args);
    va_end(args);
    return vor_problem_reply(request, &VOR_PROBLEM(slug, .detail = detail));
}

void vor_problem_of_error(const struct vor_error *err, const char *job_id,
                          struct vor_problem *problem)
{
    *problem = VOR_PROBLEM(vor_status_slug(err->status));
    if (err->status == VOR_E_IO)
        problem->slug = vor_error_storage_full(err)      ? "storage-full"
                        : vor_error_storage_refused(err) ? "storage-refused"
                                                         : "store-unavailable";
    problem->detail = err->message;
    problem->parameter = err->parameter;
    problem->job_id = job_id;
    problem->byte_offset = err->byte_offset;
    if (err->status != VOR_E_IO) {
        problem->limit = err->limit;
        problem->got = err->got;
    }
}

enum vor_next vor_problem_error(struct vor_request *request, const struct vor_error *err,
                                const char *job_id)
{
    struct vor_problem problem;

    vor_problem_of_error(err, job_id, &problem);
    return vor_problem_reply(request, &problem);
}

enum vor_next vor_problem_no_memory(struct vor_request *request)
{
    struct vor_error err;

    (void)vor_fail(&err, VOR_E_NOMEM, "a request");
    return vor_problem_error(request, &err, NULL);
}

enum vor_next vor_problem_or_wait(struct vor_request *request)
{
    if (vor_request_gone(request))
        return vor_problem_say(request, "client-closed", "the client disconnected");
    if (vor_request_closing(request))
        return vor_problem_say(request, "draining", "the daemon is shutting down");
    return VOR_NEXT_WAIT;
}

enum vor_next vor_app_reply(struct vor_request *request, int http, const char *media_type,
                            struct vor_text *text)
{
    struct vor_error err;

    if (vor_text_status(text, &err) != VOR_OK)
        vor_problem_error(request, &err, NULL);
    else
        vor_reply_bytes(request, http, media_type, text->data, text->size);
    vor_text_free(text);
    return VOR_NEXT_REPLY;
}

enum vor_next vor_reply_json(struct vor_request *request, int http, struct vor_text *text)
{
    vor_text_puts(text, "\n");
    return vor_app_reply(request, http, "application/json", text);
}

void vor_document_begin(struct vor_text *text)
{
    vor_text_init(text, 0);
    vor_json_begin_object(text);
}

enum vor_next vor_document_reply(struct vor_request *request, struct vor_text *text)
{
    vor_json_end_object(text);
    return vor_reply_json(request, 200, text);
}

void vor_problem_of_job(const struct vor_job_view *row, struct vor_problem *problem)
{
    vor_problem_of_error(&row->problem, row->id.text, problem);
    problem->attempt = row->attempt;
}

enum vor_next vor_handle_problem(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    const char *slug;
    size_t length = vor_path_segment(request->path, 1, &slug);
    const struct problem_row *row = find_row(slug, length);
    struct vor_text text;

    if (row == NULL || row->http == 200)
        return vor_problem_say(request, "no-such-resource", "no problem has this name");
    vor_text_init(&text, 0);
    vor_text_printf(&text, "%s (HTTP %d)\n\n%s.\n%s\n", row->slug, row->http, row->title,
                    row->retryable ? "The same request may succeed later."
                                   : "The same request will fail again.");
    return vor_app_reply(request, 200, "text/plain; charset=utf-8", &text);
}
