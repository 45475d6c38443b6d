/* What handlers ask of the job service about single jobs that there are. */
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/work/active_jobs.h"

#include <stdio.h>
#include <string.h>

/* The view of a live job; false when there is none of that id, or its place in the queue is asked
 * for, which its row knows. */
static int live_view(struct vor_job_service *service, const struct vor_uuid *id,
                     struct vor_job_view *out)
{
    struct vor_job *job = vor_job_service_find(service, id);

    if (job == NULL)
        return 0;
    vor_job_view(job, out);
    vor_job_release(job);
    return out->status != VOR_JOB_ACCEPTED;
}

/* tenant may be NULL: of any. */
static enum vor_job_outcome row_view(struct vor_job_service *service, const struct vor_uuid *id,
                                     const char *tenant, struct vor_job_view *out,
                                     struct vor_error *err)
{
    int found;

    if (vor_store_get(service->config.store, id, tenant, out, &found, err) != VOR_OK)
        return VOR_FAILED;
    if (found && !vor_job_status_over(out->status))
        vor_job_describe(out, VOR_CONTINUE);
    return found ? VOR_DONE : VOR_UNKNOWN;
}

enum vor_job_outcome vor_job_service_get(struct vor_job_service *service, const struct vor_uuid *id,
                                         const char *tenant, struct vor_job_view *out,
                                         struct vor_error *err)
{
    if (!live_view(service, id, out))
        return row_view(service, id, tenant, out, err);
    return tenant == NULL || strcmp(out->key.principal, tenant) == 0 ? VOR_DONE : VOR_UNKNOWN;
}

enum vor_job_outcome vor_job_service_find_key(struct vor_job_service *service,
                                              const struct vor_job_key *key,
                                              struct vor_job_view *out, struct vor_error *err)
{
    int found;

    if (vor_store_find_key(service->config.store, key, out, &found, err) != VOR_OK)
        return VOR_FAILED;
    if (!found)
        return VOR_UNKNOWN;
    return strcmp(out->key.fingerprint, key->fingerprint) == 0 ? VOR_DONE : VOR_CONFLICT;
}

struct listing {
    struct vor_job_service *service;
    int (*each)(void *ctx, const struct vor_job_view *row);
    void *ctx;
};

static int list_one(void *ctx, const struct vor_job_view *row)
{
    struct listing *listing = ctx;
    struct vor_job_view live;

    if (vor_job_status_over(row->status))
        return listing->each(listing->ctx, row);
    if (row->status != VOR_JOB_RUNNING || !live_view(listing->service, &row->id, &live)) {
        live = *row;
        vor_job_describe(&live, VOR_CONTINUE);
    }
    return listing->each(listing->ctx, &live);
}

vor_status vor_job_service_list(struct vor_job_service *service,
                                const struct vor_job_filter *filter,
                                int (*each)(void *ctx, const struct vor_job_view *row), void *ctx,
                                struct vor_error *err)
{
    struct listing listing = {.service = service, .each = each, .ctx = ctx};

    return vor_store_list(service->config.store, filter, list_one, &listing, err);
}

struct stored {
    struct vor_event_batch *batch;
    uint32_t last; /* number of the last event seen */
    int found;     /* of vor_events_unpack */
};

static int take_piece(void *ctx, const struct vor_event_piece *piece)
{
    struct stored *stored = ctx;

    stored->last = piece->last;
    stored->found = vor_events_unpack(stored->batch, piece);
    return stored->found > 0;
}

/* Looks from two events before the position on: as END has no piece, one is found unless the
 * position is behind all that there is, or all are gone. Then the reader starts anew, or has END at
 * once. */
vor_status vor_job_service_stored_events(struct vor_job_service *service,
                                         const struct vor_job_view *row,
                                         struct vor_event_batch *batch, struct vor_error *err)
{
    struct stored stored = {.batch = batch, .found = 1};
    struct vor_event_query query = {.attempt = row->attempt, .each = take_piece, .ctx = &stored};
    vor_status status;
    uint32_t number;

