/* What handlers ask of the worker about single jobs that there are. */
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/work/live.h"

#include <stdio.h>
#include <string.h>

/* The view of a live job; false when there is none of that id, or its place in the queue is asked
 * for, which its row knows. */
static int live_view(struct vor_worker *worker, const struct vor_uuid *id, struct vor_job_view *out)
{
    struct vor_job *job = vor_worker_find(worker, id);

    if (job == NULL)
        return 0;
    vor_job_view(job, out);
    vor_job_release(job);
    return out->status != VOR_JOB_ACCEPTED;
}

/* tenant may be NULL: of any. */
static enum vor_job_outcome row_view(struct vor_worker *worker, const struct vor_uuid *id,
                                     const char *tenant, struct vor_job_view *out,
                                     struct vor_error *err)
{
    int found;

    if (vor_store_get(worker->config.store, id, tenant, out, &found, err) != VOR_OK)
        return VOR_FAILED;
    if (found && !vor_job_status_over(out->status))
        vor_job_describe(out, VOR_CONTINUE);
    return found ? VOR_DONE : VOR_UNKNOWN;
}

enum vor_job_outcome vor_worker_get(struct vor_worker *worker, const struct vor_uuid *id,
                                    const char *tenant, struct vor_job_view *out,
                                    struct vor_error *err)
{
    if (!live_view(worker, id, out))
        return row_view(worker, id, tenant, out, err);
    return tenant == NULL || strcmp(out->key.principal, tenant) == 0 ? VOR_DONE : VOR_UNKNOWN;
}

enum vor_job_outcome vor_worker_find_key(struct vor_worker *worker, const struct vor_job_key *key,
                                         struct vor_job_view *out, struct vor_error *err)
{
    int found;

    if (vor_store_find_key(worker->config.store, key, out, &found, err) != VOR_OK)
        return VOR_FAILED;
    if (!found)
        return VOR_UNKNOWN;
    return strcmp(out->key.fingerprint, key->fingerprint) == 0 ? VOR_DONE : VOR_CONFLICT;
}

struct listing {
    struct vor_worker *worker;
    int (*each)(void *ctx, const struct vor_job_view *row);
    void *ctx;
};

static int list_one(void *ctx, const struct vor_job_view *row)
{
    struct listing *listing = ctx;
    struct vor_job_view live;

    if (vor_job_status_over(row->status))
        return listing->each(listing->ctx, row);
    if (row->status != VOR_JOB_RUNNING || !live_view(listing->worker, &row->id, &live)) {
        live = *row;
        vor_job_describe(&live, VOR_CONTINUE);
    }
    return listing->each(listing->ctx, &live);
}

vor_status vor_worker_list(struct vor_worker *worker, const struct vor_job_filter *filter,
                           int (*each)(void *ctx, const struct vor_job_view *row), void *ctx,
                           struct vor_error *err)
{
    struct listing listing = {.worker = worker, .each = each, .ctx = ctx};

    return vor_store_list(worker->config.store, filter, list_one, &listing, err);
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
vor_status vor_worker_stored_events(struct vor_worker *worker, const struct vor_job_view *row,
                                    struct vor_event_batch *batch, struct vor_error *err)
{
    struct stored stored = {.batch = batch, .found = 1};
    struct vor_event_query query = {.attempt = row->attempt, .each = take_piece, .ctx = &stored};
    vor_status status;
    uint32_t number;

    vor_event_batch_begin(batch, row->attempt, UINT32_MAX);
    number = batch->position.number;
    query.after = number > 2 ? number - 2 : 0;
    status = vor_store_events(worker->config.store, &row->id, &query, err);
    if (status == VOR_OK && stored.last == 0 && number > 1) {
        vor_event_batch_begin(batch, row->attempt, 0);
        query.after = 0;
        status = vor_store_events(worker->config.store, &row->id, &query, err);
        if (stored.last == 0)
            batch->position.number = stored.last = number;
    }
    if (status == VOR_OK && stored.found != 0 && vor_job_status_over(row->status))
        vor_job_read_end(row, stored.last, batch);
    return status;
}

/* Makes a job that waits a live one, which its runner will find. One that has ended since its row
 * was read is none: whatever its runner had is gone. */
static enum vor_job_outcome follow_waiting(struct vor_worker *worker, const struct vor_uuid *id,
                                           struct vor_followed *out, struct vor_error *err)
{
    enum vor_job_outcome outcome;

    out->job = vor_worker_enliven(worker, &out->row);
    if (out->job == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "the events of a job");
        return VOR_FAILED;
    }
    if (vor_store_is_shared(worker->config.store) &&
        vor_worker_mirror(worker, out->job, err) != VOR_OK)
        outcome = VOR_FAILED;
    else
        outcome = row_view(worker, id, NULL, &out->row, err);
    if (outcome == VOR_DONE && !vor_job_status_over(out->row.status))
        return VOR_DONE;
    vor_worker_forget(worker, out->job);
    vor_job_release(out->job);
    out->job = NULL;
    return outcome;
}

