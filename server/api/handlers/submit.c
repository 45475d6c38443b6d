/* A job from its upload to the answer. The head is read and refused before the body comes; the body
 * goes to a file, or to one for each file of a form, or is JSON and refused; the request waits for
 * the end of the job that it goes on from (previous=job:ID), if it has one; a thread of admission
 * decodes it and accepts the job; then the caller gets 201, a stream, or waits for the result.
 *
 * The request may be over while admission still works for it, so both hold the same struct.
 *
 * A request with a key holds it until its job has a row. Its job goes on when the caller leaves,
 * because the caller can come back: the same request again gets the same job. */
#include "server/api/handlers/submission.h"

#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/limits.h"
#include "server/api/links.h"
#include "server/api/problem.h"
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/metrics.h"
#include "server/http/deferred.h"

#include <stdio.h>
#include <stdlib.h>

struct submission {
    struct vor_deferred deferred; /* first; done once the upload is admitted or refused */
    struct vor_app *app;
    struct vor_submit_head head;
    struct vor_quota quota; /* of the key */
    struct vor_span span;
    double deadline;              /* of the wait; 0 for none */
    struct vor_submit_form *form; /* NULL when the body is none */
    struct vor_text json;         /* likewise */
    struct vor_uploads uploads;
    atomic_flag cancels; /* the job is being cancelled */
    bool settled;        /* the caller of a synchronous call got an answer */
    bool in_flight;      /* the key is ours */
    bool booked;         /* a place in the queue is kept, until admission is over */
    bool replayed;       /* the job is that of an earlier request with this key */
    bool packed;         /* an upload came as gzip: its key's job is found once it is inflated */
    bool headed;         /* the reply has its headers already */
    bool follows;        /* waits for the end of the job that it goes on from, or its files */
    bool waits;          /* for the end of the job */
    struct vor_admission admission;
    enum vor_job_outcome outcome;
    struct vor_error error;
    struct vor_job_view view;
    struct vor_dismissal cancel; /* once the caller has left */
    struct vor_job *job;         /* of whose end the request is told, its own or before that the one
                                    it goes on from; NULL: it is over */
    struct vor_subscriber subscriber;
};

static bool has_key(const struct submission *submission)
{
    return submission->head.options.key.text[0] != '\0';
}

/* By the threads that work for the request, one at a time. */
static void end_flight(struct submission *submission)
{
    if (submission->in_flight)
        vor_inflight_end(submission->app->inflight, &submission->head.options.key);
    submission->in_flight = false;
}

static void free_submission(struct vor_deferred *deferred)
{
    struct submission *submission = (struct submission *)deferred;

    end_flight(submission);
    vor_submit_form_free(submission->form);
    vor_text_free(&submission->json);
    vor_uploads_discard(&submission->uploads);
    free(submission);
}

static void on_cancelled(struct vor_dismissal *cancel)
{
    if (cancel->outcome == VOR_FAILED)
        vor_log(VOR_LOG_WARN, "job not cancelled", VOR_TEXT("job", cancel->id.text),
                VOR_TEXT("detail", cancel->error.message));
    vor_deferred_cancel(cancel->ctx);
}

/* A synchronous caller without a key is gone for good, so nobody waits for the job any more: a
 * thread of the job service ends it. Called when the request is over and when the job is accepted;
 * the later of the two cancels it. */
static void cancel_if_left(struct submission *submission)
{
    if (!atomic_load(&submission->deferred.is_over) ||
        !vor_deferred_is_done(&submission->deferred) || submission->outcome != VOR_DONE ||
        submission->head.mode != VOR_SUBMIT_SYNC || submission->settled || has_key(submission) ||
        atomic_load(&submission->app->draining) || atomic_flag_test_and_set(&submission->cancels))
        return;
    submission->cancel = (struct vor_dismissal){.id = submission->admission.admitted.id,
                                                .caller = submission->admission.caller,
                                                .why = "the client disconnected",
                                                .is_cancel = 1,
                                                .done = on_cancelled,
                                                .ctx = &submission->deferred};
    vor_deferred_retain(&submission->deferred);
    vor_job_service_dismiss_soon(submission->app->service, &submission->cancel);
}

