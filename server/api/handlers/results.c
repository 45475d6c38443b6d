#include "proto/codec.h"
#include "proto/origin.h"
#include "server/api/handlers/handlers.h"
#include "server/api/handlers/range.h"
#include "server/api/links.h"
#include "server/api/problem.h"
#include "server/base/digest.h"
#include "server/base/result_name.h"
#include "server/blob/blob.h"
#include "server/work/fetch.h"
#include "server/work/verify.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* One output, ready to be sent whole or in part: bytes in memory, or a file. */
struct output {
    const char *media_type;
    char name[VOR_RESULT_NAME_SIZE]; /* file name for Content-Disposition */
    char etag[VOR_ETAG_SIZE];
    char origin[VOR_ORIGIN_TEXT_SIZE]; /* of a cloud that has one; else "" */
    uint64_t size;
    char *bytes;           /* owned; NULL for a file */
    int fd;                /* owned until sent; -1 for none */
    struct vor_flow *flow; /* of a file that is not here yet; owned until sent; NULL for none */
};

static enum vor_next say_with_job(struct vor_request *request, const char *slug, const char *detail,
                                  const char *job_id)
{
    return vor_problem_reply(request, &VOR_PROBLEM(slug, .detail = detail, .job_id = job_id));
}

enum vor_next vor_result_missing(struct vor_request *request, const struct vor_job_view *view)
{
    struct vor_problem problem;

    if (view->expired)
        return say_with_job(request, "job-expired",
                            "the results of this job have expired, or were deleted to free space",
                            view->id.text);
    switch (view->status) {
    case VOR_JOB_FAILED:
        vor_problem_of_job(view, &problem);
        return vor_problem_reply(request, &problem);
    case VOR_JOB_DISMISSED:
        return say_with_job(request, "result-not-available", "the job was dismissed",
                            view->id.text);
    case VOR_JOB_ACCEPTED:
    case VOR_JOB_RUNNING:
        return say_with_job(request, "result-not-ready", "the job has not ended yet",
                            view->id.text);
    case VOR_JOB_SUCCESSFUL:
    case VOR_JOB_STATUSES:
        break;
    }
    return say_with_job(request, "result-not-available", "the job no longer has this file",
                        view->id.text);
}

/* Opens a blob of a job, unless it flows; false after a problem has been replied, that of `missing`
 * where there is none. */
static bool open_blob(struct vor_request *request, const struct vor_job_view *view,
                      const char *name,
                      enum vor_next (*missing)(struct vor_request *, const struct vor_job_view *),
                      struct output *out)
{
    struct vor_error err;
    int found = out->flow != NULL;

    if (!found && vor_blob_get(request->app->blobs, &view->id, name, &out->fd, &out->size, &found,
                               &err) != VOR_OK)
        return vor_problem_error(request, &err, view->id.text);
    if (!found)
        missing(request, view);
    return found != 0;
}

static void name_file(const struct vor_job_view *view, unsigned index,
                      const struct vor_format *format, struct output *out)
{
    const struct vor_artefact_info *output = &view->spec.process->outputs[index];

    vor_result_name(out->name, view->name, view->id.text, view->spec.process->id, output->name,
                    output->kind == VOR_ARTEFACT_CLOUD ? format->suffix : ".json");
}

/* Output number `index` of a successful job; false after a problem has been replied. */
static bool open_output(struct vor_request *request, const struct vor_job_view *view,
                        unsigned index, struct output *out)
{
    char blob[VOR_BLOB_NAME_MAX + 1];

    out->media_type = vor_output_media_type(view, index);
    if (out->media_type == NULL)
        return vor_result_missing(request, view);
    name_file(view, index, vor_format(view->output[index].format), out);
    if (vor_output_in_row(&view->spec.process->outputs[index])) {
        /* The output that is kept in the row. */
        struct vor_error err;
        vor_status status = vor_store_report(request->app->store, &view->id, &out->bytes, &err);

        if (status == VOR_OK && out->bytes == NULL)
            return vor_result_missing(request, view);
        if (status != VOR_OK)
            return vor_problem_error(request, &err, view->id.text);
        out->size = strlen(out->bytes);
        vor_digest_etag(out->bytes, (size_t)out->size, out->etag);
        return true;
    }
    out->size = view->output[index].bytes;
    (void)snprintf(out->etag, sizeof out->etag, "\"%s\"", view->output[index].sha256);
    if (view->output[index].has_origin)
        (void)vor_origin_text(view->output[index].origin, out->origin);
    (void)vor_blob_of_output(view->spec.process->outputs[index].name, view->attempt, blob);
    return open_blob(request, view, blob, vor_result_missing, out);
}

