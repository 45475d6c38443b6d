/* The frames of a sequence in one request: a tar archive, or the files of a form. Its body is kept
 * in one file while it arrives. Each frame that is whole becomes a job like any other, and where
 * the process continues an earlier result, with that of the last frame that has one. Of these one
 * is on its way at a time; of the others a few are, so that one is decoded while another is
 * computed. The reply is a tar archive, too: what became of each frame, in the order of the frames,
 * as soon as it is known. It begins when the body is in, or, if the client prefers that, when the
 * first frame is over: not all clients and proxies go on sending then.
 *
 * A frame whose job has a row is as safe as any job. Of the others nothing is kept beyond the
 * request. */
#include "server/api/handlers/frames.h"

#include "proto/codec.h"
#include "proto/sse.h"
#include "server/api/accept.h"
#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/limits.h"
#include "server/api/problem.h"
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/metrics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    PATIENCE = 256 << 10, /* bytes read of a body that is refused already */
    END_BLOCKS = 2        /* of an archive */
};

/* --- the reply -------------------------------------------------------------------------------- */

static void add_zeros(struct vor_text *text, size_t size)
{
    static const char zeros[VOR_TAR_BLOCK];

    for (; size > 0; size -= size < sizeof zeros ? size : sizeof zeros)
        vor_text_add(text, zeros, size < sizeof zeros ? size : sizeof zeros);
}

/* Adds the header of the file that has the name of a frame, with another suffix. */
static void add_header(struct vor_text *text, const struct vor_frame *frame, const char *suffix,
                       uint64_t size)
{
    uint8_t header[VOR_TAR_BLOCK];
    char name[sizeof frame->name + 8];

    (void)snprintf(name, sizeof name, "%.*s%s", (int)frame->stem, frame->name, suffix);
    vor_tar_header(header, name, size);
    vor_text_add(text, (const char *)header, sizeof header);
}

/* Opens the result of a frame. False when it is on its way here from another machine. */
static bool open_result(struct vor_sequence *sequence, size_t index)
{
    struct vor_app *app = sequence->app;
    struct vor_frame *frame = &sequence->frames[index];
    char name[VOR_BLOB_NAME_MAX + 1];
    struct vor_error err;
    enum vor_fetched fetched;
    int found = 0;
    vor_status status = VOR_OK;

    if (!vor_sequence_fetch(sequence, &frame->id, frame->attempt, &fetched, &err))
        return false;
    (void)vor_blob_of_output(sequence->head.spec.process->outputs[0].name, frame->attempt, name);
    if (fetched == VOR_FETCH_FAILED)
        status = err.status;
    else if (fetched != VOR_FETCH_NONE)
        status = vor_blob_get(app->blobs, &frame->id, name, &sequence->fd, &sequence->size, &found,
                              &err);
    if (status == VOR_OK && !found)
        status = vor_fail(&err, VOR_E_PARAM, "the result of job %s was deleted", frame->id.text);
    sequence->at = 0;
    if (status != VOR_OK)
        vor_sequence_tell_problem(sequence, index, VOR_FAILED, &err);
    return true;
}

/* Adds what comes next to the text. False when that is not known yet. */
static bool compose(struct vor_sequence *sequence)
{
    struct vor_text *text = &sequence->text;
    size_t index = sequence->sent;
    struct vor_frame *frame = &sequence->frames[index];

    if (index == sequence->count) {
        add_zeros(text, (size_t)END_BLOCKS * VOR_TAR_BLOCK);
        sequence->is_closed = true;
        return true;
    }
    if (!frame->is_over || (frame->id.text[0] != '\0' && !open_result(sequence, index)))
        return false;
    vor_text_puts(&frame->told, "\n");
    add_header(text, frame, VOR_TOLD_SUFFIX, frame->told.size);
    vor_text_add(text, frame->told.data, frame->told.size);
    add_zeros(text, vor_tar_filler(frame->told.size));
    if (sequence->fd >= 0)
        add_header(text, frame, vor_format(frame->format)->suffix, sequence->size);
    vor_text_free(&frame->told);
    sequence->sent++;
    return true;
}

/* The same as events: that a frame has a job, and what became of it. The id is its number. */
static bool compose_events(struct vor_sequence *sequence)
{
    struct vor_frame *frame = &sequence->frames[sequence->sent];
    double beat = sequence->app->config->number[VOR_SET_HEARTBEAT], now = vor_clock_seconds();
    char id[24];

    if (sequence->sent == sequence->count) {
        sequence->is_closed = true;
        return true;
    }
    if (frame->is_over || frame->is_accepted) {
        (void)snprintf(id, sizeof id, "%zu", sequence->sent + 1);
        vor_sse_event(&sequence->text, id, "frame", frame->told.data, frame->told.size);
        vor_text_clear(&frame->told);
        sequence->sent += frame->is_over;
        frame->is_accepted = false;
    } else if (now - sequence->sent_at < beat) {
        vor_request_wake_after(sequence->request, beat - (now - sequence->sent_at));
        return false;
    } else {
        vor_sse_heartbeat(&sequence->text);
    }
    sequence->sent_at = now;
    return true;
}

