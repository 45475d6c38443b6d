#include "server/work/live.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/jobs/trace.h"

#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* --- the list of live jobs -------------------------------------------------------------------- */

/* The place of a job in the list, or that of NULL at its end; the mutex is held. */
static struct vor_live **place_of(struct vor_worker *worker, const struct vor_uuid *id)
{
    struct vor_live **at = &worker->live;

    while (*at != NULL && strcmp(vor_job_id((*at)->job)->text, id->text) != 0)
        at = &(*at)->next;
    return at;
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
    set_running(worker, *place_of(worker, vor_job_id(job)), 0);
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
    struct vor_job *job = NULL;
    struct vor_live *live;

    pthread_mutex_lock(&worker->mutex);
    live = *place_of(worker, id);
    if (live != NULL)
        job = vor_job_retain(live->job);
    pthread_mutex_unlock(&worker->mutex);
    return job;
}

/* The jobs of a principal on the list; one whose runner has not unwound yet is over. The mutex is
 * held. */
static size_t count_of(const struct vor_worker *worker, const char *tenant)
{
    size_t count = 0;

    for (const struct vor_live *live = worker->live; live != NULL; live = live->next)
        count += strcmp(vor_job_tenant(live->job), tenant) == 0 && !vor_job_is_over(live->job);
    return count;
}

size_t vor_worker_jobs_of(struct vor_worker *worker, const char *tenant)
{
    size_t count;

    pthread_mutex_lock(&worker->mutex);
    count = count_of(worker, tenant);
    pthread_mutex_unlock(&worker->mutex);
    return count;
}

enum vor_job_outcome vor_worker_admit(struct vor_worker *worker, struct vor_job *job, size_t most,
                                      struct vor_error *err)
{
    struct vor_live *live = calloc(1, sizeof *live);
    int is_crowded;

    if (live == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "a job");
        return VOR_FAILED;
    }
    pthread_mutex_lock(&worker->mutex);
    is_crowded = most > 0 && count_of(worker, vor_job_tenant(job)) >= most;
    if (!is_crowded) {
        *live = (struct vor_live){.job = vor_job_retain(job), .next = worker->live};
        worker->live = live;
    }
    pthread_mutex_unlock(&worker->mutex);
    if (is_crowded)
        free(live);
    return is_crowded ? VOR_CROWDED : VOR_DONE;
}

vor_status vor_worker_remember(struct vor_worker *worker, struct vor_job *job,
                               struct vor_error *err)
{
    return vor_worker_admit(worker, job, 0, err) == VOR_DONE ? VOR_OK : VOR_E_NOMEM;
}

void vor_worker_forget(struct vor_worker *worker, const struct vor_job *job)
{
    struct vor_live **at, *live;

    pthread_mutex_lock(&worker->mutex);
    at = place_of(worker, vor_job_id(job));
    live = *at;
    if (live != NULL) {
        set_running(worker, live, 1); /* which waits no longer */
        *at = live->next;
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
    live = *place_of(worker, vor_job_id(job));
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
        set_running(worker, *place_of(worker, vor_job_id(job)), 1);
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

void vor_worker_shed(struct vor_worker *worker)
{
    enum { BATCH = 64 };
    struct vor_expired shed[BATCH];
    size_t count = BATCH, total = 0;
    struct vor_error err;

    while (count == BATCH) {
        if (vor_store_shed(worker->config.store, worker->config.keep, shed, BATCH, &count, &err) !=
            VOR_OK)
            vor_log(VOR_LOG_WARN, "uploads not deleted", VOR_TEXT("error", err.message));
        for (size_t i = 0; i < count; i++)
            vor_worker_drop_uploads(worker, &shed[i].id, shed[i].process);
        total += count;
    }
    if (total > 0)
        vor_log(VOR_LOG_INFO, "uploads shed", VOR_COUNT("jobs", total));
}

void vor_worker_crowd(struct vor_worker *worker)
{
    enum { BATCH = 64 };
    struct vor_expired crowded[BATCH];
    size_t count = BATCH, total = 0;
    struct vor_error err;

    while (count == BATCH) {
        if (vor_store_crowd(worker->config.store, worker->config.results, crowded, BATCH, &count,
                            &err) != VOR_OK)
            vor_log(VOR_LOG_WARN, "results not deleted", VOR_TEXT("error", err.message));
        for (size_t i = 0; i < count; i++) {
            vor_worker_drop_outputs(worker, &crowded[i].id, crowded[i].process);
            vor_worker_drop_uploads(worker, &crowded[i].id, crowded[i].process);
        }
        total += count;
    }
    if (total > 0)
        vor_log(VOR_LOG_INFO, "results deleted to make room", VOR_COUNT("jobs", total));
}
