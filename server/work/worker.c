#include "server/work/worker.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/jobs/trace.h"
#include "server/work/internal.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SWEEP_SECONDS = 60 };

/* --- the list of live jobs -------------------------------------------------------------------- */

/* The place of a job in the list, or that of NULL at its end; the mutex is held. */
static struct vor_live **place_of(struct vor_worker *worker, const struct vor_uuid *id)
{
    struct vor_live **at = &worker->live;

    while (*at != NULL && strcmp(vor_job_id((*at)->job)->text, id->text) != 0)
        at = &(*at)->next;
    return at;
}

struct vor_job *vor_worker_find(struct vor_worker *worker, const struct vor_uuid *id)
{
    struct vor_job *job = NULL;
    struct vor_live *live;

    pthread_mutex_lock(&worker->mutex);
    live = *place_of(worker, id);
    if (live != NULL)
        job = vor_job_retain(live->job);
    pthread_mutex_unlock(&worker->mutex);
    return job;
}

vor_status vor_worker_remember(struct vor_worker *worker, struct vor_job *job,
                               struct vor_error *err)
{
    struct vor_live *live = calloc(1, sizeof *live);

    if (live == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a job");
    live->job = vor_job_retain(job);
    pthread_mutex_lock(&worker->mutex);
    live->next = worker->live;
    worker->live = live;
    pthread_mutex_unlock(&worker->mutex);
    return VOR_OK;
}

void vor_worker_forget(struct vor_worker *worker, const struct vor_job *job)
{
    struct vor_live **at, *live;

    pthread_mutex_lock(&worker->mutex);
    at = place_of(worker, vor_job_id(job));
    live = *at;
    if (live != NULL)
        *at = live->next;
    pthread_mutex_unlock(&worker->mutex);
    if (live != NULL)
        vor_job_release(live->job);
    free(live);
}

/* --- threads ---------------------------------------------------------------------------------- */

/* Waits until something changed or the deadline is over; the mutex is held. True when it is over.
 */
static int wait_until(struct vor_worker *worker, double deadline)
{
    struct timespec at = {.tv_sec = (time_t)deadline};

    at.tv_nsec = (long)((deadline - (double)at.tv_sec) * 1e9);
    return pthread_cond_timedwait(&worker->changed, &worker->mutex, &at) == ETIMEDOUT;
}

int vor_worker_pause(struct vor_worker *worker, double seconds)
{
    double deadline = vor_clock_seconds() + seconds;
    int down;

    pthread_mutex_lock(&worker->mutex);
    while (!worker->draining && !wait_until(worker, deadline))
        continue;
    down = worker->draining;
    pthread_mutex_unlock(&worker->mutex);
    return down;
}

/* True when the job may run; it then counts as running. */
static int enter(struct vor_worker *worker, const struct vor_job *job)
{
    int allowed;

    pthread_mutex_lock(&worker->mutex);
    allowed = !worker->draining;
    if (allowed) {
        struct vor_live *live = *place_of(worker, vor_job_id(job));

        worker->running++;
        if (live != NULL)
            live->running = 1;
    }
    pthread_mutex_unlock(&worker->mutex);
    return allowed;
}

static void leave(struct vor_worker *worker)
{
    pthread_mutex_lock(&worker->mutex);
    worker->running--;
    pthread_cond_broadcast(&worker->changed);
    pthread_mutex_unlock(&worker->mutex);
}

static void *runner_main(void *arg)
{
    struct vor_worker *worker = arg;
    struct vor_job *job;

    while ((job = vor_queue_pop(worker->queue)) != NULL) {
        if (enter(worker, job)) {
            vor_worker_run(worker, job);
            vor_worker_forget(worker, job);
            leave(worker);
        }
        vor_job_release(job);
    }
    return NULL;
}

static void *sweeper_main(void *arg)
{
    struct vor_worker *worker = arg;

    while (!vor_worker_pause(worker, SWEEP_SECONDS)) {
        struct vor_error err;

        if (vor_worker_sweep(worker, &err) != VOR_OK)
            vor_log(VOR_LOG_ERROR, "sweeping failed", VOR_TEXT("error", err.message));
    }
    return NULL;
}

static vor_status start_threads(struct vor_worker *worker, struct vor_error *err)
{
    while (worker->runner_count < worker->config.jobs) {
        if (pthread_create(&worker->runners[worker->runner_count], NULL, runner_main, worker) != 0)
            return vor_fail(err, VOR_E_NOMEM, "cannot start %u runners", worker->config.jobs);
        worker->runner_count++;
    }
    if (pthread_create(&worker->sweeper, NULL, sweeper_main, worker) != 0)
        return vor_fail(err, VOR_E_NOMEM, "cannot start the sweeper");
    worker->sweeper_started = 1;
    return VOR_OK;
}

static void init_locks(struct vor_worker *worker)
{
    pthread_condattr_t monotonic;

    pthread_mutex_init(&worker->mutex, NULL);
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&worker->changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

vor_status vor_worker_create(struct vor_worker **out, const struct vor_worker_config *config,
                             struct vor_error *err)
{
    struct vor_worker *worker = calloc(1, sizeof *worker);
    vor_status status = VOR_OK;

    assert(config->jobs >= 1 && config->jobs <= VOR_WORKER_JOBS_MAX && config->queue >= 1);
    if (worker == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the worker");
    worker->config = *config;
    init_locks(worker);
    worker->queue = vor_queue_create(config->queue);
    if (worker->queue == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "the queue");
    if (status == VOR_OK)
        status = vor_worker_recover(worker, err);
    if (status == VOR_OK)
        status = start_threads(worker, err);
    if (status != VOR_OK) {
        vor_worker_destroy(worker);
        return status;
    }
    *out = worker;
    return VOR_OK;
}

/* Asks whatever runs to end; the mutex is held. */
static void abort_running(struct vor_worker *worker)
{
    worker->aborting = 1;
    for (struct vor_live *live = worker->live; live != NULL; live = live->next)
        if (live->running)
            vor_job_ask(live->job, VOR_CANCEL);
}

void vor_worker_drain(struct vor_worker *worker, double seconds)
{
    double deadline = vor_clock_seconds() + seconds;

    if (worker->queue != NULL)
        vor_queue_close(worker->queue);
    pthread_mutex_lock(&worker->mutex);
    worker->draining = 1;
    pthread_cond_broadcast(&worker->changed);
    while (worker->running > 0 && !wait_until(worker, deadline))
        continue;
    abort_running(worker);
    while (worker->running > 0)
        pthread_cond_wait(&worker->changed, &worker->mutex);
    pthread_mutex_unlock(&worker->mutex);
}

void vor_worker_destroy(struct vor_worker *worker)
{
    if (worker == NULL)
        return;
    vor_worker_drain(worker, 0);
    for (unsigned i = 0; i < worker->runner_count; i++)
        pthread_join(worker->runners[i], NULL);
    if (worker->sweeper_started)
        pthread_join(worker->sweeper, NULL);
    vor_queue_destroy(worker->queue);
    while (worker->live != NULL)
        vor_worker_forget(worker, worker->live->job);
    pthread_cond_destroy(&worker->changed);
    pthread_mutex_destroy(&worker->mutex);
    free(worker);
}

/* --- ending ----------------------------------------------------------------------------------- */

void vor_worker_ending(struct vor_worker *worker, struct vor_job *job, enum vor_job_status status,
                       struct vor_job_view *out)
{
    vor_job_view(job, out);
    out->status = status;
    out->queue_position = -1;
    out->eta_seconds = -1;
    out->finished = vor_clock_wall_ms();
    out->updated = out->finished;
    out->expires = out->finished + (int64_t)(worker->config.ttl_seconds * 1000);
}

vor_status vor_worker_finish(struct vor_worker *worker, struct vor_job *job,
                             const struct vor_job_view *row, uint32_t attempt, const char *report,
                             int *changed, struct vor_error *err)
{
    struct vor_store_ending ending = {.report = report};
    uint8_t *trace = NULL;
    vor_status status = vor_trace_pack(vor_job_bus(job), &trace, &ending.trace_size, err);

    *changed = 0;
    ending.trace = trace;
    if (status == VOR_OK)
        status = vor_store_finish(worker->config.store, row, attempt, &ending, changed, err);
    if (status == VOR_OK && *changed)
        vor_job_end(job, row);
    free(trace);
    return status;
}

void vor_worker_drop(struct vor_worker *worker, const struct vor_uuid *id, const char *name)
{
    struct vor_error err;

    if (vor_blob_drop(worker->config.blobs, id, name, &err) != VOR_OK)
        vor_log(VOR_LOG_WARN, "bytes left behind", VOR_TEXT("job", id->text),
                VOR_TEXT("error", err.message));
}

vor_status vor_worker_sweep(struct vor_worker *worker, struct vor_error *err)
{
    enum { BATCH = 256 };
    struct vor_uuid ids[BATCH];
    size_t count = BATCH, total = 0;
    vor_status status = VOR_OK;

    while (status == VOR_OK && count == BATCH) {
        status =
            vor_store_expire(worker->config.store, vor_clock_wall_ms(), ids, BATCH, &count, err);
        for (size_t i = 0; i < count; i++)
            vor_worker_drop(worker, &ids[i], VOR_BLOB_CLOUD);
        total += count;
    }
    if (total > 0)
        vor_log(VOR_LOG_INFO, "results expired", VOR_COUNT("jobs", total));
    return status;
}