enum vor_job_outcome vor_worker_follow(struct vor_worker *worker, const struct vor_uuid *id,
                                       const char *tenant, struct vor_followed *out,
                                       struct vor_error *err)
{
    enum vor_job_outcome outcome = VOR_DONE;

    out->job = vor_worker_find(worker, id);
    if (out->job == NULL)
        outcome = row_view(worker, id, tenant, &out->row, err);
    if (out->job == NULL && outcome == VOR_DONE && !vor_job_status_over(out->row.status))
        outcome = follow_waiting(worker, id, out, err);
    if (out->job == NULL)
        return outcome;
    vor_worker_followed(worker, out, &out->row);
    if (tenant == NULL || strcmp(out->row.key.principal, tenant) == 0)
        return outcome;
    vor_job_release(out->job);
    out->job = NULL;
    return VOR_UNKNOWN;
}

void vor_worker_followed(struct vor_worker *worker, const struct vor_followed *followed,
                         struct vor_job_view *out)
{
    struct vor_job_view row;

    if (followed->job == NULL) {
        *out = followed->row;
        return;
    }
    vor_job_view(followed->job, out);
    if (out->status == VOR_JOB_ACCEPTED &&
        row_view(worker, vor_job_id(followed->job), NULL, &row, NULL) == VOR_DONE)
        out->queue_position = row.queue_position;
}

/* --- ending ----------------------------------------------------------------------------------- */

/* Dismisses a live job: VOR_CONFLICT when it is over. */
static enum vor_job_outcome dismiss_live(struct vor_worker *worker, struct vor_job *job,
                                         const char *why, struct vor_job_view *out,
                                         struct vor_error *err)
{
    vor_status status;
    int changed;

    if (!vor_job_freeze(job))
        return VOR_CONFLICT;
    vor_worker_ending(worker, job, VOR_JOB_DISMISSED, out);
    out->kept = 0;
    (void)snprintf(out->message, sizeof out->message, "%s", why);
    status = vor_worker_finish(worker, job, out, NULL, NULL, &changed, err);
    vor_job_thaw(job);
    if (status != VOR_OK)
        return VOR_FAILED;
    if (!changed)
        return VOR_CONFLICT;
    vor_job_ask(job, VOR_CANCEL);
    return VOR_DONE;
}

/* Dismisses a job that is not live: VOR_CONFLICT when it is over. */
static enum vor_job_outcome dismiss_row(struct vor_worker *worker, const char *why,
                                        struct vor_job_view *row, struct vor_error *err)
{
    int changed;

    if (vor_job_status_over(row->status))
        return VOR_CONFLICT;
    row->status = VOR_JOB_DISMISSED;
    row->kept = 0;
    row->finished = vor_job_now(row, vor_clock_wall_ms());
    row->expires = row->finished + (int64_t)(worker->config.ttl_seconds * 1000);
    (void)snprintf(row->message, sizeof row->message, "%s", why);
    if (vor_store_finish(worker->config.store, row, NULL, NULL, &changed, err) != VOR_OK)
        return VOR_FAILED;
    return changed ? VOR_DONE : VOR_CONFLICT;
}

/* Dismisses a job that is not over, live or not; *out gets its last view in any case but
 * VOR_UNKNOWN and VOR_FAILED. */
static enum vor_job_outcome dismiss(struct vor_worker *worker, const struct vor_uuid *id,
                                    const char *why, struct vor_job_view *out,
                                    struct vor_error *err)
{
    enum vor_job_outcome outcome = VOR_CONFLICT;
    struct vor_job *job;
    int runs;

    pthread_mutex_lock(&worker->claim); /* what waits does not begin meanwhile */
    job = vor_worker_find(worker, id);
    runs = job != NULL && vor_worker_is_running(worker, job);
    if (job != NULL)
        outcome = dismiss_live(worker, job, why, out, err);
    if (outcome == VOR_CONFLICT) {
        outcome = row_view(worker, id, NULL, out, err);
        if (outcome == VOR_DONE)
            outcome = dismiss_row(worker, why, out, err);
    }
    if (outcome == VOR_DONE) {
        /* A job that runs has its outputs dropped by its runner, which also forgets it; one that
         * waits may have some of an attempt before a crash. */
        vor_worker_drop_all(worker, &out->id, out->process, out->attempt,
                            vor_has_inputs(out) | VOR_HAS_UPLOADS | (runs ? 0 : VOR_HAS_OUTPUTS));
        if (!runs)
            vor_capacity_wait(worker, out, -1);
        vor_log(VOR_LOG_INFO, "job dismissed", VOR_OF_JOB(out), VOR_TEXT("why", out->message));
        if (job != NULL && !runs)
            vor_worker_forget(worker, job);
    }
    pthread_mutex_unlock(&worker->claim);
    vor_job_release(job);
    return outcome;
}

