#include "server/api/handlers/frames.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/base/clock.h"
#include "server/base/rates.h"
#include "server/work/verify.h"

#include <string.h>

static void on_event(void *ctx, enum vor_event_kind kind)
{
    if (kind == VOR_EVENT_END)
        vor_waker_wake(ctx);
}

static int has_left(void *ctx)
{
    const struct vor_flight *flight = ctx;

    return vor_deferred_is_left(&flight->sequence->deferred);
}

/* Called on an admission thread once the frame is decoded or refused. */
static void on_admitted(struct vor_admission *admission)
{
    struct vor_flight *flight = admission->ctx;
    struct vor_sequence *sequence = flight->sequence;
    struct vor_app *app = sequence->app;
    const struct vor_job_label label = {.name = flight->name,
                                        .key = &sequence->head.options.key,
                                        .span = &sequence->span,
                                        .jobs_max = (uint64_t)sequence->quota.jobs,
                                        .bytes_max = (uint64_t)sequence->quota.bytes,
                                        .points_max = (uint64_t)sequence->quota.points,
                                        .booked = true};

    flight->outcome = VOR_FAILED;
    flight->error = admission->error;
    if (admission->status == VOR_OK)
        flight->outcome =
            vor_job_service_submit(app->service, &admission->admitted, &sequence->head.spec, &label,
                                   &flight->view, &flight->error);
    else
        vor_job_service_unbook(app->service);
    atomic_store(&flight->is_admitted, true);
    vor_deferred_complete(&sequence->deferred);
}

void vor_sequence_tell_problem(struct vor_sequence *sequence, size_t index,
                               enum vor_job_outcome outcome, const struct vor_error *err)
{
    struct vor_frame *frame = &sequence->frames[index];
    struct vor_problem problem;

    vor_problem_of_error(err, NULL, &problem);
    if (outcome == VOR_CROWDED || outcome == VOR_OVER_BYTES)
        problem = VOR_PROBLEM(outcome == VOR_CROWDED ? "too-many-jobs" : "too-much-stored",
                              .detail = err->message);
    else if (outcome != VOR_FAILED || err->status == VOR_E_CANCELLED)
        problem = VOR_PROBLEM("draining", .detail = "the daemon is shutting down");
    vor_text_clear(&frame->told);
    vor_problem_write(sequence->request, &problem, &frame->told);
    frame->id.text[0] = '\0';
    frame->is_over = true;
}

bool vor_sequence_fetch(struct vor_sequence *sequence, const struct vor_uuid *id, uint32_t attempt,
                        enum vor_fetched *fetched, struct vor_error *err)
{
    struct vor_asker asker = vor_asker_of(sequence->request);
    char blob[VOR_BLOB_NAME_MAX + 1];

    (void)vor_blob_of_output(sequence->head.spec.process->outputs[0].name, attempt, blob);
    *fetched =
        vor_fetch(vor_verify_fetcher(sequence->app->verify), id, blob, NULL, &asker, NULL, err);
    if (*fetched == VOR_FETCH_WAIT)
        return false;
    vor_waker_drop(asker.ctx);
    return true;
}

/* Adds the last result to the inputs of a frame. */
static vor_status add_last(struct vor_sequence *sequence, struct vor_uploads *uploads,
                           struct vor_error *err)
{
    const struct vor_process_info *process = sequence->head.spec.process;
    struct vor_upload upload = {.name = vor_artefact_find(process->inputs, "previous")->name};
    struct vor_blob_source source = {.id = sequence->last};
    struct vor_job_view view;
    int found = 0;
    enum vor_job_outcome outcome =
        vor_job_service_get(sequence->app->service, &sequence->last, NULL, &view, err);
    vor_status status = VOR_OK;

    if (outcome == VOR_FAILED)
        return err->status;
    if (outcome == VOR_DONE && view.status == VOR_JOB_SUCCESSFUL && !view.expired) {
        (void)vor_blob_of_output(view.spec.process->outputs[0].name, view.attempt, source.name);
        memcpy(source.sha256, view.output[0].sha256, sizeof source.sha256);
        status = vor_blob_reopen(sequence->app->blobs, &source, &upload.bytes, &found, err);
    }
    if (status != VOR_OK)
        return status;
    if (!found)
        return vor_fail_param(err, VOR_E_PARAM, "previous",
                              "previous is job:%s, but its result has expired or was deleted",
                              sequence->last.text);
    vor_uploads_add(uploads, &upload);
    return VOR_OK;
}

/* Seconds until the key may start one more job; 0: it may, and did. The first frame's was counted
 * with the request. */
static double wait_for_rate(const struct vor_sequence *sequence)
{
    if (sequence->quota.rate <= 0 || sequence->begun == 0)
        return 0;
    return vor_rates_take(sequence->app->rates, sequence->head.options.key.principal,
                          sequence->quota.rate, vor_clock_seconds());
}

