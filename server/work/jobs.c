/* What handlers ask of the worker about single jobs. */
#include "proto/codec.h"
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/jobs/cost.h"
#include "server/jobs/need.h"
#include "server/jobs/trace.h"
#include "server/work/counted.h"
#include "server/work/live.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum vor_job_outcome vor_worker_room(struct vor_worker *worker)
{
    int draining;

    pthread_mutex_lock(&worker->mutex);
    draining = worker->draining;
    pthread_mutex_unlock(&worker->mutex);
    if (draining)
        return VOR_DRAINING;
    if (vor_worker_waiting_bytes(worker) >= worker->config.queue_bytes)
        return VOR_FULL;
    return vor_queue_depth(worker->queue) < vor_queue_capacity(worker->queue) ? VOR_DONE : VOR_FULL;
}

enum vor_job_outcome vor_worker_book(struct vor_worker *worker)
{
    return vor_queue_reserve(worker->queue);
}

void vor_worker_unbook(struct vor_worker *worker)
{
    vor_queue_cancel(worker->queue);
}

void vor_worker_load(struct vor_worker *worker, struct vor_worker_load *out)
{
    out->waiting = vor_queue_depth(worker->queue);
    out->oldest_ms = vor_queue_oldest(worker->queue);
    pthread_mutex_lock(&worker->mutex);
    out->running = worker->running;
    pthread_mutex_unlock(&worker->mutex);
    out->reserved = vor_turns_used(&worker->turns);
    out->budget = worker->turns.budget;
}

/* --- accepting -------------------------------------------------------------------------------- */

/* Refuses now what the engine would refuse minutes later, as far as that can be known now. */
static vor_status check_target(const struct vor_spec *spec, const struct vor_job_input *input,
                               struct vor_error *err)
{
    if (vor_spec_given(spec, VOR_PARAM_SPACING))
        return VOR_OK;
    return vor_spec_check_target(spec, vor_spec_target(spec, input->points), input->points, err);
}

/* Likewise. */
static vor_status check_cost(const struct vor_worker *worker, const struct vor_job_view *row,
                             struct vor_error *err)
{
    return vor_cost_check(&row->spec, row->input[0].points, worker->config.executor->threads,
                          worker->config.job_seconds, err);
}

/* Likewise what could never run: row has its inputs. */
static vor_status check_need(const struct vor_worker *worker, const struct vor_job_view *row,
                             struct vor_error *err)
{
    uint64_t need = vor_need_bytes(&row->spec, row->inputs, row->input),
             budget = worker->turns.budget;

    if (need <= budget)
        return VOR_OK;
    (void)vor_fail(err, VOR_E_NOMEM,
                   "the job needs about %llu bytes of memory, all jobs together may have %llu",
                   (unsigned long long)need, (unsigned long long)budget);
    err->limit = budget;
    err->got = need;
    return VOR_E_NOMEM;
}

/* Likewise; row has its inputs and its format. */
static vor_status check_origin(const struct vor_job_view *row, const struct vor_admitted *admitted,
                               struct vor_error *err)
{
    const struct vor_process_info *process = row->spec.process;

    if (!vor_process_takes(process, VOR_PARAM_FORMAT))
        return VOR_OK;
    for (unsigned i = 0; i < admitted->count; i++)
        if (strcmp(admitted->item[i].name, process->inputs[0].name) == 0)
            return vor_write_check(vor_format((unsigned)row->spec.value[VOR_PARAM_FORMAT]),
                                   &row->spec, &admitted->item[i].extent, err);
    return VOR_OK;
}

static void first_row(struct vor_job_view *row, const struct vor_uuid *id,
                      const struct vor_spec *spec, const struct vor_job_label *label)
{
    *row = (struct vor_job_view){.id = *id,
                                 .status = VOR_JOB_ACCEPTED,
                                 .stage = VOR_STAGE_QUEUED,
                                 .attempt = 1,
                                 .queue_position = -1,
                                 .eta_seconds = -1,
                                 .spec = *spec,
                                 .created = vor_clock_wall_ms()};
    (void)snprintf(row->process, sizeof row->process, "%s", spec->process->id);
    row->updated = row->created;
    row->problem.byte_offset = -1;
    if (label != NULL && label->name != NULL)
        (void)snprintf(row->name, sizeof row->name, "%s", label->name);
    if (label != NULL && label->key != NULL)
        row->key = *label->key;
    if (label != NULL && label->span != NULL)
        row->span = *label->span;
}