static void drop_bytes(struct vor_worker *worker, const struct vor_job_view *row)
{
    vor_worker_drop_all(worker, &row->id, row->process, row->attempt,
                        vor_has_inputs(row) | VOR_HAS_UPLOADS | VOR_HAS_OUTPUTS);
}

/* Removes a job that is over; row is its last view. */
static enum vor_job_outcome remove_job(struct vor_worker *worker, const struct vor_job_view *row,
                                       struct vor_error *err)
{
    const struct vor_uuid *id = &row->id;
    struct vor_job *job;
    int changed;
    vor_status status = vor_store_remove(worker->config.store, id, &changed, err);

    /* On a disk without a byte the job's own make the room that its end takes. */
    if (status == VOR_E_IO && vor_error_storage_full(err)) {
        drop_bytes(worker, row);
        status = vor_store_remove(worker->config.store, id, &changed, err);
    }
    if (status != VOR_OK)
        return VOR_FAILED;
    if (!changed)
        return VOR_UNKNOWN;
    job = vor_worker_find(worker, id);
    if (job != NULL)
        vor_worker_forget(worker, job); /* its runner has not unwound yet */
    vor_job_release(job);
    drop_bytes(worker, row);
    vor_log(VOR_LOG_INFO, "job removed", VOR_TEXT("job", id->text));
    return VOR_DONE;
}

enum vor_job_outcome vor_worker_dismiss(struct vor_worker *worker, const struct vor_uuid *id,
                                        const char *why, struct vor_job_view *out,
                                        struct vor_error *err)
{
    struct vor_job_view view;
    enum vor_job_outcome outcome = dismiss(worker, id, why, &view, err);

    if (outcome == VOR_CONFLICT)
        outcome = remove_job(worker, &view, err);
    if (outcome != VOR_DONE || out == NULL)
        return outcome;
    view.status = VOR_JOB_DISMISSED;
    *out = view;
    return VOR_DONE;
}

enum vor_job_outcome vor_worker_cancel(struct vor_worker *worker, const struct vor_uuid *id,
                                       const char *why, struct vor_error *err)
{
    struct vor_job_view view;

    return dismiss(worker, id, why, &view, err);
}

static void run_dismissal(void *ctx)
{
    struct vor_dismissal *dismissal = ctx;
    struct vor_worker *worker = dismissal->worker;
    struct vor_error *err = &dismissal->error;
    int stops = 0;

    if (dismissal->is_cancel)
        dismissal->outcome = vor_worker_cancel(worker, &dismissal->id, dismissal->why, err);
    else if (!dismissal->is_stop)
        dismissal->outcome =
            vor_worker_dismiss(worker, &dismissal->id, dismissal->why, &dismissal->view, err);
    else if (vor_store_stop(worker->config.store, &dismissal->id, &stops, err) != VOR_OK)
        dismissal->outcome = VOR_FAILED;
    else
        dismissal->outcome = stops ? VOR_DONE : VOR_CONFLICT;
    dismissal->done(dismissal);
}

void vor_worker_dismiss_soon(struct vor_worker *worker, struct vor_dismissal *dismissal)
{
    enum vor_job_outcome outcome;

    dismissal->worker = worker;
    dismissal->task =
        (struct vor_task){.run = run_dismissal, .ctx = dismissal, .caller = dismissal->caller};
    outcome = vor_crew_take(worker->crew, &dismissal->task, &dismissal->error);
    if (outcome == VOR_DONE)
        return; /* the crew has it, and done may have freed it */
    dismissal->outcome = outcome;
    dismissal->done(dismissal);
}

enum vor_job_outcome vor_worker_read_soon(struct vor_worker *worker, struct vor_task *task,
                                          struct vor_error *err)
{
    return vor_crew_take(worker->readers, task, err);
}

void vor_worker_settle(struct vor_worker *worker, double seconds)
{
    vor_crew_settle(worker->crew, seconds);
    vor_crew_settle(worker->readers, seconds);
}

enum vor_job_outcome vor_worker_stop(struct vor_worker *worker, const struct vor_uuid *id,
                                     struct vor_error *err)
{
    struct vor_job *job = vor_worker_find(worker, id);
    struct vor_job_view view = {.status = VOR_JOB_ACCEPTED};
    enum vor_job_outcome outcome;

    if (job != NULL) {
        int runs = vor_worker_is_running(worker, job);

        vor_job_view(job, &view);
        if (runs && view.status == VOR_JOB_RUNNING)
            vor_job_ask(job, VOR_STOP);
        vor_job_release(job);
        return runs && view.status == VOR_JOB_RUNNING ? VOR_DONE : VOR_CONFLICT;
    }
    outcome = row_view(worker, id, NULL, &view, err);
    return outcome == VOR_DONE ? VOR_CONFLICT : outcome;
}
