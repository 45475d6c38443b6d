/* The events of a job as a stream (SSE or NDJSON) and, afterwards, as a table. A slow reader gets
 * the latest progress, never a longer queue; ten times a second is enough for any. */
#include "proto/csv.h"
#include "proto/sse.h"
#include "server/api/accept.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"
#include "server/base/clock.h"
#include "server/base/metrics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BATCH = 32, RETRY_MS = 2000, RETRY_DRAIN_MS = 1000, RETRY_FULL_MS = 10000 };
enum { FEW = 64 }; /* streams; so many writes take 3 ms */
static const double progress_pause = 0.1;

struct stream {
    struct vor_app *app;
    struct vor_request *request;
    struct vor_uuid id;
    struct vor_followed followed; /* what was asked of the worker, once for the whole stream */
    struct vor_subscriber subscriber;
    struct vor_waker *waker;
    atomic_bool armed; /* progress may wake the request */
    struct vor_position position;
    bool is_replay; /* every event up to the newest at the beginning */
    bool is_lines;  /* NDJSON */
    bool began, ended;
    double sent_at, progress_at;
    struct vor_text text; /* what waits to be sent, from taken on */
    size_t taken;
};

static void release(void *state)
{
    struct stream *stream = state;

    if (stream->followed.bus != NULL)
        vor_bus_unsubscribe(stream->followed.bus, &stream->subscriber);
    vor_worker_unfollow(&stream->followed);
    (void)atomic_fetch_sub(&stream->app->streams, 1);
    vor_waker_drop(stream->waker);
    vor_text_free(&stream->text);
    free(stream);
}

/* A few streams are woken at once. Among many each waits for its turn, so that an event of a job
 * that everybody follows does not keep other requests waiting. */
static void on_event(void *ctx, enum vor_event_kind kind)
{
    struct stream *stream = ctx;

    if (kind != VOR_EVENT_END && !atomic_load(&stream->armed))
        return;
    if (atomic_load(&stream->app->streams) <= FEW)
        vor_waker_wake(stream->waker);
    else
        vor_request_wake_after(stream->request, 0);
}

/* Writes the job as it is now, but in the state that it had at the event. */
static void write_status(struct stream *stream, struct vor_request *request,
                         const struct vor_event *event, struct vor_text *text)
{
    struct vor_job_view view;

    vor_worker_followed(stream->app->worker, &stream->followed, &view);
    if (view.status != event->status) {
        view.finished = 0;
        view.message[0] = '\0';
    }
    view.status = event->status;
    view.stage = event->stage;
    view.attempt = event->attempt;
    view.progress = event->progress;
    view.updated = event->time_ms;
    vor_job_write(stream->app, request, &view, text);
}

/* How many steps a parameter allows; 0 where the process does not take it. */
static uint64_t steps_of(const struct vor_spec *spec, enum vor_parameter parameter, double steps)
{
    return vor_process_takes(spec->process, parameter) && steps > 0 ? (uint64_t)steps : 0;
}

/* maxIterations and maxPolish are older than stages: they mean something to a run that iterates and
 * polishes. */
static void write_progress(const struct stream *stream, const struct vor_event *event,
                           struct vor_text *text)
{
    const struct vor_spec *spec = &stream->followed.row.spec;

    vor_json_begin_object(text);
    vor_json_put_string(text, "jobID", stream->id.text);
    vor_json_put_u64(text, "attempt", event->attempt);
    vor_json_put_string(text, "stage", vor_stage_word(event->stage));
    vor_json_put_u64(text, "maxIterations",
                     steps_of(spec, VOR_PARAM_ITERATIONS, vor_spec_iterations(spec)));
    vor_json_put_u64(text, "maxPolish", steps_of(spec, VOR_PARAM_POLISH, vor_spec_polish(spec)));
    vor_json_members(text, &vor_record_members, &event->record);
    vor_json_put_i64(text, "progress", event->progress);
    vor_json_put_double(text, "eta", event->eta_seconds >= 0 ? event->eta_seconds : NAN);
    vor_json_end_object(text);
}

