/* The events of jobs as a stream (SSE or NDJSON): of one job, or of several together. A slow reader
 * gets the latest progress, never a longer queue; ten times a second is enough for any. With
 * "Prefer: wait=N" it is a long poll instead, an answer like any other that counts as no stream.
 *
 * A stream goes around its jobs and sends a few events of one after the other. What it holds of
 * each is a position and, while it is live, a reference. The latest events of a live job are at
 * hand; all others are read from the store by another thread, a batch at a time. */
#include "proto/sse.h"
#include "server/api/accept.h"
#include "server/api/auth.h"
#include "server/api/handlers/event_text.h"
#include "server/api/handlers/events_query.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/base/clock.h"
#include "server/base/metrics.h"
#include "server/http/deferred.h"

#include <stdlib.h>
#include <string.h>

enum { BATCH = 32, RETRY_MS = 2000, RETRY_DRAIN_MS = 1000, WEIGHT = 1000 };
enum { FEW = 64 };                 /* streams; so many writes take 3 ms */
enum { ANSWER_BYTES = 256 << 10 }; /* of a poll, about: 500 events; who wants more asks again */
static const double progress_pause = 0.1;

/* One job of a stream. */
struct track {
    struct vor_uuid id;
    struct vor_job *job; /* NULL as long as nobody has looked, and when it is not live */
    struct vor_position position;
    struct vor_subscriber subscriber;
    bool is_replay; /* every event up to the newest at the beginning */
    bool is_over;
    bool is_looking;  /* at the points as they move */
    uint64_t version; /* of the preview told last */
};

struct stream {
    struct vor_deferred deferred; /* first; the look-up of a job, or of events */
    struct vor_app *app;
    struct vor_request *request;
    struct vor_task task;
    char tenant[VOR_JOB_PRINCIPAL_SIZE]; /* whose jobs they are; "" for anybody's */
    bool is_looking_up;                  /* what follows is the look-up's */
    enum vor_job_outcome outcome;
    struct vor_error error;
    struct vor_followed followed;  /* of the track whose turn it is, which has the reference */
    struct vor_event_batch batch;  /* its next events */
    bool is_read;                  /* they are there */
    const struct track *described; /* that track */
    bool is_new;                   /* its job is looked up as well as its events */
    bool is_found;                 /* the job of a stream of one is */
    atomic_bool armed;             /* progress may wake the request */
    bool is_many;                  /* ids have the positions of all jobs */
    struct vor_teller teller;      /* of `followed` */
    bool began, ended;
    bool has_told;         /* of what happened; that points move is not enough to end a poll */
    double wait, deadline; /* of a poll: seconds, and when they are over; wait is -1 for a stream */
    double sent_at, progress_at;
    struct vor_text text; /* what waits to be sent, from taken on */
    size_t taken;
    size_t preview;     /* points of previews at most; 0: none are wanted */
    unsigned at, count; /* whose turn it is, of how many */
    struct vor_event events[BATCH];
    struct track tracks[];
};

/* Lets go of a track's job: it is over, or the stream is. */
static void leave(struct track *track)
{
    if (track->is_looking)
        vor_preview_look_away(vor_job_preview(track->job));
    track->is_looking = false;
    vor_job_unsubscribe(track->job, &track->subscriber);
    vor_job_release(track->job);
    track->job = NULL;
    track->is_over = true;
}

/* The last hold is given back: that of the request, or of a look-up that outlived it. */
static void free_stream(struct vor_deferred *deferred)
{
    struct stream *stream = (struct stream *)deferred;

    if (stream->is_looking_up)
        vor_job_release(stream->followed.job);
    vor_text_free(&stream->text);
    free(stream);
}

/* The request is over, and is not to be woken any more. */
static void end_stream(struct vor_deferred *deferred)
{
    struct stream *stream = (struct stream *)deferred;

    for (unsigned i = 0; i < stream->count; i++)
        leave(&stream->tracks[i]);
    if (stream->wait < 0)
        (void)atomic_fetch_sub(&stream->app->streams, 1);
}

/* A few streams are woken at once. Among many each waits for its turn, so that an event of a job
 * that everybody follows does not keep other requests waiting. */
