/* A job from its upload to the answer. The head is read and refused before the body comes; the body
 * goes to a file; a thread of admission decodes it and accepts the job; then the caller gets 201, a
 * stream, or waits for the result.
 *
 * The request may be over while admission still works for it, so both hold the same struct. */
#include "server/api/handlers/submit_head.h"

#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/work/admit.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* What must stay free on the disk, so that jobs under way can end. */
static const uint64_t disk_reserve = VOR_BLOBS_RESERVE;

struct submission {
    struct vor_app *app;
    struct vor_submit_head head;
    double deadline; /* of the wait; 0 for none */
    struct vor_blob_writer *upload;
    struct vor_waker *waker;
    pthread_mutex_t lock; /* guards holds, abandoned and admitted */
    int holds;
    bool abandoned; /* nobody waits for admission any more */
    bool admitted;  /* the members below are set */
    bool settled;   /* the caller of a synchronous call got an answer */
    struct vor_admission admission;
    enum vor_job_outcome outcome;
    struct vor_error error;
    struct vor_job_view view;
    struct vor_dismissal cancel; /* once the caller has left */
    struct vor_bus *bus;         /* once a caller waits for the end */
    struct vor_subscriber subscriber;
};

static void drop(struct submission *submission)
{
    int left;

    (void)pthread_mutex_lock(&submission->lock);
    left = --submission->holds;
    (void)pthread_mutex_unlock(&submission->lock);
    if (left > 0)
        return;
    vor_blob_discard(submission->upload);
    vor_waker_drop(submission->waker);
    (void)pthread_mutex_destroy(&submission->lock);
    free(submission);
}

static void on_cancelled(struct vor_dismissal *cancel)
{
    if (cancel->outcome == VOR_FAILED)
        vor_log(VOR_LOG_WARN, "job not cancelled", VOR_TEXT("job", cancel->id.text),
                VOR_TEXT("detail", cancel->error.message));
    drop(cancel->ctx);
}

/* Nobody waits for the job any more; a thread of the worker ends it. */
static void cancel_job(struct submission *submission)
{
    submission->cancel = (struct vor_dismissal){.id = submission->admission.admitted.id,
                                                .why = "the caller left",
                                                .is_cancel = 1,
                                                .done = on_cancelled,
                                                .ctx = submission};
    (void)pthread_mutex_lock(&submission->lock);
    submission->holds++;
    (void)pthread_mutex_unlock(&submission->lock);
    vor_worker_dismiss_soon(submission->app->worker, &submission->cancel);
}

/* The request is over. The library may have seen the caller leave before we were asked again: then
 * nobody waits for the job any more. */
static void release(void *state)
{
    struct submission *submission = state;
    struct vor_app *app = submission->app;
    bool left;

    (void)pthread_mutex_lock(&submission->lock);
    submission->abandoned = true;
    left = submission->admitted && submission->outcome == VOR_DONE;
    (void)pthread_mutex_unlock(&submission->lock);
    if (submission->bus != NULL) {
        vor_bus_unsubscribe(submission->bus, &submission->subscriber);
        vor_bus_release(submission->bus);
    }
    if (left && submission->head.mode == VOR_SUBMIT_SYNC && !submission->settled &&
        !atomic_load(&app->draining))
        cancel_job(submission);
    drop(submission);
}

static int take_piece(void *ctx, const void *bytes, size_t size)
{
    struct submission *submission = ctx;
    struct vor_error err;

    if (vor_blob_append(submission->upload, bytes, size, &err) == VOR_OK)
        return 0;
    return vor_error_storage_full(&err) ? 507 : 503;
}

static struct submission *submission_create(struct vor_app *app, struct vor_request *request)
{
    struct submission *submission = calloc(1, sizeof *submission);

    if (submission == NULL)
        return NULL;
    submission->app = app;
    submission->holds = 1;
    (void)pthread_mutex_init(&submission->lock, NULL);
    submission->waker = vor_request_waker(request);
    return submission;
}

static bool check_disk(struct vor_app *app, struct vor_request *request)
{
    int64_t length = vor_request_length(request);
    uint64_t available, total;
    struct vor_error err;

    if (vor_blobs_space(app->blobs, &available, &total, &err) != VOR_OK) {
        vor_problem_error(app, request, &err, NULL);
        return false;
    }
    if (available >= disk_reserve + (length > 0 ? (uint64_t)length : 0))
        return true;
    vor_problem_say(app, request, "storage-full",
                    "%lld bytes do not fit: %llu are free, of which %llu stay so",
                    (long long)(length > 0 ? length : 0), (unsigned long long)available,
                    (unsigned long long)disk_reserve);
    return false;
}