/* Puts the inputs into their places in the row. */
static vor_status take_inputs(struct vor_job_view *row, const struct vor_admitted *admitted,
                              struct vor_error *err)
{
    const struct vor_process_info *process = row->spec.process;
    vor_status status;

    for (unsigned i = 0; i < admitted->count; i++) {
        const char *name = admitted->item[i].name;
        const struct vor_artefact_info *info = vor_artefact_find(process->inputs, name);

        if (info == NULL)
            return vor_fail_param(err, VOR_E_PARAM, name, "%s takes no input %s", process->id,
                                  name);
        row->inputs |= 1u << (info - process->inputs);
        row->input[info - process->inputs] = admitted->item[i].found;
        row->kept += admitted->item[i].is_kept ? admitted->item[i].found.bytes : 0;
    }
    status = vor_spec_check_inputs(&row->spec, row->inputs, err);
    if (status == VOR_OK && vor_process_takes(process, VOR_PARAM_FORMAT) &&
        !vor_spec_given(&row->spec, VOR_PARAM_FORMAT))
        row->spec.value[VOR_PARAM_FORMAT] = row->input[0].format;
    return status;
}

/* Makes the row durable and a remembered job wait, if its inputs still fit into the queue. */
static enum vor_job_outcome push_job(struct vor_worker *worker, struct vor_job *job,
                                     struct vor_job_view *row, uint64_t bytes,
                                     struct vor_error *err)
{
    if (!vor_worker_charge(worker, job, bytes, worker->config.queue_bytes))
        return VOR_FULL;
    if (vor_store_insert(worker->config.store, row, err) != VOR_OK)
        return VOR_FAILED;
    vor_job_set_seq(job, row->seq);
    vor_queue_push(worker->queue, job, row->seq);
    return VOR_DONE;
}

/* The same with a job that is live from now on, for a place in the queue that is booked. */
static enum vor_job_outcome accept_job(struct vor_worker *worker, struct vor_job_view *row,
                                       size_t jobs_max, uint64_t bytes, struct vor_error *err)
{
    struct vor_job *job = vor_job_create(row);
    enum vor_job_outcome outcome;

    if (job == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "a job");
        return VOR_FAILED;
    }
    outcome = vor_worker_admit(worker, job, jobs_max, err);
    if (outcome == VOR_DONE) {
        outcome = push_job(worker, job, row, bytes, err);
        if (outcome != VOR_DONE)
            vor_worker_forget(worker, job);
    }
    vor_job_release(job);
    return outcome;
}

/* Bytes of decoded inputs that would never fit into the queue are no reason to come back later. */
static vor_status check_bytes(struct vor_worker *worker, const struct vor_admitted *admitted,
                              uint64_t *bytes, struct vor_error *err)
{
    uint64_t most = worker->config.queue_bytes;

    *bytes = 0;
    for (unsigned i = 0; i < admitted->count; i++)
        *bytes += admitted->item[i].decoded;
    if (*bytes <= most)
        return VOR_OK;
    (void)vor_fail(err, VOR_E_BYTES,
                   "the decoded inputs have %llu bytes, want at most %llu, which may wait",
                   (unsigned long long)*bytes, (unsigned long long)most);
    err->limit = most;
    err->got = *bytes;
    return VOR_E_BYTES;
}