/* href and report are older than outputs, which has them all by name. */
static void write_outputs(struct stream *stream, struct vor_request *request,
                          const struct vor_artefact_info *outputs, struct vor_text *text)
{
    const struct vor_uuid *id = &stream->id;
    char url[VOR_URL_MAX];

    vor_json_put_string(text, "href",
                        vor_app_result_url(stream->app, request, id, outputs[0].name, url));
    if (vor_artefact_find(outputs, "report") != NULL)
        vor_json_put_string(text, "report",
                            vor_app_result_url(stream->app, request, id, "report", url));
    vor_json_key(text, "outputs");
    vor_json_begin_object(text);
    for (unsigned i = 0; outputs[i].name != NULL; i++)
        vor_json_put_string(text, outputs[i].name,
                            vor_app_result_url(stream->app, request, id, outputs[i].name, url));
    vor_json_end_object(text);
}

static void write_end(struct stream *stream, struct vor_request *request,
                      const struct vor_event *event, struct vor_text *text)
{
    char url[VOR_URL_MAX];

    vor_json_begin_object(text);
    vor_json_put_string(text, "jobID", stream->id.text);
    vor_json_put_string(text, "status", vor_job_status_word(event->status));
    if (event->status == VOR_JOB_SUCCESSFUL)
        write_outputs(stream, request, stream->followed.row.spec.process->outputs, text);
    else
        vor_json_put_string(text, "href",
                            vor_app_job_url(stream->app, request, &stream->id, "", url));
    vor_json_end_object(text);
}

static void write_data(struct stream *stream, struct vor_request *request,
                       const struct vor_event *event, struct vor_text *text)
{
    switch (event->kind) {
    case VOR_EVENT_PROGRESS:
        write_progress(stream, event, text);
        return;
    case VOR_EVENT_END:
        write_end(stream, request, event, text);
        return;
    case VOR_EVENT_REPLACED:
        vor_text_printf(text, "{\"attempt\":%u,\"reason\":\"%s\"}", event->attempt,
                        event->stage == VOR_STAGE_QUEUED ? "daemon-restarted" : "worker-restarted");
        return;
    case VOR_EVENT_STATUS:
    case VOR_EVENT_KINDS:
        break;
    }
    write_status(stream, request, event, text);
}

static void write_event(struct stream *stream, struct vor_request *request,
                        const struct vor_event *event)
{
    struct vor_text data;
    char id[32];

    vor_text_init(&data, 0);
    write_data(stream, request, event, &data);
    (void)snprintf(id, sizeof id, "%u.%u", event->attempt, event->number);
    if (data.failed) {
        stream->ended = true; /* out of memory: the client comes back for it */
    } else if (!stream->is_lines) {
        vor_sse_event(&stream->text, id, vor_event_word(event->kind), data.data, data.size);
    } else {
        vor_json_begin_object(&stream->text);
        vor_json_put_string(&stream->text, "event", vor_event_word(event->kind));
        vor_json_put_string(&stream->text, "id", id);
        vor_json_key(&stream->text, "data");
        vor_json_raw(&stream->text, data.data, data.size);
        vor_json_end_object(&stream->text);
        vor_text_puts(&stream->text, "\n");
    }
    vor_text_free(&data);
    if (event->kind == VOR_EVENT_END)
        stream->ended = true;
}

/* Of those from one position to the next `sent` were read. */
static void count_dropped(struct vor_position from, struct vor_position to, size_t sent)
{
    uint32_t begin = from.attempt == to.attempt && from.number <= to.number ? from.number : 0;

    if (to.number - begin > sent)
        vor_metric_add(VOR_METRIC_STREAM_DROPPED, (double)(to.number - begin - sent), NULL);
}

/* Writes the events that wait on the bus; false when there are none. */
static bool take_events(struct stream *stream, struct vor_request *request)
{
    struct vor_event events[BATCH];
    struct vor_position before = stream->position;
    size_t count =
        vor_bus_read(stream->followed.bus, &stream->position,
                     stream->is_replay ? VOR_READ_EVERY : VOR_READ_LATEST, events, BATCH);

    if (count == 0)
        stream->is_replay = false;
    for (size_t i = 0; i < count && !stream->ended; i++)
        write_event(stream, request, &events[i]);
    vor_metric_add(VOR_METRIC_STREAM_EVENTS, (double)count, NULL);
    count_dropped(before, stream->position, count);
    return count > 0;
}