    vor_event_batch_begin(batch, row->attempt, UINT32_MAX);
    number = batch->position.number;
    query.after = number > 2 ? number - 2 : 0;
    status = vor_store_events(service->config.store, &row->id, &query, err);
    if (status == VOR_OK && stored.last == 0 && number > 1) {
        vor_event_batch_begin(batch, row->attempt, 0);
        query.after = 0;
        status = vor_store_events(service->config.store, &row->id, &query, err);
        if (stored.last == 0)
            batch->position.number = stored.last = number;
    }
    if (status == VOR_OK && stored.found != 0 && vor_job_status_over(row->status))
        vor_job_read_end(row, stored.last, batch);
    return status;
}

/* Makes a job that waits a live one, which its runner will find. One that has ended since its row
 * was read is none: whatever its runner had is gone. */
static enum vor_job_outcome follow_waiting(struct vor_job_service *service,
                                           const struct vor_uuid *id, struct vor_followed *out,
                                           struct vor_error *err)
{
    enum vor_job_outcome outcome;

    out->job = vor_job_service_enliven(service, &out->row);
    if (out->job == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "the events of a job");
        return VOR_FAILED;
    }
    if (vor_store_is_shared(service->config.store) &&
        vor_job_service_mirror(service, out->job, err) != VOR_OK)
        outcome = VOR_FAILED;
    else
        outcome = row_view(service, id, NULL, &out->row, err);
    if (outcome == VOR_DONE && !vor_job_status_over(out->row.status))
        return VOR_DONE;
    vor_job_service_forget(service, out->job);
    vor_job_release(out->job);
    out->job = NULL;
    return outcome;
}

/* A job that became live and ended since it was looked for: its runner may not have told it so yet,
 * and who asks next is to see the row. */
static void forget_ended(struct vor_job_service *service, const struct vor_uuid *id)
{
    struct vor_job *job = vor_job_service_find(service, id);

    if (job == NULL)
        return;
    vor_job_service_forget(service, job);
    vor_job_release(job);
}

enum vor_job_outcome vor_job_service_follow(struct vor_job_service *service,
                                            const struct vor_uuid *id, const char *tenant,
                                            struct vor_followed *out, struct vor_error *err)
{
    enum vor_job_outcome outcome = VOR_DONE;

    out->job = vor_job_service_find(service, id);
    if (out->job == NULL)
        outcome = row_view(service, id, tenant, &out->row, err);
    if (out->job == NULL && outcome == VOR_DONE && !vor_job_status_over(out->row.status))
        outcome = follow_waiting(service, id, out, err);
    if (out->job == NULL) {
        if (outcome == VOR_DONE)
            forget_ended(service, id);
        return outcome;
    }
    vor_job_service_followed(service, out, &out->row);
    if (tenant == NULL || strcmp(out->row.key.principal, tenant) == 0)
        return outcome;
    vor_job_release(out->job);
    out->job = NULL;
    return VOR_UNKNOWN;
}

void vor_job_service_followed(struct vor_job_service *service, const struct vor_followed *followed,
                              struct vor_job_view *out)
{
    struct vor_job_view row;

    if (followed->job == NULL) {
        *out = followed->row;
        return;
    }
    vor_job_view(followed->job, out);
    if (out->status == VOR_JOB_ACCEPTED &&
        row_view(service, vor_job_id(followed->job), NULL, &row, NULL) == VOR_DONE)
        out->queue_position = row.queue_position;
}

/* --- ending ----------------------------------------------------------------------------------- */

/* Dismisses a live job: VOR_CONFLICT when it is over. */
static enum vor_job_outcome dismiss_live(struct vor_job_service *service, struct vor_job *job,
                                         const char *why, struct vor_job_view *out,
                                         struct vor_error *err)
{
    vor_status status;
    int changed;