/* For a job that has a place in the queue, and keeps it when VOR_DONE is returned. */
static enum vor_job_outcome submit(struct vor_worker *worker, struct vor_job_view *row,
                                   size_t jobs_max, uint64_t bytes, struct vor_error *err)
{
    const char *tenant = row->key.principal;
    enum vor_job_outcome outcome = accept_job(worker, row, jobs_max, bytes, err);

    if (outcome != VOR_DONE)
        return outcome;
    vor_count_accepted(row);
    vor_log(VOR_LOG_INFO, "job accepted", VOR_OF_JOB(row),
            VOR_TEXT("tenant", tenant[0] != '\0' ? tenant : NULL),
            VOR_TEXT("process", row->process), VOR_COUNT("points", row->input[0].points),
            VOR_COUNT("bytes", row->input[0].bytes));
    return VOR_DONE;
}

enum vor_job_outcome vor_worker_submit(struct vor_worker *worker,
                                       const struct vor_admitted *admitted,
                                       const struct vor_spec *spec,
                                       const struct vor_job_label *label, struct vor_job_view *out,
                                       struct vor_error *err)
{
    enum vor_job_outcome outcome = VOR_FAILED;
    int booked = label != NULL && label->booked;
    struct vor_job_view row;
    uint64_t bytes;

    first_row(&row, &admitted->id, spec, label);
    if (take_inputs(&row, admitted, err) == VOR_OK &&
        check_bytes(worker, admitted, &bytes, err) == VOR_OK &&
        check_target(spec, &row.input[0], err) == VOR_OK &&
        check_need(worker, &row, err) == VOR_OK && check_cost(worker, &row, err) == VOR_OK &&
        check_origin(&row, admitted, err) == VOR_OK) {
        outcome = booked ? VOR_DONE : vor_worker_book(worker);
        booked = outcome == VOR_DONE;
    }
    if (outcome == VOR_DONE)
        outcome = submit(worker, &row, label != NULL ? label->jobs_max : 0, bytes, err);
    if (outcome != VOR_DONE) {
        if (booked)
            vor_worker_unbook(worker);
        vor_admit_drop(worker->config.blobs, admitted);
        return outcome;
    }
    if (row.kept > 0)
        vor_worker_shed(worker);
    if (out != NULL)
        *out = row;
    return VOR_DONE;
}

/* --- looking ---------------------------------------------------------------------------------- */

/* The view of a live job; false when there is none of that id. */
static int live_view(struct vor_worker *worker, const struct vor_uuid *id, struct vor_job_view *out)
{
    struct vor_job *job = vor_worker_find(worker, id);

    if (job == NULL)
        return 0;
    vor_job_view(job, out);
    out->queue_position = vor_queue_position(worker->queue, job);
    vor_job_release(job);
    return 1;
}

static enum vor_job_outcome row_view(struct vor_worker *worker, const struct vor_uuid *id,
                                     struct vor_job_view *out, struct vor_error *err)
{
    int found;

    if (vor_store_get(worker->config.store, id, out, &found, err) != VOR_OK)
        return VOR_FAILED;
    return found ? VOR_DONE : VOR_UNKNOWN;
}

enum vor_job_outcome vor_worker_get(struct vor_worker *worker, const struct vor_uuid *id,
                                    struct vor_job_view *out, struct vor_error *err)
{
    return live_view(worker, id, out) ? VOR_DONE : row_view(worker, id, out, err);
}

enum vor_job_outcome vor_worker_get_of(struct vor_worker *worker, const struct vor_uuid *id,
                                       const char *tenant, struct vor_job_view *out,
                                       struct vor_error *err)
{
    int found;

    if (tenant == NULL)
        return vor_worker_get(worker, id, out, err);
    if (live_view(worker, id, out))
        return strcmp(out->key.principal, tenant) == 0 ? VOR_DONE : VOR_UNKNOWN;
    if (vor_store_get_of(worker->config.store, id, tenant, out, &found, err) != VOR_OK)
        return VOR_FAILED;
    return found ? VOR_DONE : VOR_UNKNOWN;
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

    if (!vor_job_status_over(row->status) && live_view(listing->worker, &row->id, &live))
        row = &live;
    return listing->each(listing->ctx, row);
}