static enum vor_next begin(struct vor_app *app, struct vor_request *request)
{
    uint64_t limit = (uint64_t)app->config->number[VOR_SET_BODY_LIMIT];
    struct vor_submit_head head;
    struct submission *submission;
    struct vor_body_sink sink;
    struct vor_error err;
    enum vor_job_outcome room;

    if (!vor_submit_read(app, request, &head))
        return VOR_NEXT_REPLY;
    room = vor_worker_room(app->worker);
    if (room != VOR_DONE)
        return vor_outcome_reply(app, request, room, NULL, NULL);
    if (head.mode == VOR_SUBMIT_STREAM &&
        atomic_load(&app->streams) >= (unsigned)app->config->number[VOR_SET_STREAMS])
        return vor_problem_say(app, request, "too-many-streams", "%.0f event streams are open",
                               app->config->number[VOR_SET_STREAMS]);
    if (vor_request_length(request) <= (int64_t)limit && !check_disk(app, request))
        return VOR_NEXT_REPLY;
    submission = submission_create(app, request);
    if (submission == NULL) {
        (void)vor_fail(&err, VOR_E_NOMEM, "no memory for a request");
        return vor_problem_error(app, request, &err, NULL);
    }
    submission->head = head;
    vor_request_set_state(request, submission, release);
    if (vor_blob_create(app->blobs, &submission->upload, &err) != VOR_OK)
        return vor_problem_error(app, request, &err, NULL);
    sink = (struct vor_body_sink){submission, take_piece};
    vor_request_take_body(request, &sink, limit);
    return VOR_NEXT_BODY;
}

/* Called on an admission thread once the upload is decoded or refused. */
static void on_admitted(struct vor_admission *admission)
{
    struct submission *submission = admission->ctx;
    struct vor_app *app = submission->app;
    bool abandoned;

    (void)pthread_mutex_lock(&submission->lock);
    abandoned = submission->abandoned;
    (void)pthread_mutex_unlock(&submission->lock);
    submission->outcome = VOR_FAILED;
    if (admission->status != VOR_OK)
        submission->error = admission->error;
    else if (abandoned)
        vor_admit_drop(app->blobs, &admission->admitted);
    else
        submission->outcome =
            vor_worker_submit(app->worker, &admission->admitted, &submission->head.spec,
                              &submission->view, &submission->error);
    (void)pthread_mutex_lock(&submission->lock);
    submission->admitted = true;
    abandoned = submission->abandoned;
    (void)pthread_mutex_unlock(&submission->lock);
    if (abandoned && submission->outcome == VOR_DONE && submission->head.mode == VOR_SUBMIT_SYNC)
        cancel_job(submission);
    vor_waker_wake(submission->waker);
    drop(submission);
}

static enum vor_next admit(struct vor_app *app, struct vor_request *request,
                           struct submission *submission)
{
    enum vor_job_outcome outcome;

    submission->admission = (struct vor_admission){
        .name = submission->head.spec.process->inputs[0].name, /* the body is the main input */
        .drop_invalid = submission->head.spec.value[VOR_PARAM_INVALID] == VOR_INVALID_DROP,
        .upload = submission->upload,
        .done = on_admitted,
        .ctx = submission};
    submission->holds++; /* nobody else has it yet */
    outcome = vor_admit_submit(app->admit, &submission->admission);
    if (outcome == VOR_DONE) {
        submission->upload = NULL;
        return VOR_NEXT_WAIT;
    }
    submission->holds--;
    return vor_outcome_reply(app, request, outcome, NULL, NULL);
}

/* Adds the address of the job, and the preferences that the reply follows; a stream follows none.
 */
static void add_job_headers(struct vor_app *app, struct vor_request *request,
                            const struct submission *submission, bool is_async)
{
    const struct vor_submit_head *head = &submission->head;
    bool waited = head->wait_seconds >= 0 && head->mode == VOR_SUBMIT_SYNC;
    char url[VOR_URL_MAX];
    char applied[48];
    int length = 0;

    vor_reply_header(request, "Location",
                     vor_app_job_url(app, request, &submission->view.id, "", url));
    applied[0] = '\0';
    if (is_async && head->is_async)
        length = snprintf(applied, sizeof applied, "respond-async%s", waited ? ", " : "");
    if (waited)
        (void)snprintf(applied + length, sizeof applied - (size_t)length, "wait=%.0f",
                       head->wait_seconds);
    if (applied[0] != '\0')
        vor_reply_header(request, "Preference-Applied", applied);
}

static enum vor_next reply_accepted(struct vor_app *app, struct vor_request *request,
                                    struct submission *submission)
{
    struct vor_job_view view = submission->view;
    struct vor_error err;
    struct vor_text text;