    if (!vor_job_freeze(job))
        return VOR_CONFLICT;
    vor_job_service_ending(service, job, VOR_JOB_DISMISSED, out);
    out->kept = 0;
    (void)snprintf(out->message, sizeof out->message, "%s", why);
    status = vor_job_service_finish(service, job, out, NULL, NULL, &changed, err);
    vor_job_thaw(job);
    if (status != VOR_OK)
        return VOR_FAILED;
    if (!changed)
        return VOR_CONFLICT;
    vor_job_ask(job, VOR_CANCEL);
    return VOR_DONE;
}

/* Dismisses a job that is not live: VOR_CONFLICT when it is over. */
static enum vor_job_outcome dismiss_row(struct vor_job_service *service, const char *why,
                                        struct vor_job_view *row, struct vor_error *err)
{
    int changed;

    if (vor_job_status_over(row->status))
        return VOR_CONFLICT;
    row->status = VOR_JOB_DISMISSED;
    row->kept = 0;
    row->finished = vor_job_now(row, vor_clock_wall_ms());
    row->expires = row->finished + (int64_t)(service->config.ttl_seconds * 1000);
    (void)snprintf(row->message, sizeof row->message, "%s", why);
    if (vor_store_finish(service->config.store, row, NULL, NULL, &changed, err) != VOR_OK)
        return VOR_FAILED;
    return changed ? VOR_DONE : VOR_CONFLICT;
}

/* Dismisses a job that is not over, live or not; *out gets its last view in any case but
 * VOR_UNKNOWN and VOR_FAILED. */
static enum vor_job_outcome dismiss(struct vor_job_service *service, const struct vor_uuid *id,
                                    const char *why, struct vor_job_view *out,
                                    struct vor_error *err)
{
    enum vor_job_outcome outcome = VOR_CONFLICT;
    struct vor_job *job;
    int runs;

    pthread_mutex_lock(&service->claim); /* what waits does not begin meanwhile */
    job = vor_job_service_find(service, id);
    runs = job != NULL && vor_job_service_is_running(service, job);
    if (job != NULL)
        outcome = dismiss_live(service, job, why, out, err);
    if (outcome == VOR_CONFLICT) {
        outcome = row_view(service, id, NULL, out, err);
        if (outcome == VOR_DONE)
            outcome = dismiss_row(service, why, out, err);
    }
    if (outcome == VOR_DONE) {
        /* A job that runs has its outputs dropped by its runner, which also forgets it; one that
         * waits may have some of an attempt before a crash. */
        vor_job_service_drop_all(service, &out->id, out->process, out->attempt,
                                 vor_has_inputs(out) | VOR_HAS_UPLOADS |
                                     (runs ? 0 : VOR_HAS_OUTPUTS));
        if (!runs)
            vor_capacity_wait(service, out, -1);
        vor_log(VOR_LOG_INFO, "job dismissed", VOR_OF_JOB(out), VOR_TEXT("why", out->message));
        if (job != NULL && !runs)
            vor_job_service_forget(service, job);
    }
    pthread_mutex_unlock(&service->claim);
    vor_job_release(job);
    return outcome;
}

static void drop_bytes(struct vor_job_service *service, const struct vor_job_view *row)
{
    vor_job_service_drop_all(service, &row->id, row->process, row->attempt,
                             vor_has_inputs(row) | VOR_HAS_UPLOADS | VOR_HAS_OUTPUTS);
}

/* Removes a job that is over; row is its last view. */
static enum vor_job_outcome remove_job(struct vor_job_service *service,
                                       const struct vor_job_view *row, struct vor_error *err)
{
    const struct vor_uuid *id = &row->id;
    struct vor_job *job;
    int64_t left;
    int changed;
    vor_status status = vor_store_remove(service->config.store, id, &changed, err);

    /* On a disk without a byte the log's own, and the job's, make the room that its end takes. */
    if (status == VOR_E_IO && vor_error_storage_full(err)) {
        (void)(vor_store_give_back(service->config.store, &left, NULL) == VOR_OK);
        drop_bytes(service, row);
        status = vor_store_remove(service->config.store, id, &changed, err);
    }
    if (status != VOR_OK)
        return VOR_FAILED;
    if (!changed)
        return VOR_UNKNOWN;
    job = vor_job_service_find(service, id);
    if (job != NULL)
        vor_job_service_forget(service, job); /* its runner has not unwound yet */
    vor_job_release(job);
    drop_bytes(service, row);
    vor_log(VOR_LOG_INFO, "job removed", VOR_TEXT("job", id->text));
    return VOR_DONE;
}