vor_status vor_worker_list(struct vor_worker *worker, const struct vor_job_filter *filter,
                           int (*each)(void *ctx, const struct vor_job_view *row), void *ctx,
                           struct vor_error *err)
{
    struct listing listing = {.worker = worker, .each = each, .ctx = ctx};

    return vor_store_list(worker->config.store, filter, list_one, &listing, err);
}

/* The bus of a job that is not live: its trace, and its end. */
static vor_status stored_bus(struct vor_worker *worker, const struct vor_job_view *row,
                             struct vor_bus **out, struct vor_error *err)
{
    struct vor_event end = {.kind = VOR_EVENT_END,
                            .status = row->status,
                            .stage = row->stage,
                            .progress = row->progress,
                            .time_ms = row->finished};
    struct vor_bus *bus = NULL;
    uint8_t *trace;
    size_t size;
    vor_status status = vor_store_trace(worker->config.store, &row->id, &trace, &size, err);

    if (status != VOR_OK)
        return status;
    if (trace == NULL || vor_trace_unpack(&bus, trace, size, NULL) != VOR_OK)
        bus = vor_bus_create(row->attempt);
    free(trace);
    if (bus == NULL || (vor_job_status_over(row->status) && vor_bus_publish(bus, &end) != VOR_OK)) {
        vor_bus_release(bus);
        return vor_fail(err, VOR_E_NOMEM, "the events of a job");
    }
    *out = bus;
    return VOR_OK;
}

enum vor_job_outcome vor_worker_follow(struct vor_worker *worker, const struct vor_uuid *id,
                                       struct vor_followed *out, struct vor_error *err)
{
    enum vor_job_outcome outcome;

    out->bus = NULL;
    out->job = vor_worker_find(worker, id);
    if (out->job != NULL) {
        out->bus = vor_bus_retain(vor_job_bus(out->job));
        vor_worker_followed(worker, out, &out->row);
        return VOR_DONE;
    }
    outcome = row_view(worker, id, &out->row, err);
    if (outcome != VOR_DONE)
        return outcome;
    return stored_bus(worker, &out->row, &out->bus, err) == VOR_OK ? VOR_DONE : VOR_FAILED;
}

void vor_worker_followed(struct vor_worker *worker, const struct vor_followed *followed,
                         struct vor_job_view *out)
{
    if (followed->job == NULL) {
        *out = followed->row;
        return;
    }
    vor_job_view(followed->job, out);
    out->queue_position = vor_queue_position(worker->queue, followed->job);
}

void vor_worker_unfollow(struct vor_followed *followed)
{
    vor_bus_release(followed->bus);
    vor_job_release(followed->job);
    followed->bus = NULL;
    followed->job = NULL;
}

enum vor_job_outcome vor_worker_events(struct vor_worker *worker, const struct vor_uuid *id,
                                       struct vor_bus **out, struct vor_error *err)
{
    struct vor_followed followed;
    enum vor_job_outcome outcome = vor_worker_follow(worker, id, &followed, err);

    if (outcome == VOR_DONE)
        *out = vor_bus_retain(followed.bus);
    vor_worker_unfollow(&followed);
    return outcome;
}

vor_status vor_worker_report(struct vor_worker *worker, const struct vor_uuid *id, char **report,
                             struct vor_error *err)
{
    return vor_store_report(worker->config.store, id, report, err);
}

/* --- ending ----------------------------------------------------------------------------------- */

static void explain(struct vor_job_view *row, const char *why)
{
    (void)snprintf(row->message, sizeof row->message, "%s", why);
}

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
    explain(out, why);
    status = vor_worker_finish(worker, job, out, 0, NULL, &changed, err);
    vor_job_thaw(job);
    if (status != VOR_OK)
        return VOR_FAILED;
    if (!changed)
        return VOR_CONFLICT;
    vor_job_ask(job, VOR_CANCEL);
    if (vor_queue_remove(worker->queue, job)) {
        vor_worker_forget(worker, job);                          /* else a runner has it and will */
        vor_worker_drop_outputs(worker, &out->id, out->process); /* of an attempt before a crash */
    }
    vor_worker_drop_inputs(worker, &out->id, out->process);
    vor_worker_drop_uploads(worker, &out->id, out->process);
    vor_log(VOR_LOG_INFO, "job dismissed", VOR_OF_JOB(out), VOR_TEXT("why", why));
    return VOR_DONE;
}