/* A name that is not ASCII stands there a second time, as RFC 6266 has it, for those who read that.
 */
static void put_disposition(struct vor_text *text, const char *name)
{
    int is_ascii = 1;

    vor_text_puts(text, "attachment; filename=\"");
    for (const char *c = name; *c != '\0'; c++) {
        int is_plain = (unsigned char)*c < 0x80;

        is_ascii &= is_plain;
        vor_text_add(text, is_plain ? c : "_", 1);
    }
    vor_text_puts(text, is_ascii ? "\"" : "\"; filename*=UTF-8''");
    if (!is_ascii)
        vor_text_escape(text, name);
}

static void add_headers(struct vor_request *request, const struct output *out)
{
    struct vor_text disposition;

    vor_text_init(&disposition, 0);
    put_disposition(&disposition, out->name);
    vor_reply_header(request, "ETag", out->etag);
    if (!disposition.failed)
        vor_reply_header(request, "Content-Disposition", disposition.data);
    vor_text_free(&disposition);
    vor_reply_header(request, "Cache-Control", "private, no-cache");
    vor_reply_header(request, "Accept-Ranges", "bytes");
    if (out->origin[0] != '\0')
        vor_reply_header(request, "Voronoid-Origin", out->origin);
}

/* A reply under way with bytes that may still come: the state of its request. */
struct flowing {
    struct vor_flow *flow;
    uint64_t at, end;
};

static void release_flow(void *ctx)
{
    struct flowing *flowing = ctx;

    vor_flow_drop(flowing->flow);
    free(flowing);
}

static long read_flow(struct vor_request *request, char *out, size_t size)
{
    struct flowing *flowing = request->state;
    struct vor_asker asker = vor_asker_of(request);
    uint64_t left = flowing->end - flowing->at;
    int whole = 0;
    long got = vor_flow_read(flowing->flow, flowing->at, out, size < left ? size : (size_t)left,
                             &asker, &whole);

    if (got != 0 || whole)
        vor_waker_drop(asker.ctx);
    if (got > 0)
        flowing->at += (uint64_t)got;
    return got == 0 && whole ? -1 : got;
}

static void send_part(struct vor_request *request, int http, struct output *out, uint64_t offset,
                      uint64_t length)
{
    if (out->bytes != NULL) {
        vor_reply_bytes(request, http, out->media_type, out->bytes + offset, (size_t)length);
        return;
    }
    if (out->flow != NULL) {
        struct flowing *flowing = calloc(1, sizeof *flowing);

        if (flowing == NULL) {
            (void)vor_problem_no_memory(request);
            return;
        }
        *flowing = (struct flowing){out->flow, offset, offset + length};
        out->flow = NULL;
        vor_request_set_state(request, flowing, release_flow);
        vor_reply_stream(request, http, out->media_type, length, read_flow);
        return;
    }
    vor_reply_file(request, http, out->media_type, out->fd, offset, length);
    out->fd = -1;
}

/* The bytes of a file that are asked for. */
static enum vor_range range_of(struct vor_request *request, const char *etag, uint64_t size,
                               uint64_t *offset, uint64_t *length)
{
    const char *range = vor_request_header(request, "Range");
    const char *if_range = vor_request_header(request, "If-Range");

    *offset = 0;
    *length = size;
    if (request->method != VOR_GET || vor_request_condition(request, etag) != 200 ||
        (if_range != NULL && strcmp(if_range, etag) != 0))
        range = NULL;
    return vor_range_parse(range, size, offset, length);
}

static enum vor_next reply_output(struct vor_request *request, struct output *out)
{
    uint64_t offset, length;
    char span[96];