static void on_event(void *ctx, enum vor_event_kind kind)
{
    struct stream *stream = ctx;

    if (kind != VOR_EVENT_END && !atomic_load(&stream->armed))
        return;
    if (atomic_load(&stream->app->streams) <= FEW)
        vor_waker_wake(stream->deferred.waker);
    else
        vor_request_wake_after(stream->request, 0);
}

/* Takes what was looked up: begins to follow a job that is live. */
static enum vor_job_outcome take_found(struct stream *stream, struct track *track)
{
    stream->is_looking_up = false;
    if (stream->outcome != VOR_DONE || stream->followed.job == NULL)
        return stream->outcome;
    track->job = stream->followed.job;
    track->subscriber = (struct vor_subscriber){.wake = on_event, .ctx = stream};
    vor_job_subscribe(track->job, &track->subscriber);
    track->is_looking = stream->preview > 0;
    if (track->is_looking)
        vor_preview_look(vor_job_preview(track->job));
    return VOR_DONE;
}

/* Reads what the store has of the track's next events, and before that, where nobody has looked
 * yet, its job: one of another caller's is unknown. The latest events of one that is live are read
 * once it is subscribed to. */
static void look_up(void *ctx)
{
    struct stream *stream = ctx;
    struct vor_job_service *service = stream->app->service;

    stream->outcome = VOR_DONE;
    if (stream->is_new)
        stream->outcome = vor_job_service_follow(service, &stream->described->id,
                                                 stream->tenant[0] != '\0' ? stream->tenant : NULL,
                                                 &stream->followed, &stream->error);
    if (stream->outcome != VOR_DONE || stream->followed.job != NULL)
        return;
    stream->is_read = vor_job_service_stored_events(service, &stream->followed.row, &stream->batch,
                                                    &stream->error) == VOR_OK;
    stream->outcome = stream->is_read ? VOR_DONE : VOR_FAILED;
}

/* On a thread that reads the store. */
static void run_look_up(void *ctx)
{
    look_up(ctx);
    vor_deferred_complete(ctx);
}

/* What is read next is the track's. */
static void turn_to(struct stream *stream, const struct track *track)
{
    stream->is_new = track->job == NULL && stream->described != track;
    stream->described = track;
    stream->followed.job = track->job;
    if (track->job != NULL)
        vor_job_view(track->job, &stream->followed.row);
    stream->batch = (struct vor_event_batch){
        .position = track->position,
        .how = track->is_replay || stream->wait >= 0 ? VOR_READ_EVERY : VOR_READ_LATEST,
        .events = stream->events,
        .max = BATCH};
}

/* Has it looked up: VOR_DONE, and the request is woken then, or why not. */
static enum vor_job_outcome begin_look_up(struct stream *stream)
{
    enum vor_job_outcome outcome;

    stream->followed.job = NULL; /* a reference is the look-up's own */
    stream->task = (struct vor_task){.run = run_look_up, .weight = WEIGHT};
    outcome = vor_read_begin(stream->request, &stream->deferred, &stream->task, &stream->error);
    stream->is_looking_up = outcome == VOR_DONE;
    return outcome;
}

/* Turns to a track and reads its next events; false where they, or its job, are in the store. */
static bool read_latest(struct stream *stream, const struct track *track)
{
    turn_to(stream, track);
    stream->is_read = track->job != NULL && vor_job_read(track->job, &stream->batch);
    return stream->is_read;
}

/* The track's job is over. */
static void end_turns(struct stream *stream, struct track *track)
{
    leave(track);
    stream->described = NULL;
}

/* The id of an event of the track whose turn it is: its position or, where the stream has several
 * jobs, that of each, in the order that they were asked for. */
static void write_id(const struct stream *stream, const char *own, char *out, size_t size)
{
    size_t at = 0;

    if (!stream->is_many) {
        (void)snprintf(out, size, "%s", own);
        return;
    }
    for (unsigned i = 0; i < stream->count && at < size; i++) {
        const struct track *track = &stream->tracks[i];
        const char *comma = i > 0 ? "," : "";

        if (i == stream->at)
            at += (size_t)snprintf(out + at, size - at, "%s%s", comma, own);
        else if (track->is_over)
            at += (size_t)snprintf(out + at, size - at, "%s" VOR_POSITION_END, comma);
        else
            at += (size_t)snprintf(out + at, size - at, "%s%u.%u", comma, track->position.attempt,
                                   track->position.number);
    }
}

