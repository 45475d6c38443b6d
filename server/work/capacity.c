/* What jobs take of the daemon, and taking in new ones. */
#include "server/work/active_jobs.h"

#include "proto/codec.h"
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/metrics.h"
#include "server/jobs/memory_estimate.h"
#include "server/jobs/time_estimate.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* Jobs that wait or have booked a place. The mutex is held, here and in the next. */
static size_t depth_of(const struct vor_job_service *service)
{
    int64_t depth = service->capacity.waiting + service->capacity.booked;

    return depth > 0 ? (size_t)depth : 0;
}

static enum vor_job_outcome room_of(const struct vor_job_service *service)
{
    if (service->draining)
        return VOR_DRAINING;
    return depth_of(service) < service->config.queue ? VOR_DONE : VOR_FULL;
}

/* Which limit a ledger that is over has passed, and the words for it. */
static enum vor_job_outcome refuse(const char *tenant, const struct vor_ledger *ledger,
                                   uint64_t bytes, struct vor_error *err)
{
    if (ledger->jobs_max > 0 && ledger->jobs >= ledger->jobs_max) {
        (void)vor_fail(err, VOR_E_LIMIT,
                       "the key %s has %llu waiting or running jobs; it may not have more", tenant,
                       (unsigned long long)ledger->jobs_max);
        return VOR_CROWDED;
    }
    (void)vor_fail(err, VOR_E_LIMIT,
                   "the key %s stores %llu bytes of inputs and results, and this request would add "
                   "%llu, want at most %llu in all: dismiss jobs, or wait until they expire",
                   tenant, (unsigned long long)ledger->bytes, (unsigned long long)bytes,
                   (unsigned long long)ledger->bytes_max);
    return VOR_OVER_BYTES;
}

enum vor_job_outcome vor_job_service_room(struct vor_job_service *service,
                                          const struct vor_job_label *label, uint64_t bytes,
                                          struct vor_error *err)
{
    struct vor_job_view view;
    struct vor_ledger ledger;
    enum vor_job_outcome room;
    int found;

    pthread_mutex_lock(&service->mutex);
    room = room_of(service);
    if (service->capacity.bytes >= service->config.queue_bytes && room == VOR_DONE)
        room = VOR_FULL;
    pthread_mutex_unlock(&service->mutex);
    if (label == NULL)
        return room;
    ledger = (struct vor_ledger){.jobs_max = label->jobs_max, .bytes_max = label->bytes_max};
    if (room == VOR_DONE && (ledger.jobs_max > 0 || ledger.bytes_max > 0)) {
        const char *tenant = label->key->principal;

        if (vor_store_ledger(service->config.store, tenant, &ledger, err) != VOR_OK)
            room = VOR_FAILED;
        else if (!vor_ledger_fits(&ledger, bytes))
            room = refuse(tenant, &ledger, bytes, err);
    }
    if (room != VOR_DONE && room != VOR_FAILED && label->key->text[0] != '\0' &&
        vor_store_find_key(service->config.store, label->key, &view, &found, NULL) == VOR_OK &&
        found)
        return VOR_DONE;
    return room;
}

enum vor_job_outcome vor_job_service_book(struct vor_job_service *service)
{
    enum vor_job_outcome room;

    pthread_mutex_lock(&service->mutex);
    room = room_of(service);
    service->capacity.booked += room == VOR_DONE;
    pthread_mutex_unlock(&service->mutex);
    return room;
}

void vor_job_service_unbook(struct vor_job_service *service)
{
    pthread_mutex_lock(&service->mutex);
    service->capacity.booked--;
    pthread_mutex_unlock(&service->mutex);
}

void vor_job_service_load(struct vor_job_service *service, struct vor_job_service_load *out)
{
    struct vor_waiting waiting;

    if (vor_store_waiting(service->config.store, &waiting, NULL) != VOR_OK)
        waiting.oldest_ms = 0;
    out->oldest_ms = waiting.oldest_ms;
    pthread_mutex_lock(&service->mutex);
    out->waiting = depth_of(service);
    out->running = service->capacity.running;
    out->reserved = service->capacity.used;
    pthread_mutex_unlock(&service->mutex);
    out->budget = service->config.budget;
}

void vor_capacity_begin(struct vor_job_service *service, const struct vor_waiting *waiting)
{
    pthread_mutex_lock(&service->mutex);
    service->capacity.waiting = (int64_t)waiting->jobs;
    service->capacity.bytes = waiting->decoded;
    pthread_mutex_unlock(&service->mutex);
}

/* Makes the row of a job durable that has booked a place, if its inputs still fit into the queue
 * and its principal may have it; it then waits. Unless VOR_DONE is returned it keeps the place. */