/* Begins the next frame. False when it must wait for room, or for the result before. */
static bool begin_flight(struct vor_sequence *sequence, struct vor_flight *flight)
{
    struct vor_app *app = sequence->app;
    const struct vor_spec *spec = &sequence->head.spec;
    size_t index = sequence->begun;
    const struct vor_frame *frame = &sequence->frames[index];
    struct vor_uploads uploads = {.count = 0};
    const struct vor_upload piece = {.name = spec->process->inputs[0].name,
                                     .whole = sequence->body.item[0].bytes,
                                     .offset = frame->offset,
                                     .size = frame->size};
    enum vor_job_outcome outcome;
    double wait;
    struct vor_error err = {.status = VOR_OK};
    enum vor_fetched fetched;

    if (sequence->last.text[0] != '\0' &&
        !vor_sequence_fetch(sequence, &sequence->last, sequence->last_attempt, &fetched, &err))
        return false;
    outcome = vor_job_service_book(app->service);
    wait = outcome == VOR_DONE ? wait_for_rate(sequence) : 1;
    if (outcome == VOR_DONE && wait > 0)
        vor_job_service_unbook(app->service);
    if (outcome == VOR_FULL || (outcome == VOR_DONE && wait > 0)) {
        vor_request_wake_after(sequence->request, wait);
        return false;
    }
    sequence->begun++;
    if (outcome != VOR_DONE) {
        vor_sequence_tell_problem(sequence, index, outcome, &err);
        return true;
    }
    vor_uploads_add(&uploads, &piece);
    if (sequence->last.text[0] != '\0' && add_last(sequence, &uploads, &err) != VOR_OK) {
        vor_uploads_discard(&uploads);
        vor_job_service_unbook(app->service);
        vor_sequence_tell_problem(sequence, index, VOR_FAILED, &err);
        return true;
    }
    memset(flight, 0, sizeof *flight);
    flight->sequence = sequence;
    flight->frame = index;
    memcpy(flight->name, frame->name, sizeof flight->name);
    flight->admission = (struct vor_admission){.uploads = uploads,
                                               .caller = sequence->caller,
                                               .spec = spec,
                                               .done = on_admitted,
                                               .has_left = has_left,
                                               .ctx = flight};
    vor_deferred_retain(&sequence->deferred);
    outcome = vor_admit_submit(app->admit, &flight->admission);
    if (outcome == VOR_DONE)
        return true;
    flight->sequence = NULL;
    vor_deferred_cancel(&sequence->deferred);
    vor_uploads_discard(&uploads);
    vor_job_service_unbook(app->service);
    if (outcome != VOR_FULL) {
        vor_sequence_tell_problem(sequence, index, outcome, &flight->admission.error);
        return true;
    }
    sequence->begun--;
    vor_request_wake_after(sequence->request, 1);
    return false;
}

/* Follows the job of a frame that was admitted. */
static void follow(struct vor_sequence *sequence, struct vor_flight *flight)
{
    struct vor_followed followed;
    enum vor_job_outcome outcome = flight->outcome;

    if (outcome == VOR_DONE)
        outcome = vor_job_service_follow(sequence->app->service, &flight->view.id, NULL, &followed,
                                         &flight->error);
    if (outcome != VOR_DONE) {
        vor_sequence_tell_problem(sequence, flight->frame, outcome, &flight->error);
        flight->sequence = NULL;
        return;
    }
    if (sequence->is_events) {
        struct vor_frame *frame = &sequence->frames[flight->frame];

        vor_job_write(sequence->request, &flight->view, &frame->told);
        frame->is_accepted = true;
    }
    flight->is_followed = true;
    flight->job = followed.job;
    flight->subscriber = (struct vor_subscriber){.wake = on_event, .ctx = sequence->deferred.waker};
    vor_job_subscribe(flight->job, &flight->subscriber);
}

void vor_flight_leave(struct vor_flight *flight)
{
    if (flight->is_followed) {
        vor_job_unsubscribe(flight->job, &flight->subscriber);
        vor_job_release(flight->job);
    }
    flight->is_followed = false;
    flight->job = NULL;
}

/* Says of a frame what became of its job. */
static void land(struct vor_sequence *sequence, struct vor_flight *flight)
{
    struct vor_frame *frame = &sequence->frames[flight->frame];
    struct vor_job_view view;
    struct vor_error err;
    enum vor_job_outcome outcome;

    vor_flight_leave(flight);
    outcome = vor_job_service_get(sequence->app->service, &flight->view.id, NULL, &view, &err);
    flight->sequence = NULL;
    if (outcome != VOR_DONE) {
        if (outcome == VOR_UNKNOWN)
            (void)vor_fail(&err, VOR_E_PARAM, "the job %s was deleted", flight->view.id.text);
        vor_sequence_tell_problem(sequence, flight->frame, VOR_FAILED, &err);
        return;
    }
    vor_text_clear(&frame->told);
    vor_job_write(sequence->request, &view, &frame->told);
    frame->is_over = true;
    if (view.status != VOR_JOB_SUCCESSFUL)
        return;
    frame->id = view.id;
    frame->attempt = view.attempt;
    frame->format = view.output[0].format;
    if (sequence->is_linked) {
        sequence->last = view.id;
        sequence->last_attempt = view.attempt;
    }
}

void vor_sequence_advance(struct vor_sequence *sequence)
{
    size_t whole = sequence->count - (sequence->is_open ? 1 : 0);
    unsigned most = sequence->is_linked ? 1 : VOR_FLIGHTS;
    bool ends = vor_request_closing(sequence->request) || atomic_load(&sequence->app->draining);

    for (unsigned i = 0; i < most; i++) {
        struct vor_flight *flight = &sequence->flights[i];

        if (flight->sequence != NULL && !flight->is_followed && atomic_load(&flight->is_admitted))
            follow(sequence, flight);
        if (flight->sequence != NULL && flight->is_followed &&
            (ends || flight->job == NULL || vor_job_is_over(flight->job)))
            land(sequence, flight);
        while (flight->sequence == NULL && sequence->begun < whole)
            if (!begin_flight(sequence, flight))
                return;
    }
}