/* Tells that the points have moved, if somebody wants to know and they have; false else. */
static bool take_preview(struct stream *stream, struct track *track)
{
    struct vor_preview_info info = {.version = 0};

    if (track->is_looking)
        vor_preview_describe(vor_job_preview(track->job), &info);
    if (info.version == track->version || info.version == 0)
        return false;
    track->version = info.version;
    if (!vor_event_tell_preview(&stream->teller, &info, stream->preview, &stream->text))
        stream->ended = true;
    return true;
}

static void say_goodbye(struct stream *stream, unsigned retry_ms)
{
    if (!stream->teller.is_lines)
        vor_sse_retry(&stream->text, retry_ms);
    stream->ended = true;
}

/* Writes the events of a track that were read; false when there are none. */
static bool take_events(struct stream *stream, struct track *track)
{
    const struct vor_event *events = stream->events;
    size_t count = stream->batch.count;
    struct vor_position before = track->position;
    bool has_preview = take_preview(stream, track); /* an end may follow */

    stream->is_read = false;
    stream->followed.job = track->job;
    track->position = stream->batch.position;
    if (count == 0)
        track->is_replay = false;
    for (size_t i = 0; i < count && !stream->ended && !track->is_over; i++) {
        bool is_end = events[i].kind == VOR_EVENT_END;
        char own[VOR_POSITION_SIZE], id[VOR_EVENT_JOBS_MAX * VOR_POSITION_SIZE];

        if (is_end && stream->is_many)
            (void)snprintf(own, sizeof own, VOR_POSITION_END);
        else
            (void)snprintf(own, sizeof own, "%u.%u", events[i].attempt, events[i].number);
        write_id(stream, own, id, sizeof id);
        stream->has_told = true;
        if (!vor_event_tell(&stream->teller, &events[i], id, &stream->text))
            stream->ended = true; /* out of memory: the client comes back for it */
        if (is_end)
            end_turns(stream, track);
    }
    vor_events_count_dropped(before, track->position, count);
    count += has_preview;
    vor_metric_add(VOR_METRIC_STREAM_EVENTS, (double)count, NULL);
    return count > 0;
}

/* The same for one that may have to be looked up first, or its events: then false as well. */
static bool take_turn(struct stream *stream, struct track *track)
{
    char id[VOR_EVENT_JOBS_MAX * VOR_POSITION_SIZE];
    struct vor_text data;
    enum vor_job_outcome outcome = VOR_DONE;

    if (stream->is_looking_up)
        outcome = take_found(stream, track);
    if (outcome == VOR_DONE && !stream->is_read && !read_latest(stream, track)) {
        outcome = begin_look_up(stream);
        if (outcome == VOR_DONE)
            return false;
    }
    if (outcome == VOR_UNKNOWN) {
        /* There is no such job, or none of this caller; the other jobs go on. */
        write_id(stream, VOR_POSITION_END, id, sizeof id);
        vor_text_init(&data, 0);
        vor_json_begin_object(&data);
        vor_json_put_string(&data, "jobID", track->id.text);
        vor_json_end_object(&data);
        stream->has_told = true;
        if (!vor_event_frame(&stream->teller, "unknown", id, &data, &stream->text))
            stream->ended = true;
        vor_text_free(&data);
        end_turns(stream, track);
        return true;
    }
    if (outcome == VOR_DONE && take_events(stream, track))
        return true;
    if (outcome == VOR_DONE && (track->job != NULL || !stream->is_many))
        return false;
    say_goodbye(stream, RETRY_MS); /* the store fails, or the daemon is about to end: come back */
    return true;
}

/* Goes on around the tracks up to one that has something to say; false once none of the rest has,
 * or one is looked up. A track keeps its turn while it catches up. */
static bool take_round(struct stream *stream)
{
    if (stream->is_looking_up && !vor_deferred_is_done(&stream->deferred))
        return false;
    if (stream->is_looking_up)
        stream->at = (unsigned)(stream->described - stream->tracks);
    for (; stream->at < stream->count; stream->at++) {
        struct track *track = &stream->tracks[stream->at];

        if (track->is_over)
            continue;
        if (!take_turn(stream, track)) {
            if (stream->is_looking_up)
                return false;
            continue;
        }
        if (track->is_over || (!track->is_replay && track->job != NULL))
            stream->at++;
        return true;
    }
    return false;
}