static enum vor_job_outcome insert(struct vor_job_service *service, struct vor_job_view *row,
                                   struct vor_ledger *ledger, struct vor_error *err)
{
    struct vor_capacity *capacity = &service->capacity;
    uint64_t most = service->config.queue_bytes;
    enum vor_job_outcome outcome = VOR_DONE;
    int fits;

    pthread_mutex_lock(&service->mutex);
    fits = capacity->bytes <= most && row->decoded <= most - capacity->bytes;
    capacity->bytes += fits ? row->decoded : 0;
    pthread_mutex_unlock(&service->mutex);
    if (!fits)
        return VOR_FULL;
    if (vor_store_insert(service->config.store, row, ledger, err) != VOR_OK)
        outcome = VOR_FAILED;
    else if (ledger->is_over)
        outcome = refuse(row->key.principal, ledger, row->kept, err);
    pthread_mutex_lock(&service->mutex);
    if (outcome == VOR_DONE) {
        capacity->booked--;
        capacity->waiting++;
        service->news++;
        pthread_cond_signal(&service->ready);
    } else {
        capacity->bytes -= row->decoded;
    }
    pthread_mutex_unlock(&service->mutex);
    return outcome;
}

/* The count may have been made anew meanwhile (vor_capacity_begin). */
static void take_bytes(struct vor_capacity *capacity, uint64_t bytes)
{
    capacity->bytes -= bytes < capacity->bytes ? bytes : capacity->bytes;
}

void vor_capacity_wait(struct vor_job_service *service, const struct vor_job_view *row, int by)
{
    pthread_mutex_lock(&service->mutex);
    service->capacity.waiting += by;
    if (by > 0)
        service->capacity.bytes += row->decoded;
    else
        take_bytes(&service->capacity, row->decoded);
    service->news++;
    pthread_cond_signal(&service->ready);
    pthread_mutex_unlock(&service->mutex);
}

int vor_capacity_claim(struct vor_job_service *service, struct vor_claim *claim)
{
    const struct vor_capacity *capacity = &service->capacity;
    int may;

    *claim = (struct vor_claim){
        .owner = service->owner.text, .now_ms = vor_clock_wall_ms(), .build = vor_build_own()};
    pthread_mutex_lock(&service->mutex);
    may = capacity->waiting > 0 && !service->draining && !atomic_load(&service->is_late) &&
          !(capacity->running > 0 && capacity->runs_alone);
    if (capacity->running == 0)
        claim->memory = UINT64_MAX;
    else if (capacity->used < service->config.budget)
        claim->memory = service->config.budget - capacity->used;
    /* A suspect need not wait where it is apart anyway. */
    claim->may_be_alone = capacity->running == 0 || service->config.executor->is_apart;
    pthread_mutex_unlock(&service->mutex);
    return may && vor_blobs_reach(service->config.blobs, NULL) == VOR_OK;
}

void vor_capacity_run(struct vor_job_service *service, const struct vor_job_view *row)
{
    struct vor_capacity *capacity = &service->capacity;

    capacity->waiting--;
    take_bytes(capacity, row->decoded);
    capacity->running++;
    capacity->used += row->memory;
    capacity->runs_alone = row->alone && !service->config.executor->is_apart;
}

void vor_capacity_leave(struct vor_job_service *service, const struct vor_job_view *row)
{
    struct vor_capacity *capacity = &service->capacity;

    capacity->running--;
    capacity->used -= row->memory;
    capacity->runs_alone = 0; /* who was alone was the only one */
    service->news++;
    pthread_cond_broadcast(&service->ready);
    pthread_cond_broadcast(&service->changed);
}

/* --- new jobs --------------------------------------------------------------------------------- */

/* Likewise what could never run, not even if its input has no noise: row has its inputs. A run
 * never has more memory than its cap. */
static vor_status check_need(const struct vor_job_service *service, struct vor_job_view *row,
                             struct vor_error *err)
{
    uint64_t need = vor_memory_estimate(&row->spec, row->inputs, row->input, VOR_FIT_CLEAN),
             most = vor_memory_estimate(&row->spec, row->inputs, row->input, VOR_FIT_NOISY),
             budget = service->config.budget;

