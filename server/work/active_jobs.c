#define _GNU_SOURCE /* twalk_r */
#include "server/work/active_jobs.h"

#include "server/base/clock.h"
#include "server/base/log.h"

#include <search.h>
#include <stdlib.h>
#include <string.h>

/* --- live jobs -------------------------------------------------------------------------------- */

/* Of a node: a job, or what is looked for, which both begin with the identifier. */
static int compare_ids(const void *a, const void *b)
{
    return strcmp(((const struct vor_uuid *)a)->text, ((const struct vor_uuid *)b)->text);
}

struct vor_job *vor_job_service_find(struct vor_job_service *service, const struct vor_uuid *id)
{
    struct vor_job **found, *job = NULL;

    pthread_mutex_lock(&service->mutex);
    found = tfind(id, &service->live, compare_ids);
    if (found != NULL)
        job = vor_job_retain(*found);
    pthread_mutex_unlock(&service->mutex);
    return job;
}

struct vor_job *vor_job_service_enliven(struct vor_job_service *service,
                                        const struct vor_job_view *row)
{
    struct vor_job_view waits = *row;
    struct vor_job *fresh, **found, *job = NULL;

    waits.status = VOR_JOB_ACCEPTED;
    waits.stage = VOR_STAGE_QUEUED;
    fresh = vor_job_create(&waits);
    if (fresh == NULL)
        return NULL;
    pthread_mutex_lock(&service->mutex);
    found = tsearch(fresh, &service->live, compare_ids);
    if (found != NULL)
        job = vor_job_retain(*found);
    pthread_mutex_unlock(&service->mutex);
    if (job != fresh)
        vor_job_release(fresh);
    return job;
}

struct gathered {
    struct vor_job **job;
    size_t count, capacity;
};

static void gather(const void *node, VISIT visit, void *ctx)
{
    struct gathered *gathered = ctx;

    if (visit != postorder && visit != leaf)
        return;
    if (gathered->count == gathered->capacity) {
        size_t capacity = 2 * gathered->capacity + 16;
        struct vor_job **more = realloc(gathered->job, capacity * sizeof(struct vor_job *));

        if (more == NULL)
            return;
        gathered->job = more;
        gathered->capacity = capacity;
    }
    gathered->job[gathered->count++] = vor_job_retain(*(struct vor_job *const *)node);
}

struct vor_job **vor_job_service_live(struct vor_job_service *service, size_t *count)
{
    struct gathered gathered = {.job = NULL};

    pthread_mutex_lock(&service->mutex);
    twalk_r(service->live, gather, &gathered);
    pthread_mutex_unlock(&service->mutex);
    *count = gathered.count;
    return gathered.job;
}

void vor_job_service_forget(struct vor_job_service *service, struct vor_job *job)
{
    struct vor_job **found;
    int is_there;

    pthread_mutex_lock(&service->mutex);
    found = tfind(job, &service->live, compare_ids);
    is_there = found != NULL && *found == job;
    if (is_there)
        (void)tdelete(job, &service->live, compare_ids);
    pthread_mutex_unlock(&service->mutex);
    if (is_there)
        vor_job_release(job);
}

void vor_job_service_forget_all(struct vor_job_service *service)
{
    while (service->live != NULL)
        vor_job_service_forget(service, *(struct vor_job **)service->live);
}

int vor_job_service_is_running(struct vor_job_service *service, const struct vor_job *job)
{
    int is_running = 0;

    pthread_mutex_lock(&service->mutex);
    for (unsigned i = 0; i < service->runner_count; i++)
        is_running |= service->runners[i].job == job;
    pthread_mutex_unlock(&service->mutex);
    return is_running;
}

void vor_found_free(struct vor_found *found)
{
    free(found->list.entry);
    *found = (struct vor_found){.list = {.count = 0}};
}

/* --- waiting and running ---------------------------------------------------------------------- */

void vor_job_service_news(struct vor_job_service *service)
{
    pthread_mutex_lock(&service->mutex);
    service->news++;
    pthread_cond_broadcast(&service->ready);
    pthread_mutex_unlock(&service->mutex);
}

int vor_job_service_pause(struct vor_job_service *service, double seconds)
{
    double deadline = vor_clock_seconds() + seconds;
    int down;

    pthread_mutex_lock(&service->mutex);
    while (!service->draining && !vor_clock_wait(&service->changed, &service->mutex, deadline))
        continue;
    down = service->draining;
    pthread_mutex_unlock(&service->mutex);
    return down;
}

/* --- ending ----------------------------------------------------------------------------------- */

