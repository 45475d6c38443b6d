#include "server/work/live.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/jobs/trace.h"

#include <assert.h>
#include <errno.h>
#include <search.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* --- the list of live jobs -------------------------------------------------------------------- */

static int compare_ids(const void *a, const void *b)
{
    return strcmp(((const struct vor_live *)a)->id, ((const struct vor_live *)b)->id);
}

/* The job of that id; NULL when there is none. The mutex is held. */
static struct vor_live *live_of(struct vor_worker *worker, const struct vor_uuid *id)
{
    const struct vor_live key = {.id = id->text};
    void *found = tfind(&key, &worker->live_by_id, compare_ids);

    return found != NULL ? *(struct vor_live **)found : NULL;
}

/* A job starts, or waits again; live may be NULL. The mutex is held. */
static void set_running(struct vor_worker *worker, struct vor_live *live, int running)
{
    if (live == NULL || live->running == running)
        return;
    live->running = running;
    if (running)
        worker->waiting_bytes -= live->bytes;
    else
        worker->waiting_bytes += live->bytes;
}

void vor_worker_requeue(struct vor_worker *worker, struct vor_job *job)
{
    struct vor_job_view view;
    struct vor_error err;

    pthread_mutex_lock(&worker->mutex);
    set_running(worker, live_of(worker, vor_job_id(job)), 0);
    pthread_mutex_unlock(&worker->mutex);
    vor_job_view(job, &view);
    if (vor_queue_restore(worker->queue, job, view.seq, &err) == VOR_OK)
        return;
    vor_log(VOR_LOG_ERROR, "a job waits for the next start", VOR_TEXT("job", view.id.text),
            VOR_TEXT("error", err.message));
    vor_worker_forget(worker, job);
}

struct vor_job *vor_worker_find(struct vor_worker *worker, const struct vor_uuid *id)
{
    struct vor_job *job;
    struct vor_live *live;

    pthread_mutex_lock(&worker->mutex);
    live = live_of(worker, id);
    job = live != NULL ? vor_job_retain(live->job) : NULL;
    pthread_mutex_unlock(&worker->mutex);
    return job;
}

vor_status vor_worker_remember(struct vor_worker *worker, struct vor_job *job,
                               struct vor_error *err)
{
    struct vor_live *live = malloc(sizeof *live);
    int is_added = 0;

    if (live == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a job");
    *live = (struct vor_live){.job = job, .id = vor_job_id(job)->text};
    pthread_mutex_lock(&worker->mutex);
    if (tsearch(live, &worker->live_by_id, compare_ids) != NULL) {
        (void)vor_job_retain(job);
        live->next = worker->live;
        if (live->next != NULL)
            live->next->before = live;
        worker->live = live;
        is_added = 1;
    }
    pthread_mutex_unlock(&worker->mutex);
    if (is_added)
        return VOR_OK;
    free(live);
    return vor_fail(err, VOR_E_NOMEM, "a job");
}

void vor_worker_forget(struct vor_worker *worker, const struct vor_job *job)
{
    struct vor_live *live;

    pthread_mutex_lock(&worker->mutex);
    live = live_of(worker, vor_job_id(job));
    if (live != NULL) {
        set_running(worker, live, 1); /* which waits no longer */
        (void)tdelete(live, &worker->live_by_id, compare_ids);
        *(live->before != NULL ? &live->before->next : &worker->live) = live->next;
        if (live->next != NULL)
            live->next->before = live->before;
    }
    pthread_mutex_unlock(&worker->mutex);
    if (live != NULL)
        vor_job_release(live->job);
    free(live);
}

int vor_worker_charge(struct vor_worker *worker, const struct vor_job *job, uint64_t bytes,
                      uint64_t most)
{
    struct vor_live *live;
    int fits;

    pthread_mutex_lock(&worker->mutex);
    fits = worker->waiting_bytes <= most && bytes <= most - worker->waiting_bytes;
    live = live_of(worker, vor_job_id(job));
    if (fits && live != NULL) {
        assert(!live->running && live->bytes == 0); /* once, before the queue has it */
        live->bytes = bytes;
        worker->waiting_bytes += bytes;
    }
    pthread_mutex_unlock(&worker->mutex);
    return fits;
}

uint64_t vor_worker_waiting_bytes(struct vor_worker *worker)
{
    uint64_t bytes;

    pthread_mutex_lock(&worker->mutex);
    bytes = worker->waiting_bytes;
    pthread_mutex_unlock(&worker->mutex);
    return bytes;
}

void vor_found_free(struct vor_found *found)
{
    free(found->blobs);
    *found = (struct vor_found){.blobs = NULL};
}

/* --- waiting and running ---------------------------------------------------------------------- */

int vor_worker_wait_until(struct vor_worker *worker, double deadline)
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
    while (!worker->draining && !vor_worker_wait_until(worker, deadline))
        continue;
    down = worker->draining;
    pthread_mutex_unlock(&worker->mutex);
    return down;
}