    submission->settled = true;
    /* The job as it is now, or as it was accepted when the row cannot be read. */
    if (vor_worker_get(app->worker, &submission->view.id, &view, &err) != VOR_DONE)
        view = submission->view;
    add_job_headers(app, request, submission, true);
    vor_reply_header(request, "Cache-Control", "no-store");
    vor_text_init(&text, 0);
    vor_job_write(app, request, &view, &text);
    vor_text_puts(&text, "\n");
    return vor_app_reply(app, request, 201, "application/json", &text);
}

static void on_event(void *ctx, enum vor_event_kind kind)
{
    if (kind == VOR_EVENT_END)
        vor_waker_wake(ctx);
}

/* Answers a caller who has waited for the end of the job. */
static enum vor_next reply_ended(struct vor_app *app, struct vor_request *request,
                                 struct submission *submission)
{
    struct vor_job_view view;
    struct vor_error err;
    enum vor_job_outcome outcome = vor_worker_get(app->worker, &submission->view.id, &view, &err);

    submission->settled = true;
    add_job_headers(app, request, submission, false);
    if (outcome != VOR_DONE)
        return vor_outcome_reply(app, request, outcome, &err, &submission->view.id);
    if (view.status != VOR_JOB_SUCCESSFUL)
        return vor_result_missing(app, request, &view);
    return vor_result_whole(app, request, &view);
}

static enum vor_next wait_for_end(struct vor_app *app, struct vor_request *request,
                                  struct submission *submission)
{
    double left = submission->deadline - vor_clock_seconds();

    if (vor_bus_ended(submission->bus, NULL))
        return reply_ended(app, request, submission);
    if (vor_request_gone(request))
        return vor_problem_say(app, request, "client-closed", "the caller left");
    if (vor_request_closing(request)) {
        submission->settled = true;
        add_job_headers(app, request, submission, false);
        return vor_problem_say(app, request, "draining",
                               "the daemon is going down; the job goes on when it is back");
    }
    if (submission->deadline > 0) {
        if (left <= 0)
            return reply_accepted(app, request, submission);
        vor_request_wake_after(request, left);
    }
    return VOR_NEXT_WAIT;
}

static enum vor_next start_wait(struct vor_app *app, struct vor_request *request,
                                struct submission *submission)
{
    enum vor_job_outcome outcome =
        vor_worker_events(app->worker, &submission->view.id, &submission->bus, &submission->error);

    if (outcome != VOR_DONE)
        return vor_outcome_reply(app, request, outcome, &submission->error, &submission->view.id);
    submission->subscriber = (struct vor_subscriber){.wake = on_event, .ctx = submission->waker};
    vor_bus_subscribe(submission->bus, &submission->subscriber);
    if (submission->head.wait_seconds >= 0)
        submission->deadline = vor_clock_seconds() + submission->head.wait_seconds;
    return wait_for_end(app, request, submission);
}

static enum vor_next accepted(struct vor_app *app, struct vor_request *request,
                              struct submission *submission)
{
    struct vor_uuid id = submission->view.id;

    if (submission->outcome == VOR_FAILED && submission->error.status == VOR_E_CANCELLED)
        submission->outcome = VOR_DRAINING;
    if (submission->outcome != VOR_DONE)
        return vor_outcome_reply(app, request, submission->outcome, &submission->error, NULL);
    vor_request_set_job(request, id.text);
    switch (submission->head.mode) {
    case VOR_SUBMIT_ASYNC:
        return reply_accepted(app, request, submission);
    case VOR_SUBMIT_STREAM:
        add_job_headers(app, request, submission, false);
        return vor_events_reply(app, request, &id, (struct vor_position){0, 0}, false);
    case VOR_SUBMIT_SYNC:
        break;
    }
    return start_wait(app, request, submission);
}

enum vor_next vor_handle_submit(void *ctx, struct vor_request *request, enum vor_step step)
{
    struct vor_app *app = ctx;
    struct submission *submission = vor_request_state(request);
    bool admitted;

    if (step == VOR_STEP_HEAD)
        return begin(app, request);
    if (step == VOR_STEP_BODY)
        return admit(app, request, submission);
    (void)pthread_mutex_lock(&submission->lock);
    admitted = submission->admitted;
    (void)pthread_mutex_unlock(&submission->lock);
    if (submission->bus != NULL)
        return wait_for_end(app, request, submission);
    if (admitted)
        return accepted(app, request, submission);
    if (vor_request_gone(request))
        return vor_problem_say(app, request, "client-closed", "the caller left");
    if (vor_request_closing(request))
        return vor_problem_say(app, request, "draining", "the daemon is going down");
    return VOR_NEXT_WAIT;
}