static void on_over(struct vor_deferred *deferred)
{
    struct submission *submission = (struct submission *)deferred;

    vor_job_unsubscribe(submission->job, &submission->subscriber);
    vor_job_release(submission->job);
    cancel_if_left(submission);
}

static int take_piece(void *ctx, const void *bytes, size_t size)
{
    struct submission *submission = ctx;
    struct vor_error err;

    vor_metric_add(VOR_METRIC_UPLOAD_BYTES, (double)size, NULL);
    if (vor_blob_append(submission->uploads.item[0].bytes, bytes, size, &err) == VOR_OK)
        return 0;
    return vor_error_storage_full(&err) ? 507 : 503;
}

static int take_json(void *ctx, const void *bytes, size_t size)
{
    vor_text_add(ctx, bytes, size);
    return 0; /* what does not fit is found at the end; the limit of the body comes first */
}

/* Where the body goes; false after a problem has been replied. */
static bool open_sink(struct vor_request *request, struct submission *submission,
                      struct vor_body_sink *sink)
{
    const struct vor_submit_head *head = &submission->head;
    const char *name = head->spec.process->inputs[0].name; /* the main input */
    vor_status status = VOR_OK;
    struct vor_error err;

    switch (head->body) {
    case VOR_SUBMIT_FORM:
        submission->form = vor_submit_form_begin(request, &submission->head, &submission->uploads);
        *sink = (struct vor_body_sink){submission->form, vor_submit_form_take};
        return submission->form != NULL;
    case VOR_SUBMIT_JSON:
        vor_text_init(&submission->json, VOR_JSON_SIZE_MAX);
        *sink = (struct vor_body_sink){&submission->json, take_json};
        return true;
    case VOR_SUBMIT_CLOUD:
        break;
    }
    *sink = (struct vor_body_sink){submission, take_piece};
    if (head->options.input.text[0] == '\0')
        status =
            vor_uploads_begin(&submission->uploads, name, head->is_gzip, request->app->blobs, &err);
    else if (request->length != 0)
        status = vor_fail_param(&err, VOR_E_PARAM, "input",
                                "input is job:%s, but the body also has a cloud; send only one "
                                "input",
                                head->options.input.text);
    if (status != VOR_OK)
        vor_problem_error(request, &err, NULL);
    return status == VOR_OK;
}

static enum vor_next begin(struct vor_request *request)
{
    struct vor_app *app = request->app;
    enum vor_job_outcome outcome = VOR_DONE;
    uint64_t limit = (uint64_t)app->config->number[VOR_SET_BODY_LIMIT];
    struct vor_submit_head head;
    struct submission *submission;
    struct vor_body_sink sink;

    if (!vor_limits_rate(request) || !vor_submit_read(request, &head))
        return VOR_NEXT_REPLY;
    if (head.body == VOR_SUBMIT_JSON)
        limit = limit < VOR_JSON_SIZE_MAX ? limit : VOR_JSON_SIZE_MAX;
    else if (!vor_submit_has_room(request, &head))
        return VOR_NEXT_REPLY;
    submission = calloc(1, sizeof *submission);
    if (submission == NULL)
        return vor_problem_no_memory(request);
    submission->app = app;
    atomic_flag_clear(&submission->cancels);
    submission->head = head;
    submission->quota = request->principal.quota;
    submission->span = request->span;
    submission->deferred.over = on_over;
    vor_deferred_begin(&submission->deferred, request, free_submission);
    if (has_key(submission))
        outcome = vor_inflight_begin(app->inflight, &submission->head.options.key);
    if (outcome == VOR_CONFLICT)
        return vor_problem_say(request, "idempotency-in-flight",
                               "a request with Idempotency-Key %s is in progress; try again later",
                               submission->head.options.key.text);
    if (outcome != VOR_DONE)
        return vor_problem_no_memory(request);
    submission->in_flight = has_key(submission);
    if (!open_sink(request, submission, &sink))
        return VOR_NEXT_REPLY;
    vor_request_take_body(request, &sink, limit);
    return VOR_NEXT_BODY;
}