int vor_worker_enter(struct vor_worker *worker, const struct vor_job *job)
{
    int allowed;

    pthread_mutex_lock(&worker->mutex);
    allowed = !worker->draining;
    if (allowed) {
        worker->running++;
        set_running(worker, live_of(worker, vor_job_id(job)), 1);
    }
    pthread_mutex_unlock(&worker->mutex);
    return allowed;
}

void vor_worker_leave(struct vor_worker *worker)
{
    pthread_mutex_lock(&worker->mutex);
    worker->running--;
    pthread_cond_broadcast(&worker->changed);
    pthread_mutex_unlock(&worker->mutex);
}

/* --- ending ----------------------------------------------------------------------------------- */

void vor_worker_ending(struct vor_worker *worker, struct vor_job *job, enum vor_job_status status,
                       struct vor_job_view *out)
{
    vor_job_view(job, out);
    out->status = status;
    out->queue_position = -1;
    out->eta_seconds = -1;
    out->finished = vor_job_now(out, vor_clock_wall_ms());
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
        vor_log(VOR_LOG_WARN, "file not deleted", VOR_TEXT("job", id->text),
                VOR_TEXT("error", err.message));
}

void vor_worker_drop_inputs(struct vor_worker *worker, const struct vor_uuid *id,
                            const char *process)
{
    const struct vor_process_info *info = vor_process_find(process);
    char blob[VOR_BLOB_NAME_MAX + 1];

    for (unsigned i = 0; info != NULL && info->inputs[i].name != NULL; i++)
        vor_worker_drop(worker, id, vor_blob_of_input(info->inputs[i].name, blob));
}

void vor_worker_drop_uploads(struct vor_worker *worker, const struct vor_uuid *id,
                             const char *process)
{
    const struct vor_process_info *info = vor_process_find(process);
    char blob[VOR_BLOB_NAME_MAX + 1];

    for (unsigned i = 0; info != NULL && info->inputs[i].name != NULL; i++)
        vor_worker_drop(worker, id, vor_blob_of_upload(info->inputs[i].name, blob));
}

static void drop_converted(struct vor_worker *worker, const struct vor_uuid *id, const char *output)
{
    char blob[VOR_BLOB_NAME_MAX + 1];

    for (unsigned i = 0; vor_format(i) != NULL; i++)
        vor_worker_drop(worker, id, vor_blob_of_converted(output, vor_format(i)->name, blob));
}

void vor_worker_drop_outputs(struct vor_worker *worker, const struct vor_uuid *id,
                             const char *process)
{
    const struct vor_process_info *info = vor_process_find(process);

    for (unsigned i = 0; info != NULL && info->outputs[i].name != NULL; i++) {
        if (vor_output_in_row(&info->outputs[i]))
            continue;
        vor_worker_drop(worker, id, info->outputs[i].name);
        if (info->outputs[i].kind == VOR_ARTEFACT_CLOUD)
            drop_converted(worker, id, info->outputs[i].name);
    }
}

vor_status vor_worker_evict(struct vor_worker *worker, enum vor_evict why, struct vor_error *err)
{
    enum { BATCH = 64 };
    static const char *const done[] = {[VOR_EVICT_EXPIRED] = "results expired",
                                       [VOR_EVICT_UPLOADS] = "uploads deleted to make room",
                                       [VOR_EVICT_RESULTS] = "results deleted to make room"};
    const int64_t limit[] = {[VOR_EVICT_EXPIRED] = vor_clock_wall_ms(),
                             [VOR_EVICT_UPLOADS] = (int64_t)worker->config.keep,
                             [VOR_EVICT_RESULTS] = (int64_t)worker->config.results};
    struct vor_evicted job[BATCH];
    struct vor_evictions evictions = {.job = job, .max = BATCH};
    vor_status status = VOR_OK;
    size_t total = 0;

    do {
        status = vor_store_evict(worker->config.store, why, limit[why], &evictions, err);
        for (size_t i = 0; i < evictions.count; i++) {
            if (why != VOR_EVICT_UPLOADS)
                vor_worker_drop_outputs(worker, &job[i].id, job[i].process);
            vor_worker_drop_uploads(worker, &job[i].id, job[i].process);
        }
        total += evictions.count;
    } while (status == VOR_OK && evictions.count == BATCH);
    if (total > 0)
        vor_log(VOR_LOG_INFO, done[why], VOR_COUNT("jobs", total));
    return status;
}

void vor_worker_keep_quota(struct vor_worker *worker, enum vor_evict why)
{
    struct vor_error err;

    if (vor_worker_evict(worker, why, &err) != VOR_OK)
        vor_log(VOR_LOG_WARN, "uploads or results not deleted", VOR_TEXT("error", err.message));
}