static void say_goodbye(struct stream *stream, unsigned retry_ms)
{
    if (!stream->is_lines)
        vor_sse_retry(&stream->text, retry_ms);
    stream->ended = true;
}

/* Adds to the text or ends the stream; false when there is nothing to do yet. */
static bool fill(struct stream *stream, struct vor_request *request)
{
    double beat = stream->app->config->number[VOR_SET_HEARTBEAT];
    double now = vor_clock_seconds();
    double quiet = now - stream->sent_at;

    if (!stream->began) {
        stream->began = true;
        if (!stream->is_lines)
            vor_sse_retry(&stream->text, RETRY_MS);
        return true;
    }
    if (vor_request_gone(request)) {
        stream->ended = true;
        return true;
    }
    if (!stream->is_replay && now - stream->progress_at < progress_pause &&
        !vor_bus_ended(stream->followed.bus, NULL)) {
        atomic_store(&stream->armed, false);
        vor_request_wake_after(request, progress_pause);
    } else {
        atomic_store(&stream->armed, true);
        if (take_events(stream, request)) {
            stream->progress_at = stream->sent_at = now;
            return true;
        }
        vor_request_wake_after(request, beat - quiet > 0 ? beat - quiet : 0);
    }
    if (vor_request_closing(request) || atomic_load(&stream->app->draining)) {
        say_goodbye(stream, RETRY_DRAIN_MS);
        return true;
    }
    if (quiet < beat)
        return false;
    stream->sent_at = now;
    if (stream->is_lines)
        vor_text_puts(&stream->text, "\n");
    else
        vor_sse_heartbeat(&stream->text);
    return true;
}

static long read_stream(void *ctx, struct vor_request *request, char *out, size_t size)
{
    struct stream *stream = ctx;

    while (stream->taken == stream->text.size) {
        vor_text_clear(&stream->text);
        stream->taken = 0;
        if (stream->ended)
            return -1;
        if (!fill(stream, request)) {
            vor_text_free(&stream->text); /* a stream sleeps most of its life */
            return 0;
        }
    }
    if (size > stream->text.size - stream->taken)
        size = stream->text.size - stream->taken;
    memcpy(out, stream->text.data + stream->taken, size);
    stream->taken += size;
    return (long)size;
}

static struct stream *stream_create(struct vor_app *app, struct vor_request *request,
                                    const struct vor_uuid *id)
{
    struct stream *stream = calloc(1, sizeof *stream);

    if (stream == NULL)
        return NULL;
    stream->app = app;
    stream->request = request;
    stream->id = *id;
    stream->waker = vor_request_waker(request);
    stream->sent_at = vor_clock_seconds();
    stream->is_lines = vor_accepts(request, "application/x-ndjson", false);
    vor_text_init(&stream->text, 0);
    atomic_init(&stream->armed, true);
    (void)atomic_fetch_add(&app->streams, 1);
    vor_request_set_state(request, stream, release);
    return stream;
}

/* An EventSource never comes back after an error status; it does after the end of a stream. */
static enum vor_next reply_crowded(struct vor_request *request)
{
    struct vor_text text;

    vor_text_init(&text, 0);
    vor_sse_retry(&text, RETRY_FULL_MS);
    vor_reply_bytes(request, 200, "text/event-stream", text.data, text.size);
    vor_text_free(&text);
    vor_reply_close(request);
    return VOR_NEXT_REPLY;
}