static void on_event(void *ctx, enum vor_event_kind kind)
{
    if (kind == VOR_EVENT_END)
        vor_waker_wake(ctx);
}

/* Has the request told of the end of a job. One that is over has no live job. */
static enum vor_job_outcome subscribe(struct vor_app *app, const char *tenant,
                                      struct submission *submission, const struct vor_uuid *id)
{
    struct vor_followed followed;
    enum vor_job_outcome outcome =
        vor_job_service_follow(app->service, id, tenant, &followed, &submission->error);

    if (outcome != VOR_DONE)
        return outcome;
    submission->subscriber =
        (struct vor_subscriber){.wake = on_event, .ctx = submission->deferred.waker};
    submission->job = followed.job;
    vor_job_subscribe(submission->job, &submission->subscriber);
    return outcome;
}

/* Whether nobody waits for admission any more; who has a key can come back. */
static int has_left(void *ctx)
{
    const struct submission *submission = ctx;

    return !has_key(submission) && vor_deferred_is_left(&submission->deferred);
}

/* Whether the job of the key is there already, or cannot be looked for; sets the outcome then. */
static bool is_settled(struct submission *submission)
{
    struct vor_submit_inputs inputs;
    enum vor_job_outcome outcome;

    if (!has_key(submission) || !submission->packed)
        return false;
    vor_submit_inputs_of_admitted(&inputs, &submission->admission.admitted);
    outcome =
        vor_submit_options_find(&submission->head.options, submission->app, &submission->head.spec,
                                &inputs, &submission->view, &submission->error);
    if (outcome == VOR_UNKNOWN)
        return false;
    submission->replayed = outcome == VOR_DONE;
    submission->outcome = outcome;
    return true;
}

/* Called on an admission thread once the upload is decoded or refused. */
static void on_admitted(struct vor_admission *admission)
{
    struct submission *submission = admission->ctx;
    struct vor_app *app = submission->app;
    const struct vor_job_label label = {.name = submission->head.options.name,
                                        .key = &submission->head.options.key,
                                        .span = &submission->span,
                                        .jobs_max = (uint64_t)submission->quota.jobs,
                                        .bytes_max = (uint64_t)submission->quota.bytes,
                                        .points_max = (uint64_t)submission->quota.points,
                                        .booked = submission->booked};
    bool is_left = atomic_load(&submission->deferred.is_over) && !has_key(submission);
    bool submitted = false;

    submission->outcome = VOR_FAILED;
    if (admission->status != VOR_OK)
        submission->error = admission->error;
    else if (is_settled(submission) || is_left)
        vor_admit_drop(app->blobs, &admission->admitted);
    else
        submitted = true;
    if (submitted)
        submission->outcome =
            vor_job_service_submit(app->service, &admission->admitted, &submission->head.spec,
                                   &label, &submission->view, &submission->error);
    else if (submission->booked)
        vor_job_service_unbook(app->service);
    end_flight(submission);
    vor_deferred_done(&submission->deferred);
    cancel_if_left(submission);
    vor_deferred_complete(&submission->deferred);
}

static enum vor_next admit(struct vor_request *request, struct submission *submission)
{
    struct vor_app *app = request->app;
    enum vor_job_outcome outcome = vor_job_service_book(app->service);