static bool is_done(const struct stream *stream)
{
    for (unsigned i = 0; i < stream->count; i++)
        if (!stream->tracks[i].is_over)
            return false;
    return true;
}

/* True when there is more to say than progress: some job has not been looked at, catches up, or has
 * come to its end. */
static bool is_urgent(const struct stream *stream)
{
    for (unsigned i = 0; i < stream->count; i++) {
        const struct track *track = &stream->tracks[i];

        if (!track->is_over &&
            (track->job == NULL || track->is_replay || vor_job_is_over(track->job)))
            return true;
    }
    return false;
}

/* The events that wait; false when there are none, or they are to wait. Then the request is woken
 * in time. */
static bool fill_events(struct stream *stream, double now, double beat_in)
{
    if (stream->at >= stream->count) { /* all have had their turn */
        stream->at = 0;
        if (now - stream->progress_at < progress_pause && !is_urgent(stream)) {
            atomic_store(&stream->armed, false);
            vor_request_wake_after(stream->request, progress_pause);
            stream->at = stream->count;
            return false;
        }
    }
    atomic_store(&stream->armed, true);
    if (take_round(stream)) {
        stream->progress_at = stream->sent_at = now;
        stream->ended = stream->ended || is_done(stream);
        return true;
    }
    vor_request_wake_after(stream->request, beat_in > 0 ? beat_in : 0);
    return false;
}

/* Adds to the text or ends the stream; false when there is nothing to do yet. */
static bool fill(struct stream *stream, struct vor_request *request)
{
    double beat = stream->app->config->number[VOR_SET_HEARTBEAT];
    double now = vor_clock_seconds();
    double quiet = now - stream->sent_at;

    if (!stream->began) {
        stream->began = true;
        if (!stream->teller.is_lines)
            vor_sse_retry(&stream->text, RETRY_MS);
        return true;
    }
    stream->ended = vor_request_gone(request);
    if (stream->ended || fill_events(stream, now, beat - quiet))
        return true;
    if (vor_request_closing(request) || atomic_load(&stream->app->draining)) {
        say_goodbye(stream, RETRY_DRAIN_MS);
        return true;
    }
    if (quiet < beat)
        return false;
    stream->sent_at = now;
    if (stream->teller.is_lines)
        vor_text_puts(&stream->text, "\n");
    else
        vor_sse_heartbeat(&stream->text);
    return true;
}

