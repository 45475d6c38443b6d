#include "server/api/handlers/submission.h"

#include "core/base/quote.h"
#include "proto/codec.h"
#include "proto/multipart.h"
#include "server/api/accept.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"

#include <string.h>
#include <strings.h>

enum { SHOWN_SIZE = 48 }; /* of a header in a message */

/* What an Accept header leaves to choose from. */
struct acceptance {
    bool given, any, stream, json;
    unsigned format; /* best one named */
    double quality;  /* of it, 0 for none */
};

int vor_submit_coding(const char *coding)
{
    if (strcasecmp(coding, "gzip") == 0 || strcasecmp(coding, "x-gzip") == 0)
        return 1; /* RFC 9110, 8.4.1.3: the two are the same */
    return coding[0] == '\0' || strcasecmp(coding, "identity") == 0 ? 0 : -1;
}

static bool read_coding(struct vor_request *request, struct vor_submit_head *out)
{
    unsigned index = 0;
    const char *value = vor_request_header_next(request, "Content-Encoding", &index);
    const char *more = vor_request_header_next(request, "Content-Encoding", &index);
    int coding;

    if (value == NULL)
        return true;
    coding = vor_submit_coding(value);
    out->is_gzip = coding > 0;
    if (coding >= 0 && more == NULL)
        return true;
    vor_reply_header(request, "Accept-Encoding", "gzip");
    return vor_problem_say(
        request, "unsupported-format", "Content-Encoding is %s%s, want gzip, once, or none",
        VOR_QUOTED(SHOWN_SIZE, value, strlen(value)), more != NULL ? " and more" : "");
}

/* Reads Content-Type and Content-Encoding. */
static bool read_body(struct vor_request *request, struct vor_submit_head *out)
{
    const char *type = vor_request_header(request, "Content-Type");
    size_t length = type != NULL ? strcspn(type, "; \t") : 0;

    if (request->length != 0 && ((length == 16 && strncasecmp(type, "application/json", 16) == 0) ||
                                 (length > 5 && strncasecmp(type + length - 5, "+json", 5) == 0)))
        out->body = VOR_SUBMIT_JSON;
    else if (type != NULL && vor_multipart_is_form(type))
        out->body = VOR_SUBMIT_FORM;
    if (out->body == VOR_SUBMIT_JSON)
        return true;
    if (!read_coding(request, out))
        return false;
    if (out->body != VOR_SUBMIT_FORM || !out->is_gzip)
        return true;
    return vor_problem_say(
        request, "unsupported-format",
        "Content-Encoding is gzip for the whole form, want it only in the headers "
        "of a part with a file");
}

static vor_status read_pairs(struct vor_request *request, struct vor_submit_head *out,
                             struct vor_error *err)
{
    for (int i = 0; i < request->pair_count; i++) {
        const char *name = request->pairs[i].name, *value = request->pairs[i].value;
        vor_status status;
        int taken;

        if (vor_request_query(request, name) != value)
            return vor_fail_param(err, VOR_E_PARAM, name, "%s is given more than once",
                                  VOR_QUOTED(sizeof err->parameter, name, strlen(name)));
        status =
            vor_submit_options_take(&out->options, out->spec.process, name, value, &taken, err);
        if (status == VOR_OK && !taken)
            status = vor_spec_set(&out->spec, name, value, err);
        if (status != VOR_OK)
            return status;
    }
    return VOR_OK;
}

static void read_accept(struct vor_request *request, struct acceptance *accept)
{
    struct vor_accept_walk walk = {NULL};
    struct vor_accept_range range;

    *accept = (struct acceptance){0};
    while (vor_accept_next(request, &walk, &range)) {
        const char *type = range.type;
        const struct vor_format *format = vor_format_by_media_type(type);

        accept->given = true;
        if (range.quality <= 0 || type[0] == '\0')
            continue;
        accept->stream = accept->stream || strcasecmp(type, "text/event-stream") == 0;
        accept->json = accept->json || strcasecmp(type, "application/json") == 0;
        accept->any = accept->any || strcasecmp(type, "*/*") == 0 ||
                      strcasecmp(type, "application/*") == 0 ||
                      strcasecmp(type, "application/octet-stream") == 0;
        if (format == NULL || range.quality <= accept->quality)
            continue;
        accept->quality = range.quality;
        for (unsigned i = 0; vor_format(i) != NULL; i++)
            if (vor_format(i) == format)
                accept->format = i;
    }
}

/* True when Accept leaves room for whatever comes: there is none, or it names all or a stream. */
static bool accepts_all(const struct acceptance *accept)
{
    return !accept->given || accept->any || accept->stream;
}

