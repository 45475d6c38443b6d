/* The leases of what runs here: made longer as long as this process lives. */
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/work/active_jobs.h"

#include <string.h>

/* A lease outlives a disk that is slow, or a thread that waits for its core, for so long. */
static const double lease_seconds = 30, renew_seconds = 2;
static const double looked_seconds = 5; /* at points, after a renewal that says so */

/* True when a runner has this attempt; the mutex is held. */
static int is_run(const struct vor_job_service *service, const struct vor_leased *leased)
{
    const struct vor_runner *runner = service->runners;
    unsigned i = 0;

    while (i < service->runner_count &&
           (runner[i].job == NULL || runner[i].attempt != leased->attempt ||
            strcmp(vor_job_id(runner[i].job)->text, leased->id.text) != 0))
        i++;
    return i < service->runner_count;
}

int vor_job_service_hand_back(struct vor_job_service *service, const struct vor_uuid *id,
                              struct vor_hand_back *back)
{
    struct vor_error err;

    if (vor_store_hand_back(service->config.store, id, back, &err) == VOR_OK)
        return 1;
    vor_log(VOR_LOG_ERROR, "a job cannot be returned to the queue", VOR_TEXT("job", id->text),
            VOR_TEXT("error", err.message));
    return 0;
}

/* A job that the store counts as ours and no runner has: it was claimed, but the answer did not
 * come. It waits again; nothing is done to one that has just ended. */
static void return_unheard(struct vor_job_service *service, const struct vor_leased *leased)
{
    struct vor_hand_back back = {.lease = {service->owner.text, leased->attempt},
                                 .now_ms = vor_clock_wall_ms()};

    if (!vor_job_service_hand_back(service, &leased->id, &back)) {
        atomic_store(&service->may_be_unheard, 1);
    } else if (back.changed) {
        vor_log(VOR_LOG_WARN, "a claim was not answered; the job waits again",
                VOR_TEXT("job", leased->id.text), VOR_COUNT("attempt", leased->attempt));
        vor_job_service_news(service);
    }
}

/* What another daemon has done to the job of a runner. */
static void ask_as_told(const struct vor_renewal *renewal, const struct vor_runner *runner)
{
    size_t i = 0;

    while (i < renewal->count &&
           (renewal->job[i].attempt != runner->attempt ||
            strcmp(renewal->job[i].id.text, vor_job_id(runner->job)->text) != 0))
        i++;
    if (i == renewal->count)
        vor_job_ask(runner->job, VOR_CANCEL);
    else if (renewal->job[i].stops)
        vor_job_ask(runner->job, VOR_STOP);
    if (i < renewal->count && renewal->job[i].is_looked)
        vor_preview_look_elsewhere(vor_job_preview(runner->job),
                                   vor_clock_seconds() + looked_seconds);
}

void vor_job_service_store_late(struct vor_job_service *service)
{
    for (unsigned i = 0; i < service->config.jobs; i++) {
        struct vor_lease lease = {.owner = service->owner.text};
        struct vor_job *job = NULL;
        struct vor_error err;
        int changed;

        pthread_mutex_lock(&service->mutex);
        if (i < service->runner_count && service->runners[i].job != NULL) {
            job = vor_job_retain(service->runners[i].job);
            lease.attempt = service->runners[i].attempt;
        }
        pthread_mutex_unlock(&service->mutex);
        if (job == NULL)
            continue;
        if (!vor_job_is_stored(job) &&
            vor_job_service_store_events(service, job, &lease, &changed, &err) != VOR_OK)
            vor_log(VOR_LOG_WARN, "progress not stored", VOR_TEXT("job", vor_job_id(job)->text),
                    VOR_TEXT("error", err.message));
        vor_job_release(job);
        vor_job_service_renew(service); /* many jobs at a slow server take longer than a lease */
    }
}

void vor_job_service_renew(struct vor_job_service *service)
{
    enum { LEASED_MAX = 2 * VOR_RUNNING_JOBS_MAX };
    struct vor_leased jobs[LEASED_MAX], *unheard = jobs;
    struct vor_renewal renewal = {.owner = service->owner.text,
                                  .lease_ms = (int64_t)(1000 * lease_seconds),
                                  .job = jobs,
                                  .max = LEASED_MAX};
    struct vor_error err;
    vor_status status;
    int is_wanted; /* others look which daemons there are, and which engines run jobs */

    pthread_mutex_lock(&service->mutex);
    is_wanted = service->capacity.running > 0 || vor_store_is_shared(service->config.store);
    pthread_mutex_unlock(&service->mutex);
    if (service->config.jobs > 0)
        renewal.build = vor_build_own();
    if ((!is_wanted && !atomic_load(&service->may_be_unheard)) ||
        vor_clock_seconds() - service->renewed < renew_seconds)
        return;
    service->renewed = vor_clock_seconds();
    pthread_mutex_lock(&service->claim); /* no lease begins meanwhile */
    status = vor_store_renew(service->config.store, &renewal, &err);
    pthread_mutex_lock(&service->mutex);
    for (unsigned i = 0;
         status == VOR_OK && renewal.count <= renewal.max && i < service->runner_count; i++)
        if (service->runners[i].job != NULL)
            ask_as_told(&renewal, &service->runners[i]);
    for (size_t i = 0; status == VOR_OK && i < renewal.count && i < renewal.max; i++)
        if (!is_run(service, &jobs[i]))
            *unheard++ = jobs[i];
    pthread_mutex_unlock(&service->mutex);
    if (status == VOR_OK)
        atomic_store(&service->may_be_unheard, 0);
    while (unheard > jobs)
        return_unheard(service, --unheard);
    pthread_mutex_unlock(&service->claim);
    if (status != VOR_OK)
        vor_log(VOR_LOG_WARN, "leases not renewed", VOR_TEXT("error", err.message));
}