/* The next bytes of the result at hand. */
static long read_result(struct vor_sequence *sequence, char *out, size_t size)
{
    uint64_t left = sequence->size - sequence->at;
    ssize_t got = pread(sequence->fd, out, left < size ? (size_t)left : size, (off_t)sequence->at);

    if (got <= 0)
        return VOR_STREAM_CUT;
    sequence->at += (uint64_t)got;
    if (sequence->at < sequence->size)
        return (long)got;
    (void)close(sequence->fd);
    sequence->fd = -1;
    vor_text_clear(&sequence->text);
    sequence->taken = 0;
    add_zeros(&sequence->text, vor_tar_filler(sequence->size));
    return (long)got;
}

static long read_reply(struct vor_request *request, char *out, size_t size)
{
    struct vor_sequence *sequence = request->state;

    if (vor_request_gone(request) || sequence->error.status != VOR_OK)
        return VOR_STREAM_CUT;
    vor_sequence_advance(sequence);
    while (sequence->taken == sequence->text.size) {
        if (sequence->fd >= 0)
            return read_result(sequence, out, size);
        if (sequence->is_closed)
            return -1;
        vor_text_clear(&sequence->text);
        sequence->taken = 0;
        if (sequence->sent == sequence->count && !request->whole)
            return 0;
        if (!(sequence->is_events ? compose_events : compose)(sequence))
            return 0;
    }
    if (sequence->text.failed)
        return VOR_STREAM_CUT;
    if (size > sequence->text.size - sequence->taken)
        size = sequence->text.size - sequence->taken;
    memcpy(out, sequence->text.data + sequence->taken, size);
    sequence->taken += size;
    return (long)size;
}

/* --- the request ------------------------------------------------------------------------------ */

static void free_sequence(struct vor_deferred *deferred)
{
    struct vor_sequence *sequence = (struct vor_sequence *)deferred;

    vor_uploads_discard(&sequence->body);
    for (size_t i = 0; i < sequence->count; i++)
        vor_text_free(&sequence->frames[i].told);
    free(sequence->frames);
    vor_text_free(&sequence->text);
    if (sequence->fd >= 0)
        (void)close(sequence->fd);
    free(sequence);
}

/* Jobs that there are go on: their results can be asked for. */
static void on_over(struct vor_deferred *deferred)
{
    struct vor_sequence *sequence = (struct vor_sequence *)deferred;

    for (unsigned i = 0; i < VOR_FLIGHTS; i++)
        vor_flight_leave(&sequence->flights[i]);
    if (sequence->is_stream || sequence->is_early)
        (void)atomic_fetch_sub(&sequence->app->streams, 1);
}

static void begin_reply(struct vor_sequence *sequence)
{
    struct vor_request *request = sequence->request;

    sequence->is_stream = true;
    sequence->sent_at = vor_clock_seconds();
    if (sequence->is_early)
        vor_reply_header(request, "Preference-Applied", "respond-early");
    else
        (void)atomic_fetch_add(&request->app->streams, 1);
    vor_reply_header(request, "Cache-Control", "no-store");
    vor_reply_header(request, "X-Accel-Buffering", "no");
    vor_reply_stream(request, 200, sequence->is_events ? "text/event-stream" : "application/x-tar",
                     VOR_LENGTH_UNKNOWN, read_reply);
}

/* Whether frames that have arrived are on their way, or back. */
static bool waits(void *ctx)
{
    const struct vor_sequence *sequence = ctx;

    return sequence->error.status == VOR_OK &&
           sequence->sent + (sequence->is_open ? 1 : 0) < sequence->count;
}

static int take_piece(void *ctx, const void *bytes, size_t size)
{
    struct vor_sequence *sequence = ctx;
    struct vor_error *err = &sequence->error;

    vor_metric_add(VOR_METRIC_UPLOAD_BYTES, (double)size, NULL);
    if (err->status == VOR_OK) {
        if (vor_sequence_feed(sequence, bytes, size, err) == VOR_OK)
            vor_sequence_advance(sequence);
    }
    if (err->status == VOR_OK && sequence->is_early && !sequence->is_stream &&
        sequence->count > 0 && (sequence->frames[0].is_over || sequence->frames[0].is_accepted))
        begin_reply(sequence);
    if (err->status != VOR_OK && sequence->is_stream)
        return -1;
    if (err->status == VOR_E_IO)
        return vor_error_storage_full(err) ? 507 : 503;
    if (err->status == VOR_OK || (sequence->wasted += size) <= PATIENCE)
        return 0;
    vor_problem_error(sequence->request, err, NULL);
    return -1;
}