    switch (range_of(request, out->etag, out->size, &offset, &length)) {
    case VOR_RANGE_OUTSIDE:
        (void)snprintf(span, sizeof span, "bytes */%" PRIu64, out->size);
        vor_reply_header(request, "Content-Range", span);
        return vor_problem_say(request, "range-not-satisfiable",
                               "Range is %.60s, want a range that begins within 0 to %" PRIu64,
                               vor_request_header(request, "Range"),
                               out->size > 0 ? out->size - 1 : 0);
    case VOR_RANGE_PART:
        (void)snprintf(span, sizeof span, "bytes %" PRIu64 "-%" PRIu64 "/%" PRIu64, offset,
                       offset + length - 1, out->size);
        vor_reply_header(request, "Content-Range", span);
        add_headers(request, out);
        send_part(request, 206, out, offset, length);
        break;
    case VOR_RANGE_WHOLE:
        add_headers(request, out);
        send_part(request, 200, out, 0, out->size);
        break;
    }
    return VOR_NEXT_REPLY;
}

static void output_close(struct output *out)
{
    free(out->bytes);
    if (out->fd >= 0)
        (void)close(out->fd);
    vor_flow_drop(out->flow);
}

/* The bytes of a file of more than a piece are sent while they come, if any are to be sent. */
static struct vor_blob_part part_of(struct vor_request *request, const char *sha256, uint64_t size)
{
    struct vor_blob_part part = {.size = size};
    char etag[VOR_ETAG_SIZE];
    uint64_t length;

    memcpy(part.sha256, sha256, sizeof part.sha256);
    (void)snprintf(etag, sizeof etag, "\"%s\"", sha256);
    if (size > VOR_BLOB_PIECE && request->method == VOR_GET &&
        vor_request_condition(request, etag) == 200 &&
        range_of(request, etag, size, &part.from, &length) != VOR_RANGE_OUTSIDE)
        part.to = part.from + length;
    return part;
}

/* True when the bytes of a file are those that were written, or none are to be sent. Else *next is
 * what the handler returns; once woken, it is called again and asks again. */
static bool is_sound(struct vor_request *request, const struct vor_job_view *view,
                     const struct output *out, enum vor_next *next)
{
    enum vor_verdict verdict;
    struct vor_asker asker;
    char sha256[VOR_DIGEST_SIZE], detail[VOR_RESULT_NAME_SIZE + 160];

    if (out->fd < 0 || request->method == VOR_HEAD ||
        vor_request_condition(request, out->etag) != 200)
        return true;
    (void)snprintf(sha256, sizeof sha256, "%s", out->etag + 1); /* between its quotes */
    asker = vor_asker_of(request);
    verdict = vor_verify_ask(request->app->verify, out->fd, out->size, sha256, &asker);
    if (verdict != VOR_VERDICT_WAIT)
        vor_waker_drop(asker.ctx);
    if (verdict == VOR_VERDICT_WAIT) {
        *next = vor_problem_or_wait(request);
    } else if (verdict == VOR_VERDICT_DAMAGED) {
        (void)snprintf(detail, sizeof detail,
                       "the stored bytes of %s differ from the bytes that were written "
                       "(SHA-256 %s)",
                       out->name, sha256);
        *next = say_with_job(request, "damaged-bytes", detail, view->id.text);
    } else if (verdict == VOR_VERDICT_FAILED) {
        *next = vor_problem_say(request, "store-unavailable",
                                "the stored bytes cannot be checked now; try again later");
    }
    return verdict == VOR_VERDICT_SOUND;
}

enum vor_next vor_result_whole(struct vor_request *request, const struct vor_job_view *view,
                               bool is_new)
{
    enum vor_next next = VOR_NEXT_REPLY;
    struct output out = {.fd = -1};

    if (open_output(request, view, 0, &out) && (is_new || is_sound(request, view, &out, &next))) {
        add_headers(request, &out);
        send_part(request, 200, &out, 0, out.size);
    }
    output_close(&out);
    return next;
}