    row->memory = most < service->config.memory ? most : service->config.memory;
    if (need <= budget)
        return VOR_OK;
    (void)vor_fail(err, VOR_E_NOMEM,
                   "the job needs about %llu bytes of memory, but all jobs together may use "
                   "only %llu",
                   (unsigned long long)need, (unsigned long long)budget);
    return vor_fail_over(err, VOR_E_NOMEM, budget, need);
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
                                 .build = vor_build_own(),
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
            return vor_fail_param(err, VOR_E_PARAM, name, "the process %s has no input %s",
                                  process->id, name);
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

static vor_status check_points(const struct vor_job_label *label,
                               const struct vor_admitted *admitted, struct vor_error *err)
{
    uint64_t most = label != NULL && label->points_max > 0 ? label->points_max : UINT64_MAX;

    for (unsigned i = 0; i < admitted->count; i++) {
        uint64_t points = admitted->item[i].found.points;

        if (points <= most)
            continue;
        (void)vor_fail(
            err, VOR_E_LIMIT, "the input %s has %llu points, want at most %llu with this key",
            admitted->item[i].name, (unsigned long long)points, (unsigned long long)most);
        return vor_fail_over(err, VOR_E_LIMIT, most, points);
    }
    return VOR_OK;
}

/* Bytes of decoded inputs that would never fit into the queue are no reason to come back later. */
static vor_status check_bytes(struct vor_job_service *service, const struct vor_admitted *admitted,
                              struct vor_job_view *row, struct vor_error *err)
{
    uint64_t most = service->config.queue_bytes;

    for (unsigned i = 0; i < admitted->count; i++)
        row->decoded += admitted->item[i].decoded;
    if (row->decoded <= most)
        return VOR_OK;
    (void)vor_fail(err, VOR_E_BYTES, "the decoded inputs have %llu bytes, want at most %llu",
                   (unsigned long long)row->decoded, (unsigned long long)most);
    return vor_fail_over(err, VOR_E_BYTES, most, row->decoded);
}

/* For a job that has a place in the queue, and keeps it when VOR_DONE is returned. */
static enum vor_job_outcome submit(struct vor_job_service *service, struct vor_job_view *row,
                                   const struct vor_job_label *label, struct vor_error *err)
{
    struct vor_ledger ledger = {.jobs_max = label != NULL ? label->jobs_max : 0,
                                .bytes_max = label != NULL ? label->bytes_max : 0};
    const char *tenant = row->key.principal;
    enum vor_job_outcome outcome;

    if (atomic_load(&service->is_late)) {
        (void)vor_fail_errno(err, ENOSPC, "recovering earlier jobs");
        return VOR_FAILED;
    }
    outcome = insert(service, row, &ledger, err);
    if (outcome != VOR_DONE)
        return outcome;
    vor_metric_add(VOR_METRIC_JOBS_ACCEPTED, 1, VOR_LABELS(row->process));
    vor_metric_observe(VOR_METRIC_JOB_POINTS, (double)row->input[0].points, VOR_LABELS("in"));
    vor_log(VOR_LOG_INFO, "job accepted", VOR_OF_JOB(row),
            VOR_TEXT("tenant", tenant[0] != '\0' ? tenant : NULL),
            VOR_TEXT("process", row->process), VOR_COUNT("points", row->input[0].points),
            VOR_COUNT("bytes", row->input[0].bytes));
    return VOR_DONE;
}

enum vor_job_outcome vor_job_service_submit(struct vor_job_service *service,
                                            const struct vor_admitted *admitted,
                                            const struct vor_spec *spec,
                                            const struct vor_job_label *label,
                                            struct vor_job_view *out, struct vor_error *err)
{
    enum vor_job_outcome outcome = VOR_FAILED;
    int booked = label != NULL && label->booked;
    struct vor_job_view row;

    first_row(&row, &admitted->id, spec, label);
    if (check_points(label, admitted, err) == VOR_OK &&
        take_inputs(&row, admitted, err) == VOR_OK &&
        check_bytes(service, admitted, &row, err) == VOR_OK &&
        (vor_spec_given(spec, VOR_PARAM_SPACING) ||
         vor_spec_check_target(spec, vor_spec_target(spec, row.input[0].points),
                               row.input[0].points, err) == VOR_OK) &&
        check_need(service, &row, err) == VOR_OK &&
        vor_time_estimate_check(&row.spec, row.input[0].points, service->config.executor->threads,
                                service->config.job_seconds, err) == VOR_OK &&
        check_origin(&row, admitted, err) == VOR_OK) {
        outcome = booked ? VOR_DONE : vor_job_service_book(service);
        booked = outcome == VOR_DONE;
    }
    if (outcome == VOR_DONE)
        outcome = submit(service, &row, label, err);
    if (outcome != VOR_DONE) {
        if (booked)
            vor_job_service_unbook(service);
        /* Inputs of one that may be there stay for it, or are found to be strays (sweeper.c). */
        if (outcome != VOR_FAILED || !vor_error_may_be_done(err))
            vor_admit_drop(service->config.blobs, admitted);
        return outcome;
    }
    atomic_store(&service->has_grown, 1);
    if (out != NULL)
        *out = row;
    return VOR_DONE;
}
