/* Where other daemons share the store: what they do to jobs is seen here. A job that somebody here
 * waits for, and that no runner here has, follows its row. */
#include "server/work/active_jobs.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/metrics.h"

#include <stdlib.h>

/* Between two looks for jobs whose daemon has ended; their leases are much longer. While the store
 * was away nobody could renew his: those who live have done so when it has been back for that long.
 */
static const double reap_seconds = 5, renewed_seconds = 10;

/* For so long the owner of a job is told that somebody looks (vor_store_look). */
static const double told_seconds = 10;

static int take_last(void *ctx, const struct vor_event_piece *piece)
{
    *(uint32_t *)ctx = piece->last;
    return 1;
}

vor_status vor_job_service_mirror(struct vor_job_service *service, struct vor_job *job,
                                  struct vor_error *err)
{
    struct vor_job_view row = {.attempt = 0};
    uint32_t last = 0;
    int found = 0;
    vor_status status = VOR_OK;

    pthread_mutex_lock(&service->claim); /* no runner takes it meanwhile */
    if (!vor_job_service_is_running(service, job))
        status = vor_store_get(service->config.store, vor_job_id(job), NULL, &row, &found, err);
    if (status == VOR_OK && found && row.status != VOR_JOB_ACCEPTED) {
        struct vor_event_query query = {.attempt = row.attempt, .each = take_last, .ctx = &last};

        last = query.after = vor_job_newest(job, row.attempt);
        status = vor_store_events(service->config.store, &row.id, &query, err);
    }
    if (status == VOR_OK && found)
        vor_job_mirror(job, &row, last);
    pthread_mutex_unlock(&service->claim);
    if (status == VOR_OK && found && vor_job_is_over(job))
        vor_job_service_forget(service, job);
    return status;
}

struct looking {
    struct vor_job *job;
    uint32_t attempt;
};

static int take_shown(void *ctx, const struct vor_event_piece *piece)
{
    const struct looking *looking = ctx;

    if (piece->size > 0)
        vor_job_show_packed(looking->job, looking->attempt, piece);
    return 1;
}

vor_status vor_job_service_mirror_preview(struct vor_job_service *service, struct vor_job *job,
                                          struct vor_error *err)
{
    struct vor_event_query query = {.attempt = VOR_STORE_PREVIEW, .each = take_shown};
    struct vor_job_view view;
    struct looking looking = {.job = job};

    vor_job_view(job, &view);
    looking.attempt = view.attempt;
    query.after = (uint32_t)vor_preview_unpacked(vor_job_preview(job), view.attempt);
    query.ctx = &looking;
    return vor_job_service_is_running(service, job) || !vor_store_is_shared(service->config.store)
               ? VOR_OK
               : vor_store_events(service->config.store, vor_job_id(job), &query, err);
}

/* Somebody here looks at the points of a job that another daemon runs: it is told, before what it
 * was told is over, and what it shows is taken in. */
static void look(struct vor_job_service *service, struct vor_job *job)
{
    struct vor_preview *preview = vor_job_preview(job);
    vor_status status = VOR_OK;
    struct vor_error err;

    if (!vor_preview_is_looked_at_here(preview) || vor_job_service_is_running(service, job))
        return;
    if (!vor_preview_is_looked_at_elsewhere(preview, told_seconds / 2)) {
        status = vor_store_look(service->config.store, vor_job_id(job), &err);
        if (status == VOR_OK)
            vor_preview_look_elsewhere(preview, vor_clock_seconds() + told_seconds);
    }
    VOR_THEN(status, vor_job_service_mirror_preview(service, job, &err));
    if (status != VOR_OK)
        vor_log(VOR_LOG_DEBUG, "no preview of a job that another daemon runs",
                VOR_TEXT("job", vor_job_id(job)->text), VOR_TEXT("error", err.message));
}

/* What waits in the store, which others add to and take from. */
static void count_waiting(struct vor_job_service *service)
{
    struct vor_waiting waiting;

    if (vor_store_waiting(service->config.store, &waiting, NULL) != VOR_OK)
        return;
    vor_capacity_begin(service, &waiting);
    if (waiting.jobs > 0)
        vor_job_service_news(service);
}

static void reap(struct vor_job_service *service)
{
    struct vor_error err;
    uint64_t reaped = 0;

    if (vor_clock_seconds() - service->reaped < reap_seconds ||
        vor_clock_seconds() - service->unreached < renewed_seconds)
        return;
    service->reaped = vor_clock_seconds();
    if (vor_store_reap(service->config.store, service->owner.text, 0, vor_clock_wall_ms(), &reaped,
                       &err) != VOR_OK) {
        vor_log(VOR_LOG_WARN, "leases that have ended are not looked for",
                VOR_TEXT("error", err.message));
        return;
    }
    if (reaped > 0)
        vor_log(VOR_LOG_WARN, "jobs of a daemon that ended wait again", VOR_COUNT("jobs", reaped));
    vor_metric_add(VOR_METRIC_JOBS_AGAIN, (double)reaped, VOR_LABELS("lease"));
}

void vor_job_service_follow_others(struct vor_job_service *service)
{
    struct vor_job **jobs;
    size_t count;

    if (!vor_store_is_shared(service->config.store)) {
        if (vor_store_is_unsure(service->config.store))
            count_waiting(service);
        return;
    }
    reap(service);
    count_waiting(service);
    jobs = vor_job_service_live(service, &count);
    for (size_t i = 0; i < count; i++) {
        struct vor_error err;

        if (vor_job_service_mirror(service, jobs[i], &err) != VOR_OK)
            vor_log(VOR_LOG_WARN, "a job that another daemon may run is not followed",
                    VOR_TEXT("job", vor_job_id(jobs[i])->text), VOR_TEXT("error", err.message));
        look(service, jobs[i]);
        vor_job_release(jobs[i]);
    }
    free(jobs);
}