/* Completes the parameters: what a single cloud is asked for, each frame has by default. */
static vor_status complete(struct vor_submit_head *head, bool *is_linked, struct vor_error *err)
{
    struct vor_spec *spec = &head->spec;
    const struct vor_process_info *process = spec->process;
    const struct vor_artefact_info *more = &process->inputs[1];
    vor_status status;

    if (process->outputs[0].kind != VOR_ARTEFACT_CLOUD ||
        (more->name != NULL && strcmp(more->name, "previous") != 0))
        return vor_fail_param(
            err, VOR_E_PARAM, "processID",
            "frames cannot be sent to the process %s, which does not make a cloud of a cloud",
            process->id);
    if (head->options.name[0] != '\0' || head->options.input.text[0] != '\0')
        return vor_fail_param(err, VOR_E_PARAM, head->options.name[0] != '\0' ? "name" : "input",
                              "a sequence takes neither name nor input: its files name the jobs");
    if (head->options.key.text[0] != '\0')
        return vor_fail_param(err, VOR_E_PARAM, "Idempotency-Key",
                              "a sequence starts several jobs, want no Idempotency-Key");
    if (vor_process_takes(process, VOR_PARAM_RATIO) && strcmp(process->id, "resample") == 0 &&
        !vor_spec_given(spec, VOR_PARAM_POINTS) && !vor_spec_given(spec, VOR_PARAM_RATIO) &&
        !vor_spec_given(spec, VOR_PARAM_SPACING))
        spec->value[VOR_PARAM_RATIO] = 1;
    status = vor_spec_complete(spec, err);
    if (status != VOR_OK)
        return status;
    *is_linked = more->name != NULL && vor_spec_check_inputs(spec, 3, err) == VOR_OK;
    if (*is_linked && !vor_spec_given(spec, VOR_PARAM_COHERENCE))
        spec->value[VOR_PARAM_COHERENCE] = 1;
    return VOR_OK;
}

/* Reads the head; false after a problem has been replied. */
static bool read_head(struct vor_request *request, struct vor_submit_head *head, bool *is_linked)
{
    struct vor_error err;
    enum vor_next next;

    if (!vor_limits_rate(request) || !vor_submit_read_spec(request, head))
        return false;
    head->mode = VOR_SUBMIT_STREAM;
    if (head->body == VOR_SUBMIT_JSON || head->is_gzip)
        return vor_problem_say(request, "unsupported-format",
                               "the body is %s, want a tar archive, or a form with files",
                               head->is_gzip ? "compressed" : "JSON");
    if (!vor_accept_takes(request, "application/x-tar") &&
        !vor_accepts(request, "text/event-stream"))
        return vor_problem_say(
            request, "not-acceptable",
            "the Accept header has none of application/x-tar, text/event-stream and "
            "*/*");
    if (complete(head, is_linked, &err) != VOR_OK)
        return vor_problem_error(request, &err, NULL);
    /* The result that the first frame starts from must be there. */
    return vor_submit_options_open(request, &head->options, head->spec.process, NULL, &next) &&
           vor_submit_has_room(request, head);
}

static enum vor_next begin(struct vor_request *request)
{
    struct vor_app *app = request->app;
    struct vor_submit_head head;
    struct vor_sequence *sequence;
    struct vor_body_sink sink;
    struct vor_preferences preferences;
    struct vor_error err;
    bool is_linked = false;
    vor_status status;

    if (!read_head(request, &head, &is_linked))
        return VOR_NEXT_REPLY;
    sequence = calloc(1, sizeof *sequence);
    if (sequence == NULL)
        return vor_problem_no_memory(request);
    sequence->app = app;
    sequence->request = request;
    sequence->head = head;
    sequence->quota = request->principal.quota;
    sequence->span = request->span;
    sequence->caller = vor_auth_fairness_key(request);
    sequence->is_linked = is_linked;
    sequence->is_events = vor_accepts(request, "text/event-stream");
    sequence->last = head.options.previous;
    sequence->fd = -1;
    vor_text_init(&sequence->text, 0);
    sequence->deferred.over = on_over;
    vor_deferred_begin(&sequence->deferred, request, free_sequence);
    status =
        vor_uploads_begin(&sequence->body, head.spec.process->inputs[0].name, 0, app->blobs, &err);
    VOR_THEN(status, vor_sequence_begin_body(sequence, &err));
    if (status != VOR_OK)
        return vor_problem_error(request, &err, NULL);
    vor_prefer_read(request, &preferences);
    sink = (struct vor_body_sink){sequence, take_piece};
    vor_request_take_body(request, &sink, (uint64_t)app->config->number[VOR_SET_BODY_LIMIT]);
    sequence->is_early = preferences.is_early && vor_request_reply_early(request, waits);
    if (sequence->is_early)
        (void)atomic_fetch_add(&app->streams, 1);
    return VOR_NEXT_BODY;
}

/* The body is in. */
static enum vor_next reply(struct vor_request *request, struct vor_sequence *sequence)
{
    struct vor_error *err = &sequence->error;
    vor_status status = err->status;

    VOR_THEN(status, vor_sequence_finish(sequence, err));
    if (sequence->is_stream)
        return VOR_NEXT_REPLY;
    if (status != VOR_OK)
        return vor_problem_error(request, err, NULL);
    begin_reply(sequence);
    return VOR_NEXT_REPLY;
}

enum vor_next vor_handle_sequence(struct vor_request *request, enum vor_step step)
{
    return step == VOR_STEP_HEAD ? begin(request) : reply(request, request->state);
}