static long read_stream(struct vor_request *request, char *out, size_t size)
{
    struct stream *stream = request->state;

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

/* A stream of the jobs that are asked for; NULL after a reply. */
static struct stream *stream_create(struct vor_request *request, const struct vor_events_query *ask)
{
    struct vor_app *app = request->app;
    const char *tenant = vor_auth_tenant(request);
    struct stream *stream;

    vor_reply_header(request, "Cache-Control", "no-store");
    vor_reply_header(request, "X-Accel-Buffering", "no");
    if (ask->wait < 0 &&
        atomic_load(&app->streams) >= (unsigned)app->config->number[VOR_SET_STREAMS]) {
        vor_events_reply_crowded(request);
        return NULL;
    }
    stream = calloc(1, sizeof *stream + ask->count * sizeof stream->tracks[0]);
    if (stream == NULL) {
        vor_problem_no_memory(request);
        return NULL;
    }
    stream->app = app;
    stream->request = request;
    stream->sent_at = vor_clock_seconds();
    stream->teller = (struct vor_teller){request, &stream->followed,
                                         vor_accepts(request, "application/x-ndjson")};
    stream->is_many = ask->is_many;
    (void)snprintf(stream->tenant, sizeof stream->tenant, "%s", tenant != NULL ? tenant : "");
    stream->preview = ask->preview;
    stream->wait = ask->wait;
    stream->deadline = stream->sent_at + ask->wait;
    stream->count = ask->count;
    for (unsigned i = 0; i < ask->count; i++)
        stream->tracks[i] = (struct track){.id = ask->jobs[i].id,
                                           .position = ask->jobs[i].position,
                                           .is_replay = ask->is_replay,
                                           .is_over = ask->jobs[i].is_over};
    vor_text_init(&stream->text, 0);
    atomic_init(&stream->armed, true);
    if (stream->wait < 0)
        (void)atomic_fetch_add(&app->streams, 1);
    vor_deferred_begin(&stream->deferred, request, free_stream);
    stream->deferred.over = end_stream;
    return stream;
}

static const char *media_type(const struct stream *stream)
{
    return stream->teller.is_lines ? "application/x-ndjson" : "text/event-stream";
}

/* Answers a poll with what has happened, or waits for it. */
static enum vor_next answer_poll(struct vor_request *request)
{
    struct stream *stream = request->state;
    double left = stream->deadline - vor_clock_seconds();
    char applied[32];
    bool is_part;

    do { /* a round that went on where something was looked up has left out who is before that */
        is_part = stream->is_looking_up;
        stream->at = 0;
        while (!stream->ended && stream->text.size < ANSWER_BYTES && take_round(stream))
            continue;
    } while (is_part && !stream->is_looking_up);
    if (((!stream->has_told && left > 0) || stream->is_looking_up) && !stream->ended &&
        !vor_request_gone(request) && !vor_request_closing(request) &&
        !atomic_load(&request->app->draining)) {
        if (!stream->is_looking_up)
            vor_request_wake_after(request, left);
        return VOR_NEXT_WAIT;
    }
    (void)snprintf(applied, sizeof applied, "wait=%.0f", stream->wait);
    vor_reply_header(request, "Preference-Applied", applied);
    vor_text_puts(&stream->text, ""); /* so that there is one, which may be empty */
    return vor_app_reply(request, 200, media_type(stream), &stream->text);
}

static enum vor_next reply_stream(struct vor_request *request)
{
    struct stream *stream = request->state;

    if (stream->wait >= 0)
        return answer_poll(request);
    vor_reply_stream(request, 200, media_type(stream), VOR_LENGTH_UNKNOWN, read_stream);
    return VOR_NEXT_REPLY;
}

/* The stream of one job, once that was looked up: whether there is one is told before it begins. */
static enum vor_next reply_found(struct vor_request *request)
{
    struct stream *stream = request->state;
    struct track *track = &stream->tracks[0];
    enum vor_job_outcome outcome = take_found(stream, track);

    if (outcome != VOR_DONE)
        return vor_outcome_reply(request, outcome, &stream->error, &track->id);
    stream->is_found = true;
    return track->is_replay && vor_job_status_over(stream->followed.row.status) &&
                   (stream->is_read || read_latest(stream, track)) && stream->batch.count == 0
               ? vor_events_reply_nothing(request)
               : reply_stream(request);
}

enum vor_next vor_events_reply(struct vor_request *request, const struct vor_uuid *id)
{
    struct vor_events_query ask = {.count = 1, .wait = -1};
    struct stream *stream;

    ask.jobs[0].id = *id;
    stream = stream_create(request, &ask);
    if (stream == NULL)
        return VOR_NEXT_REPLY;
    turn_to(stream, &stream->tracks[0]);
    stream->is_looking_up = true;
    look_up(stream); /* it was accepted just now: there is hardly anything to read */
    return reply_found(request);
}

enum vor_next vor_handle_events(struct vor_request *request, enum vor_step step)
{
    struct vor_events_query ask = {.count = 1};
    struct stream *stream = request->state;
    enum vor_job_outcome outcome;

    if (step == VOR_STEP_WAKE && stream->is_found)
        return answer_poll(request);
    if (step == VOR_STEP_WAKE)
        return vor_deferred_is_done(&stream->deferred) ? reply_found(request)
                                                       : vor_problem_or_wait(request);
    if (!vor_job_of_path(request, &ask.jobs[0].id) || !vor_events_query_one(request, &ask))
        return VOR_NEXT_REPLY;
    stream = stream_create(request, &ask);
    if (stream == NULL)
        return VOR_NEXT_REPLY;
    turn_to(stream, &stream->tracks[0]);
    outcome = begin_look_up(stream);
    return outcome == VOR_DONE ? VOR_NEXT_WAIT
                               : vor_outcome_reply(request, outcome, &stream->error, NULL);
}

enum vor_next vor_handle_events_of_many(struct vor_request *request, enum vor_step step)
{
    struct vor_events_query ask;
    struct stream *stream;

    if (step == VOR_STEP_WAKE)
        return answer_poll(request);
    if (!vor_events_query_many(request, &ask))
        return VOR_NEXT_REPLY;
    stream = stream_create(request, &ask);
    if (stream == NULL)
        return VOR_NEXT_REPLY;
    return is_done(stream) ? vor_events_reply_nothing(request) : reply_stream(request);
}