enum vor_job_outcome vor_job_service_dismiss(struct vor_job_service *service,
                                             const struct vor_uuid *id, const char *why,
                                             struct vor_job_view *out, struct vor_error *err)
{
    struct vor_job_view view;
    enum vor_job_outcome outcome = dismiss(service, id, why, &view, err);

    if (outcome == VOR_CONFLICT)
        outcome = remove_job(service, &view, err);
    if (outcome != VOR_DONE || out == NULL)
        return outcome;
    view.status = VOR_JOB_DISMISSED;
    *out = view;
    return VOR_DONE;
}

enum vor_job_outcome vor_job_service_cancel(struct vor_job_service *service,
                                            const struct vor_uuid *id, const char *why,
                                            struct vor_error *err)
{
    struct vor_job_view view;

    return dismiss(service, id, why, &view, err);
}

static void run_dismissal(void *ctx)
{
    struct vor_dismissal *dismissal = ctx;
    struct vor_job_service *service = dismissal->service;
    struct vor_error *err = &dismissal->error;
    int stops = 0;

    if (dismissal->is_cancel)
        dismissal->outcome = vor_job_service_cancel(service, &dismissal->id, dismissal->why, err);
    else if (!dismissal->is_stop)
        dismissal->outcome =
            vor_job_service_dismiss(service, &dismissal->id, dismissal->why, &dismissal->view, err);
    else if (vor_store_stop(service->config.store, &dismissal->id, &stops, err) != VOR_OK)
        dismissal->outcome = VOR_FAILED;
    else
        dismissal->outcome = stops ? VOR_DONE : VOR_CONFLICT;
    dismissal->done(dismissal);
}

void vor_job_service_dismiss_soon(struct vor_job_service *service, struct vor_dismissal *dismissal)
{
    enum vor_job_outcome outcome;

    dismissal->service = service;
    dismissal->task =
        (struct vor_task){.run = run_dismissal, .ctx = dismissal, .caller = dismissal->caller};
    outcome = vor_thread_pool_submit(service->pool, &dismissal->task, &dismissal->error);
    if (outcome == VOR_DONE)
        return; /* the pool has it, and done may have freed it */
    dismissal->outcome = outcome;
    dismissal->done(dismissal);
}

enum vor_job_outcome vor_job_service_read_soon(struct vor_job_service *service,
                                               struct vor_task *task, struct vor_error *err)
{
    return vor_thread_pool_submit(service->readers, task, err);
}

void vor_job_service_settle(struct vor_job_service *service, double seconds)
{
    vor_thread_pool_wait(service->pool, seconds);
    vor_thread_pool_wait(service->readers, seconds);
}

enum vor_job_outcome vor_job_service_stop(struct vor_job_service *service,
                                          const struct vor_uuid *id, struct vor_error *err)
{
    struct vor_job *job = vor_job_service_find(service, id);
    struct vor_job_view view = {.status = VOR_JOB_ACCEPTED};
    enum vor_job_outcome outcome;

    if (job != NULL) {
        int runs = vor_job_service_is_running(service, job);

        vor_job_view(job, &view);
        if (runs && view.status == VOR_JOB_RUNNING)
            vor_job_ask(job, VOR_STOP);
        vor_job_release(job);
        return runs && view.status == VOR_JOB_RUNNING ? VOR_DONE : VOR_CONFLICT;
    }
    outcome = row_view(service, id, NULL, &view, err);
    return outcome == VOR_DONE ? VOR_CONFLICT : outcome;
}