enum vor_next vor_events_reply(struct vor_app *app, struct vor_request *request,
                               const struct vor_uuid *id, struct vor_position position,
                               bool is_replay)
{
    struct vor_error err;
    struct stream *stream;
    enum vor_job_outcome outcome;
    struct vor_position end;

    vor_reply_header(request, "Cache-Control", "no-store");
    vor_reply_header(request, "X-Accel-Buffering", "no");
    if (atomic_load(&app->streams) >= (unsigned)app->config->number[VOR_SET_STREAMS])
        return reply_crowded(request);
    stream = stream_create(app, request, id);
    if (stream == NULL) {
        (void)vor_fail(&err, VOR_E_NOMEM, "no memory for a stream");
        return vor_problem_error(app, request, &err, NULL);
    }
    outcome = vor_worker_follow(app->worker, id, &stream->followed, &err);
    if (outcome != VOR_DONE)
        return vor_outcome_reply(app, request, outcome, &err, id);
    if (is_replay && vor_bus_ended(stream->followed.bus, &end) && end.attempt == position.attempt &&
        end.number == position.number) {
        vor_reply_bytes(request, 204, NULL, "", 0);
        return VOR_NEXT_REPLY;
    }
    stream->position = position;
    stream->is_replay = is_replay;
    stream->subscriber = (struct vor_subscriber){.wake = on_event, .ctx = stream};
    vor_bus_subscribe(stream->followed.bus, &stream->subscriber);
    vor_reply_stream(request, 200, stream->is_lines ? "application/x-ndjson" : "text/event-stream",
                     read_stream, stream);
    return VOR_NEXT_REPLY;
}

enum vor_next vor_handle_events(void *ctx, struct vor_request *request, enum vor_step step)
{
    const char *last = vor_request_header(request, "Last-Event-ID");
    struct vor_position position = {0, 0};
    struct vor_uuid id;

    (void)step;
    if (!vor_job_of_path(ctx, request, &id))
        return VOR_NEXT_REPLY;
    if (last == NULL)
        last = vor_request_query(request, "lastEventId");
    if (last != NULL && !vor_position_parse(&position, last))
        return vor_problem_say(ctx, request, "invalid-query-parameter-value",
                               "the last event id is \"%.40s\", want ATTEMPT.NUMBER", last);
    return vor_events_reply(ctx, request, &id, position, last != NULL);
}

static void write_trace(struct vor_bus *bus, bool is_table, struct vor_text *text)
{
    struct vor_position position = {0, 0};
    struct vor_event events[BATCH];
    size_t count;

    while ((count = vor_bus_read(bus, &position, VOR_READ_EVERY, events, BATCH)) > 0) {
        for (size_t i = 0; i < count; i++) {
            if (events[i].kind != VOR_EVENT_PROGRESS)
                continue;
            if (is_table)
                vor_csv_line(text, &vor_record_members, &events[i].record);
            else
                vor_json_record(text, &events[i].record);
        }
    }
}

enum vor_next vor_handle_trace(void *ctx, struct vor_request *request, enum vor_step step)
{
    struct vor_app *app = ctx;
    bool is_table = vor_accepts(request, "text/csv", false);
    struct vor_bus *bus = NULL;
    struct vor_error err;
    struct vor_text text;
    struct vor_uuid id;
    enum vor_job_outcome outcome;

    (void)step;
    if (!vor_job_of_path(app, request, &id))
        return VOR_NEXT_REPLY;
    outcome = vor_worker_events(app->worker, &id, &bus, &err);
    if (outcome != VOR_DONE)
        return vor_outcome_reply(app, request, outcome, &err, &id);
    vor_text_init(&text, 0);
    if (is_table) {
        vor_csv_head(&text, &vor_record_members);
        write_trace(bus, true, &text);
    } else {
        vor_json_begin_object(&text);
        vor_json_put_string(&text, "jobID", id.text);
        vor_json_put_u64(&text, "attempt", vor_bus_attempt(bus));
        vor_json_key(&text, "records");
        vor_json_begin_array(&text);
        write_trace(bus, false, &text);
        vor_json_end_array(&text);
        vor_json_end_object(&text);
        vor_text_puts(&text, "\n");
    }
    vor_bus_release(bus);
    vor_reply_header(request, "Cache-Control", "no-store");
    return vor_app_reply(app, request, 200, is_table ? "text/csv" : "application/json", &text);
}