/* Output number `index` in another format than the job's. */
static enum vor_next reply_converted(struct vor_request *request, const struct vor_job_view *view,
                                     unsigned index, unsigned format)
{
    struct output out = {.fd = -1, .media_type = vor_format(format)->media_type};
    struct vor_converted converted;
    enum vor_next next;

    if (!vor_result_accepts(request, out.media_type))
        return VOR_NEXT_REPLY;
    next = vor_converted_get(request, view, index, format, &converted);
    if (next != VOR_NEXT_REPLY || converted.fd < 0)
        return next;
    out.fd = converted.fd;
    out.size = converted.size;
    (void)snprintf(out.etag, sizeof out.etag, "\"%s\"", converted.sha256);
    memcpy(out.origin, converted.origin, sizeof out.origin);
    name_file(view, index, vor_format(format), &out);
    if (is_sound(request, view, &out, &next))
        next = reply_output(request, &out);
    output_close(&out);
    return next;
}

/* Whether a client may be sent to where a result lies: conditions compare ETags, and there it has
 * another one; while S3 is away, the bytes may be here. */
static bool may_be_sent_there(struct vor_request *request, const struct vor_result_query *ask)
{
    static const char *const conditions[] = {"If-Match", "If-None-Match", "If-Modified-Since",
                                             "If-Unmodified-Since", "If-Range"};

    for (size_t i = 0; i < sizeof conditions / sizeof conditions[0]; i++)
        if (vor_request_header(request, conditions[i]) != NULL)
            return false;
    return !ask->stays && vor_blobs_reach(request->app->blobs, NULL) == VOR_OK;
}

/* Replies with a link to where a result lies; false where there is none. */
static bool reply_link(struct vor_request *request, const struct vor_job_view *view, unsigned index)
{
    const struct vor_job_output *output = &view->output[index];
    struct vor_blob_reading reading = {.method = request->method == VOR_HEAD ? "HEAD" : "GET",
                                       .media_type = vor_output_media_type(view, index)};
    struct output out = {.fd = -1};
    struct vor_text link, disposition;
    char blob[VOR_BLOB_NAME_MAX + 1];
    bool done;

    if (reading.media_type == NULL)
        return false;
    vor_text_init(&link, 0);
    vor_text_init(&disposition, 0);
    name_file(view, index, vor_format(output->format), &out);
    put_disposition(&disposition, out.name);
    reading.disposition = disposition.failed ? "attachment" : disposition.data;
    (void)vor_blob_of_output(view->spec.process->outputs[index].name, view->attempt, blob);
    done = vor_blob_link(request->app->blobs, &view->id, blob, &reading, &link, NULL) == VOR_OK &&
           link.size > 0;
    if (done) {
        (void)snprintf(out.etag, sizeof out.etag, "\"%s\"", output->sha256);
        if (output->has_origin)
            vor_reply_header(request, "Voronoid-Origin",
                             vor_origin_text(output->origin, out.origin));
        vor_reply_header(request, "ETag", out.etag);
        vor_reply_header(request, "Location", link.data);
        vor_reply_header(request, "Cache-Control", "no-store");
        vor_reply_bytes(request, 307, NULL, "", 0);
    }
    vor_text_free(&link);
    vor_text_free(&disposition);
    return done;
}