void vor_job_service_ending(struct vor_job_service *service, struct vor_job *job,
                            enum vor_job_status status, struct vor_job_view *out)
{
    vor_job_view(job, out);
    out->status = status;
    out->queue_position = -1;
    out->eta_seconds = -1;
    out->finished = vor_job_now(out, vor_clock_wall_ms());
    out->updated = out->finished;
    out->expires = out->finished + (int64_t)(service->config.ttl_seconds * 1000);
}

vor_status vor_job_service_finish(struct vor_job_service *service, struct vor_job *job,
                                  const struct vor_job_view *row, const struct vor_lease *lease,
                                  const char *report, int *changed, struct vor_error *err)
{
    const struct vor_store_ending ending = {.report = report, .events = vor_job_piece(job)};
    vor_status status = vor_store_finish(service->config.store, row, lease, &ending, changed, err);

    if (status == VOR_OK && *changed)
        vor_job_end(job, row);
    return status;
}

vor_status vor_job_service_store_events(struct vor_job_service *service, struct vor_job *job,
                                        const struct vor_lease *lease, int *changed,
                                        struct vor_error *err)
{
    struct vor_event_piece piece;
    struct vor_job_view row;
    vor_status status;

    *changed = 1;
    if (!vor_job_freeze(job))
        return VOR_OK; /* over: all are stored */
    vor_job_view(job, &row);
    piece = vor_job_piece(job);
    status = vor_store_append_events(service->config.store, &row, lease, &piece, changed, err);
    if (status == VOR_OK && *changed)
        vor_job_stored(job);
    vor_job_thaw(job);
    return status;
}

void vor_job_service_drop_all(struct vor_job_service *service, const struct vor_uuid *id,
                              const char *process, uint32_t attempts, unsigned what)
{
    static const struct vor_artefact_info none = {.name = NULL};
    const struct vor_process_info *info = vor_process_find(process);
    const struct vor_artefact_info *input = info != NULL ? info->inputs : &none,
                                   *output = info != NULL ? info->outputs : &none;
    struct vor_blobs *blobs = service->config.blobs;
    char blob[VOR_BLOB_NAME_MAX + 1];

    if ((what & VOR_HAS_CHECKPOINT) != 0)
        vor_drop_file(blobs, id, vor_blob_of_input(VOR_BLOB_CHECKPOINT, blob));
    for (unsigned inputs = what >> 3; input->name != NULL; input++, inputs >>= 1) {
        if ((inputs & 1) != 0)
            vor_drop_file(blobs, id, vor_blob_of_input(input->name, blob));
        if ((what & VOR_HAS_UPLOADS) != 0)
            vor_drop_file(blobs, id, vor_blob_of_upload(input->name, blob));
    }
    for (; (what & VOR_HAS_OUTPUTS) != 0 && output->name != NULL; output++) {
        if (vor_output_in_row(output))
            continue;
        for (uint32_t k = 1; k <= attempts; k++)
            vor_drop_file(blobs, id, vor_blob_of_output(output->name, k, blob));
        for (unsigned i = 0; output->kind == VOR_ARTEFACT_CLOUD && vor_format(i) != NULL; i++)
            vor_drop_file(blobs, id,
                          vor_blob_of_converted(output->name, vor_format(i)->name, blob));
    }
}

vor_status vor_job_service_evict(struct vor_job_service *service, enum vor_evict why,
                                 struct vor_error *err)
{
    enum { BATCH = 16 }; /* others that change jobs wait meanwhile */
    static const char *const done[] = {[VOR_EVICT_EXPIRED] = "results expired",
                                       [VOR_EVICT_UPLOADS] = "uploads deleted to make room",
                                       [VOR_EVICT_RESULTS] = "results deleted to make room"};
    const int is_shared = vor_store_is_shared(service->config.store);
    const int64_t limit[] = {[VOR_EVICT_EXPIRED] = is_shared ? 0 : vor_clock_wall_ms(),
                             [VOR_EVICT_UPLOADS] = (int64_t)service->config.keep,
                             [VOR_EVICT_RESULTS] = (int64_t)service->config.results};
    struct vor_evicted job[BATCH];
    struct vor_evictions evictions = {.job = job, .max = BATCH};
    vor_status status = VOR_OK;
    size_t total = 0;

    do {
        status = vor_store_evict(service->config.store, why, limit[why], &evictions, err);
        for (size_t i = 0; i < evictions.count; i++)
            vor_job_service_drop_all(service, &job[i].id, job[i].process, job[i].attempt,
                                     why == VOR_EVICT_UPLOADS ? VOR_HAS_UPLOADS
                                                              : VOR_HAS_UPLOADS | VOR_HAS_OUTPUTS);
        total += evictions.count;
    } while (status == VOR_OK && evictions.count == BATCH);
    if (total > 0)
        vor_log(VOR_LOG_INFO, done[why], VOR_COUNT("jobs", total));
    return status;
}