/* The parameter decides, then Accept; what neither decides is the input's format. */
static bool choose_format(struct vor_request *request, const struct acceptance *accept,
                          struct vor_submit_head *out)
{
    const struct vor_format *named = vor_format((unsigned)out->spec.value[VOR_PARAM_FORMAT]);

    /* A format that the request names must be one that Accept takes, unless the answer is a stream
     * or the address of the job. */
    if (vor_spec_given(&out->spec, VOR_PARAM_FORMAT)) {
        if (out->mode != VOR_SUBMIT_SYNC || (accept->json && out->is_async) ||
            vor_accept_takes(request, named->media_type))
            return true;
        return vor_problem_say(request, "not-acceptable",
                               "format is %s, but the Accept header does not allow %s", named->name,
                               named->media_type);
    }
    if (accept->quality > 0) {
        out->spec.value[VOR_PARAM_FORMAT] = accept->format;
        return true;
    }
    if (accepts_all(accept) || (accept->json && out->mode == VOR_SUBMIT_ASYNC))
        return true;
    return vor_problem_say(
        request, "not-acceptable", "Accept names none of %s, %s, text/event-stream and */*",
        vor_format(VOR_FORMAT_PLY)->media_type, vor_format(VOR_FORMAT_DRC)->media_type);
}

bool vor_submit_complete(struct vor_request *request, struct vor_submit_head *head)
{
    struct acceptance accept;
    struct vor_error err;

    if (vor_spec_complete(&head->spec, &err) != VOR_OK)
        return vor_problem_error(request, &err, NULL);
    read_accept(request, &accept);
    if (head->spec.process->outputs[0].kind == VOR_ARTEFACT_CLOUD)
        return choose_format(request, &accept, head);
    if (accepts_all(&accept) || accept.json) /* a document is JSON */
        return true;
    return vor_problem_say(
        request, "not-acceptable",
        "the Accept header has none of application/json, text/event-stream and */*");
}

bool vor_submit_read_spec(struct vor_request *request, struct vor_submit_head *out)
{
    const struct vor_process_info *process = vor_process_of_submit(request);
    struct vor_error err;

    memset(out, 0, sizeof *out);
    if (process == NULL)
        return false;
    vor_spec_preset(&out->spec, process);
    if (!read_body(request, out))
        return false;
    if (out->body == VOR_SUBMIT_JSON ||
        (read_pairs(request, out, &err) == VOR_OK &&
         vor_submit_options_read_key(&out->options, request, &err) == VOR_OK))
        return true;
    return vor_problem_error(request, &err, NULL);
}

bool vor_submit_read(struct vor_request *request, struct vor_submit_head *out)
{
    struct vor_preferences preferences;
    struct acceptance accept;

    if (!vor_submit_read_spec(request, out))
        return false;
    if (out->body == VOR_SUBMIT_JSON)
        return true;
    read_accept(request, &accept);
    vor_prefer_read(request, &preferences);
    out->is_async = preferences.is_async;
    out->wait_seconds = preferences.wait_seconds;
    if (accept.stream)
        out->mode = VOR_SUBMIT_STREAM;
    else if (out->is_async && out->wait_seconds <= 0)
        out->mode = VOR_SUBMIT_ASYNC;
    return out->body == VOR_SUBMIT_FORM || vor_submit_complete(request, out);
}

bool vor_submit_has_room(struct vor_request *request, const struct vor_submit_head *head)
{
    struct vor_app *app = request->app;
    const struct vor_quota *quota = &request->principal.quota;
    const struct vor_job_label label = {.key = &head->options.key,
                                        .jobs_max = (uint64_t)quota->jobs,
                                        .bytes_max = (uint64_t)quota->bytes};
    int64_t length = request->length;
    struct vor_error err;
    enum vor_job_outcome room =
        vor_job_service_room(app->service, &label, length > 0 ? (uint64_t)length : 0, &err);

    if (room != VOR_DONE)
        return vor_outcome_reply(request, room, &err, NULL);
    if (head->mode == VOR_SUBMIT_STREAM &&
        atomic_load(&app->streams) >= (unsigned)app->config->number[VOR_SET_STREAMS])
        return vor_problem_say(request, "too-many-streams", "%.0f event streams are open",
                               app->config->number[VOR_SET_STREAMS]);
    if (length > (int64_t)app->config->number[VOR_SET_BODY_LIMIT] || /* refused for that */
        vor_blobs_room(app->blobs, length > 0 ? (uint64_t)length : 0, &err) == VOR_OK)
        return true;
    return vor_problem_error(request, &err, NULL);
}