    submission->booked = outcome == VOR_DONE;
    if (!submission->booked && !has_key(submission)) /* which may be that of a job that is there */
        return vor_outcome_reply(request, outcome, NULL, NULL);
    submission->admission = (struct vor_admission){.uploads = submission->uploads,
                                                   .caller = vor_auth_fairness_key(request),
                                                   .spec = &submission->head.spec,
                                                   .done = on_admitted,
                                                   .has_left = has_left,
                                                   .ctx = submission};
    vor_deferred_retain(&submission->deferred);
    outcome = vor_admit_submit(app->admit, &submission->admission);
    if (outcome == VOR_DONE) {
        submission->uploads.count = 0;
        return VOR_NEXT_WAIT;
    }
    vor_deferred_cancel(&submission->deferred);
    if (submission->booked)
        vor_job_service_unbook(app->service);
    return vor_outcome_reply(request, outcome, &submission->admission.error, NULL);
}

/* Adds the address of the job, and the preferences that the reply follows; a stream follows none.
 */
static void add_job_headers(struct vor_request *request, const struct submission *submission,
                            bool is_async)
{
    const struct vor_submit_head *head = &submission->head;
    bool waited = head->wait_seconds >= 0 && head->mode == VOR_SUBMIT_SYNC;
    char url[VOR_URL_MAX];
    char applied[48];
    int length = 0;

    if (submission->replayed)
        vor_reply_header(request, "Idempotent-Replayed", "true");
    vor_reply_header(request, "Location", vor_app_job_url(request, &submission->view.id, "", url));
    applied[0] = '\0';
    if (is_async && head->is_async)
        length = snprintf(applied, sizeof applied, "respond-async%s", waited ? ", " : "");
    if (waited)
        (void)snprintf(applied + length, sizeof applied - (size_t)length, "wait=%.0f",
                       head->wait_seconds);
    if (applied[0] != '\0')
        vor_reply_header(request, "Preference-Applied", applied);
}

static enum vor_next reply_accepted(struct vor_request *request, struct submission *submission)
{
    struct vor_job_view view = submission->view;
    struct vor_error err;
    struct vor_text text;

    submission->settled = true;
    /* The job as it is now, or as it was accepted when the row cannot be read. */
    if (vor_job_service_get(request->app->service, &submission->view.id, NULL, &view, &err) !=
        VOR_DONE)
        view = submission->view;
    add_job_headers(request, submission, true);
    vor_reply_header(request, "Cache-Control", "no-store");
    vor_text_init(&text, 0);
    vor_job_write(request, &view, &text);
    return vor_reply_json(request, 201, &text);
}

static enum vor_next wait_for_end(struct vor_request *request, struct submission *submission)
{
    double left = submission->deadline - vor_clock_seconds();

    if (submission->job == NULL || vor_job_is_over(submission->job)) {
        struct vor_job_view view;
        struct vor_error err;
        enum vor_job_outcome outcome =
            vor_job_service_get(request->app->service, &submission->view.id, NULL, &view, &err);

        /* Answers a caller who has waited for the end of the job. */
        submission->settled = true;
        if (!submission->headed)
            add_job_headers(request, submission, false);
        submission->headed = true;
        if (outcome != VOR_DONE)
            return vor_outcome_reply(request, outcome, &err, &submission->view.id);
        if (view.status != VOR_JOB_SUCCESSFUL)
            return vor_result_missing(request, &view);
        return vor_result_whole(request, &view, !submission->replayed);
    }
    if (vor_request_gone(request))
        return vor_problem_say(request, "client-closed", "the client disconnected");
    if (vor_request_closing(request)) {
        submission->settled = true;
        add_job_headers(request, submission, false);
        return vor_problem_say(request, "draining",
                               "the daemon is shutting down; the job runs after the next start "
                               "of the daemon");
    }
    if (submission->deadline > 0) {
        if (left <= 0)
            return reply_accepted(request, submission);
        vor_request_wake_after(request, left);
    }
    return VOR_NEXT_WAIT;
}

static enum vor_next accepted(struct vor_request *request, struct submission *submission)
{
    struct vor_uuid id = submission->view.id;
    enum vor_job_outcome outcome;