enum vor_next vor_handle_result(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    const struct vor_artefact_info *outputs, *output;
    struct output out = {.fd = -1};
    enum vor_next next = VOR_NEXT_REPLY;
    struct vor_result_query ask;
    struct vor_job_view view;
    const char *segment;
    size_t length = vor_path_segment(request->path, 4, &segment);
    char name[64], blob[VOR_BLOB_NAME_MAX + 1];
    struct vor_here here = {.exists = true};

    if (!vor_job_look_up(request, &view))
        return VOR_NEXT_REPLY;
    (void)snprintf(name, sizeof name, "%.*s", (int)(length < 60 ? length : 60), segment);
    outputs = view.spec.process->outputs;
    output = vor_artefact_find(outputs, name);
    if (output == NULL) {
        char names[256];
        size_t at = 0;

        /* "cloud", "cloud or report", "cloud, mesh or report". */
        names[0] = '\0';
        for (unsigned i = 0; view.spec.process->outputs[i].name != NULL && at < (sizeof names);
             i++) {
            const char *before = view.spec.process->outputs[i + 1].name != NULL ? ", " : " or ";

            at += (size_t)snprintf(names + at, (sizeof names) - at, "%s%s", i > 0 ? before : "",
                                   view.spec.process->outputs[i].name);
        }
        return vor_problem_say(request, "no-such-output", "there is no output %s, want %s", name,
                               names);
    }
    if (!vor_result_query_read(request, output->kind == VOR_ARTEFACT_CLOUD, &ask))
        return VOR_NEXT_REPLY;
    if (view.status != VOR_JOB_SUCCESSFUL || view.expired)
        return vor_result_missing(request, &view);
    if (ask.has_format && ask.format != view.output[output - outputs].format)
        return reply_converted(request, &view, (unsigned)(output - outputs), ask.format);
    if (!vor_output_in_row(output) && may_be_sent_there(request, &ask) &&
        reply_link(request, &view, (unsigned)(output - outputs)))
        return VOR_NEXT_REPLY;
    here.part =
        part_of(request, view.output[output - outputs].sha256, view.output[output - outputs].bytes);
    (void)vor_blob_of_output(output->name, view.attempt, blob);
    if (!vor_output_in_row(output) && !vor_blob_is_here(request, &view.id, blob, &here, &next))
        return next;
    if (!here.exists)
        return vor_result_missing(request, &view);
    out.flow = here.flow;
    if (open_output(request, &view, (unsigned)(output - outputs), &out) &&
        vor_result_accepts(request, out.media_type) && is_sound(request, &view, &out, &next))
        next = reply_output(request, &out);
    output_close(&out);
    return next;
}

enum vor_next vor_handle_results(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    struct vor_result_query ask;
    struct vor_job_view view;
    struct vor_text text;
    char url[VOR_URL_MAX];

    if (!vor_job_look_up(request, &view) || !vor_result_query_read(request, false, &ask))
        return VOR_NEXT_REPLY;
    if (view.status != VOR_JOB_SUCCESSFUL || view.expired)
        return vor_result_missing(request, &view);
    if (!vor_result_accepts(request, "application/json"))
        return VOR_NEXT_REPLY;
    vor_document_begin(&text);
    for (unsigned i = 0; view.spec.process->outputs[i].name != NULL; i++) {
        const char *name = view.spec.process->outputs[i].name;

        vor_json_put_object(&text, name);
        vor_json_put_string(&text, "href", vor_app_result_url(request, &view.id, name, url));
        vor_json_put_string(&text, "type", vor_output_media_type(&view, i));
        vor_json_end_object(&text);
    }
    vor_reply_header(request, "Cache-Control", "no-store");
    return vor_document_reply(request, &text);
}

static enum vor_next missing_input(struct vor_request *request, const struct vor_job_view *view)
{
    return say_with_job(request, "input-not-kept", "the input of this job is no longer stored",
                        view->id.text);
}

enum vor_next vor_handle_input(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    struct output out = {.fd = -1};
    enum vor_next next = VOR_NEXT_REPLY;
    char blob[VOR_BLOB_NAME_MAX + 1];
    const struct vor_format *format;
    struct vor_job_view view;
    struct vor_here here = {.exists = false};

    if (!vor_job_look_up(request, &view))
        return VOR_NEXT_REPLY;
    if (view.expired)
        return vor_result_missing(request, &view);
    (void)vor_blob_of_upload(view.spec.process->inputs[0].name, blob);
    here.part = part_of(request, view.input[0].sha256, view.input[0].bytes);
    if (!vor_blob_is_here(request, &view.id, blob, &here, &next))
        return next;
    if (!here.exists)
        return missing_input(request, &view);
    out.flow = here.flow;
    out.size = view.input[0].bytes;
    format = vor_format(view.input[0].format);
    out.media_type = format != NULL ? format->media_type : "application/octet-stream";
    vor_result_name(out.name, view.name, view.id.text, view.spec.process->id, "input",
                    format != NULL ? format->suffix : "");
    (void)snprintf(out.etag, sizeof out.etag, "\"%s\"", view.input[0].sha256);
    if (open_blob(request, &view, blob, missing_input, &out) &&
        is_sound(request, &view, &out, &next))
        next = reply_output(request, &out);
    output_close(&out);
    return next;
}