/* Dismisses a job that waits for the next start of the daemon: VOR_CONFLICT when it is over. */
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
    explain(row, why);
    if (vor_store_finish(worker->config.store, row, 0, NULL, &changed, err) != VOR_OK)
        return VOR_FAILED;
    vor_worker_drop_inputs(worker, &row->id, row->process);
    vor_worker_drop_uploads(worker, &row->id, row->process);
    vor_worker_drop_outputs(worker, &row->id, row->process);
    return changed ? VOR_DONE : VOR_CONFLICT;
}

/* Dismisses a job that is not over, live or not; *out gets its last view in any case but
 * VOR_UNKNOWN and VOR_FAILED. */
static enum vor_job_outcome dismiss(struct vor_worker *worker, const struct vor_uuid *id,
                                    const char *why, struct vor_job_view *out,
                                    struct vor_error *err)
{
    struct vor_job *job = vor_worker_find(worker, id);
    enum vor_job_outcome outcome = VOR_CONFLICT;

    if (job != NULL)
        outcome = dismiss_live(worker, job, why, out, err);
    vor_job_release(job);
    if (outcome != VOR_CONFLICT)
        return outcome;
    outcome = row_view(worker, id, out, err);
    return outcome == VOR_DONE ? dismiss_row(worker, why, out, err) : outcome;
}

/* Removes a job that is over; row is its last view. */
static enum vor_job_outcome remove_job(struct vor_worker *worker, const struct vor_job_view *row,
                                       struct vor_error *err)
{
    const struct vor_uuid *id = &row->id;
    struct vor_job *job;
    int changed;

    if (vor_store_remove(worker->config.store, id, &changed, err) != VOR_OK)
        return VOR_FAILED;
    if (!changed)
        return VOR_UNKNOWN;
    job = vor_worker_find(worker, id);
    if (job != NULL)
        vor_worker_forget(worker, job); /* its runner has not unwound yet */
    vor_job_release(job);
    vor_worker_drop_inputs(worker, id, row->process);
    vor_worker_drop_uploads(worker, id, row->process);
    vor_worker_drop_outputs(worker, id, row->process);
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

    dismissal->outcome =
        dismissal->is_cancel
            ? vor_worker_cancel(worker, &dismissal->id, dismissal->why, &dismissal->error)
            : vor_worker_dismiss(worker, &dismissal->id, dismissal->why, &dismissal->view,
                                 &dismissal->error);
    dismissal->done(dismissal);
}

void vor_worker_dismiss_soon(struct vor_worker *worker, struct vor_dismissal *dismissal)
{
    dismissal->worker = worker;
    dismissal->task = (struct vor_task){.run = run_dismissal, .ctx = dismissal};
    if (vor_crew_take(worker->crew, &dismissal->task) == VOR_DONE)
        return;
    dismissal->outcome = VOR_DRAINING; /* a crew without a bound refuses only once it closes */
    dismissal->done(dismissal);
}

void vor_worker_settle(struct vor_worker *worker, double seconds)
{
    vor_crew_settle(worker->crew, seconds);
}

enum vor_job_outcome vor_worker_stop(struct vor_worker *worker, const struct vor_uuid *id,
                                     struct vor_error *err)
{
    struct vor_job *job = vor_worker_find(worker, id);
    struct vor_job_view view = {.status = VOR_JOB_ACCEPTED};
    enum vor_job_outcome outcome;

    if (job != NULL) {
        vor_job_view(job, &view);
        if (view.status == VOR_JOB_RUNNING)
            vor_job_ask(job, VOR_STOP);
        vor_job_release(job);
        return view.status == VOR_JOB_RUNNING ? VOR_DONE : VOR_CONFLICT;
    }
    outcome = row_view(worker, id, &view, err);
    return outcome == VOR_DONE ? VOR_CONFLICT : outcome;
}