    if (submission->outcome == VOR_FAILED && submission->error.status == VOR_E_CANCELLED)
        submission->outcome = VOR_DRAINING;
    if (submission->outcome == VOR_CONFLICT)
        return vor_problem_say(
            request, "idempotency-key-reused",
            "Idempotency-Key %s belongs to job %s, which has another process, parameter or input",
            submission->head.options.key.text, id.text);
    if (submission->outcome != VOR_DONE)
        return vor_outcome_reply(request, submission->outcome, &submission->error, NULL);
    (void)snprintf(request->job, sizeof request->job, "%s", id.text);
    switch (submission->head.mode) {
    case VOR_SUBMIT_ASYNC:
        return reply_accepted(request, submission);
    case VOR_SUBMIT_STREAM:
        add_job_headers(request, submission, false);
        return vor_events_reply(request, &id);
    case VOR_SUBMIT_SYNC:
        break;
    }
    outcome = subscribe(request->app, NULL, submission, &id);
    if (outcome != VOR_DONE)
        return vor_outcome_reply(request, outcome, &submission->error, &id);
    submission->waits = true;
    if (submission->head.wait_seconds >= 0)
        submission->deadline = vor_clock_seconds() + submission->head.wait_seconds;
    return wait_for_end(request, submission);
}

/* Answers a request whose key is that of a job, and admits any other. */
static enum vor_next take_in(struct vor_request *request, struct submission *submission)
{
    enum vor_job_outcome outcome = VOR_UNKNOWN;
    struct vor_submit_inputs inputs;
    enum vor_next next;

    if (!vor_submit_options_open(request, &submission->head.options, submission->head.spec.process,
                                 &submission->uploads, &next)) {
        submission->follows = next == VOR_NEXT_WAIT;
        return next;
    }
    for (unsigned i = 0; i < submission->uploads.count; i++)
        submission->packed |= submission->uploads.item[i].is_gzip;
    if (has_key(submission) && !submission->packed) {
        vor_submit_inputs_of_uploads(&inputs, &submission->uploads);
        outcome =
            vor_submit_options_find(&submission->head.options, request->app, &submission->head.spec,
                                    &inputs, &submission->view, &submission->error);
    }
    if (outcome == VOR_UNKNOWN)
        return admit(request, submission);
    end_flight(submission);
    submission->replayed = outcome == VOR_DONE;
    submission->outcome = outcome;
    return accepted(request, submission);
}

/* Waits until the job is over that the request goes on from, so that frames of a sequence may be
 * sent before the one before them is done. */
static enum vor_next wait_for_previous(struct vor_request *request, struct submission *submission)
{
    submission->follows = submission->job != NULL && !vor_job_is_over(submission->job);
    if (submission->follows)
        return vor_problem_or_wait(request);
    vor_job_unsubscribe(submission->job, &submission->subscriber);
    vor_job_release(submission->job);
    submission->job = NULL;
    return take_in(request, submission);
}

enum vor_next vor_handle_submit(struct vor_request *request, enum vor_step step)
{
    struct submission *submission = request->state;

    if (step == VOR_STEP_HEAD)
        return begin(request);
    if (step == VOR_STEP_BODY) {
        const struct vor_uuid *previous = &submission->head.options.previous;

        if (submission->head.body == VOR_SUBMIT_JSON)
            vor_submit_json_refuse(request, submission->head.spec.process, &submission->json);
        if (submission->head.body == VOR_SUBMIT_JSON ||
            (submission->form != NULL && (!vor_submit_form_end(submission->form) ||
                                          !vor_submit_complete(request, &submission->head))))
            return VOR_NEXT_REPLY;
        if (previous->text[0] != '\0' &&
            subscribe(request->app, vor_auth_tenant(request), submission, previous) != VOR_DONE)
            submission->job = NULL; /* which is answered when its result is asked for */
        return wait_for_previous(request, submission);
    }
    if (submission->follows)
        return wait_for_previous(request, submission);
    if (submission->waits)
        return wait_for_end(request, submission);
    if (vor_deferred_is_done(&submission->deferred))
        return accepted(request, submission);
    return vor_problem_or_wait(request);
}
