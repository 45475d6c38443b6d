/* The leases of what runs here: made longer as long as this process lives. */
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/work/live.h"

#include <string.h>

/* A lease outlives a disk that is slow, or a thread that waits for its core, for so long. */
static const double lease_seconds = 30, renew_seconds = 5;

int64_t vor_worker_lease_until(void)
{
    return vor_clock_wall_ms() + (int64_t)(1000 * lease_seconds);
}

static int is_leased(const struct vor_renewal *renewal, const struct vor_runner *runner)
{
    size_t i = 0;

    while (i < renewal->count &&
           (renewal->job[i].attempt != runner->attempt ||
            strcmp(renewal->job[i].id.text, vor_job_id(runner->job)->text) != 0))
        i++;
    return i < renewal->count;
}

void vor_worker_renew(struct vor_worker *worker)
{
    struct vor_leased jobs[VOR_WORKER_JOBS_MAX];
    struct vor_renewal renewal = {.owner = worker->owner.text,
                                  .until_ms = vor_worker_lease_until(),
                                  .job = jobs,
                                  .max = VOR_WORKER_JOBS_MAX};
    struct vor_error err;
    vor_status status;
    int runs;

    pthread_mutex_lock(&worker->mutex);
    runs = worker->capacity.running > 0;
    pthread_mutex_unlock(&worker->mutex);
    if (!runs || vor_clock_seconds() - worker->renewed < renew_seconds)
        return;
    worker->renewed = vor_clock_seconds();
    pthread_mutex_lock(&worker->claim); /* no lease begins meanwhile */
    status = vor_store_renew(worker->config.store, &renewal, &err);
    pthread_mutex_lock(&worker->mutex);
    for (unsigned i = 0;
         status == VOR_OK && renewal.count <= renewal.max && i < worker->runner_count; i++)
        if (worker->runners[i].job != NULL && !is_leased(&renewal, &worker->runners[i]))
            vor_job_ask(worker->runners[i].job, VOR_CANCEL);
    pthread_mutex_unlock(&worker->mutex);
    pthread_mutex_unlock(&worker->claim);
    if (status != VOR_OK)
        vor_log(VOR_LOG_WARN, "leases not renewed", VOR_TEXT("error", err.message));
}
