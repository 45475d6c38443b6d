/* The job service from its start to its end: recovery, threads, draining. */
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/work/active_jobs.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>

/* The store has one connection that writes, so a second thread only helps while the first one
 * removes files. */
enum { POOL_THREADS = 2 };

static const double again_seconds = 0.5; /* after a claim that failed */

/* Between two times that a job's progress is stored, for daemons that poll and for those that are
 * told. */
static const double late_seconds = 1, told_seconds = 0.25;

/* A claimed row becomes what its runner runs; false when memory is out, or a runner here has not
 * heard yet that it lost the job: it is told. */
static int take_job(struct vor_runner *runner, const struct vor_job_view *row)
{
    struct vor_job_service *service = runner->service;
    struct vor_job *job = vor_job_service_enliven(service, row);

    if (job == NULL)
        return 0;
    if (vor_store_is_shared(service->config.store)) { /* its last attempt may have been elsewhere */
        struct vor_job_view waits = *row;

        if (vor_job_service_is_running(service, job)) {
            vor_job_ask(job, VOR_CANCEL);
            vor_job_release(job);
            return 0;
        }
        waits.status = VOR_JOB_ACCEPTED;
        vor_job_mirror(job, &waits, 0);
        vor_job_unask(job); /* who lost the lease was told to end */
    }
    pthread_mutex_lock(&service->mutex);
    vor_capacity_run(service, row);
    runner->job = job;
    runner->attempt = row->attempt;
    pthread_mutex_unlock(&service->mutex);
    return 1;
}

/* accepted -> running of the next job, which the runner then has; false when there is none, or it
 * may not run yet. Tries again where the store or memory fails. */
static int claim_next(struct vor_runner *runner, struct vor_job_view *row)
{
    struct vor_job_service *service = runner->service;
    struct vor_claim claim;
    struct vor_error err;

    do {
        vor_status status = VOR_OK;
        int found = 0, taken;

        pthread_mutex_lock(&service->claim);
        if (vor_capacity_claim(service, &claim))
            status = vor_store_claim_next(service->config.store, &claim, row, &found, &err);
        taken = found && take_job(runner, row);
        pthread_mutex_unlock(&service->claim);
        if (status == VOR_OK && found == taken)
            return taken;
        if (found) { /* it is to wait again */
            struct vor_hand_back back = {.lease = {service->owner.text, row->attempt},
                                         .now_ms = row->updated};

            vor_log(VOR_LOG_WARN, "a job cannot begin here yet; it keeps waiting", VOR_OF_JOB(row));
            while (!vor_job_service_hand_back(service, &row->id, &back) &&
                   !vor_job_service_pause(service, again_seconds))
                continue; /* the next start finds it otherwise */
        } else {
            atomic_store(&service->may_be_unheard, 1);
            vor_log(VOR_LOG_ERROR, "no job can be claimed", VOR_TEXT("error", err.message));
        }
    } while (!vor_job_service_pause(service, again_seconds));
    return 0;
}

static void *runner_main(void *arg)
{
    struct vor_runner *runner = arg;
    struct vor_job_service *service = runner->service;
    struct vor_job_view row;
    unsigned heard = 0;
    int draining = 0;

    while (!draining) {
        while (claim_next(runner, &row)) {
            struct vor_job *job = runner->job;

            vor_job_service_run(runner, &row);
            pthread_mutex_lock(&service->mutex);
            runner->job = NULL;
            vor_capacity_leave(service, &row);
            pthread_mutex_unlock(&service->mutex);
            vor_job_release(job);
        }
        pthread_mutex_lock(&service->mutex);
        while (!service->draining && heard == service->news)
            pthread_cond_wait(&service->ready, &service->mutex);
        heard = service->news;
        draining = service->draining;
        pthread_mutex_unlock(&service->mutex);
    }
    return NULL;
}

static int listens(const struct vor_job_service *service)
{
    return service->config.listen != NULL && service->config.listen[0] != '\0';
}

/* Where others take the jobs of one that is late: whatever the sweeper waits for. */
static void *keeper_main(void *arg)
{
    do {
        vor_job_service_renew(arg);
        vor_job_service_store_late(arg);
    } while (!vor_job_service_pause(arg, listens(arg) ? told_seconds : late_seconds));
    return NULL;
}

static void hear(void *ctx)
{
    struct vor_job_service *service = ctx;

    pthread_mutex_lock(&service->mutex);
    service->has_news = 1;
    pthread_cond_broadcast(&service->changed);
    pthread_mutex_unlock(&service->mutex);
}

/* Starts one that the process needs. */
static vor_status start_thread(pthread_t *out, const char *name, void *(*run)(void *), void *of,
                               const char *what, struct vor_error *err)
{
    if (vor_machine_thread(out, name, run, of) == 0)
        return VOR_OK;
    return vor_fail(err, VOR_E_NOMEM,
                    "cannot start the thread that %s: too little memory, or a limit on the number "
                    "of processes",
                    what);
}

static vor_status start_threads(struct vor_job_service *service, struct vor_error *err)
{
    vor_status status = VOR_OK;

    while (status == VOR_OK && service->runner_count < service->config.jobs) {
        struct vor_runner *runner = &service->runners[service->runner_count];

        runner->service = service;
        status =
            start_thread(&runner->thread, "vor-runner", runner_main, runner, "runs a job", err);
        pthread_mutex_lock(&service->mutex);
        service->runner_count += status == VOR_OK; /* which those before it read */
        pthread_mutex_unlock(&service->mutex);
    }
    if (status == VOR_OK && vor_store_is_shared(service->config.store)) {
        status = start_thread(&service->keeper, "vor-keeper", keeper_main, service, "renews leases",
                              err);
        service->keeper_started = status == VOR_OK;
    }
    VOR_THEN(status, start_thread(&service->sweeper, "vor-sweeper", vor_job_service_sweep_on,
                                  service, "deletes expired jobs", err));
    service->sweeper_started = status == VOR_OK;
    return status;
}

vor_status vor_job_service_create(struct vor_job_service **out,
                                  const struct vor_job_service_config *config,
                                  struct vor_error *err)
{
    struct vor_job_service *service = calloc(1, sizeof *service);
    vor_status status;

    assert(config->jobs <= VOR_RUNNING_JOBS_MAX && config->queue >= 1);
    if (service == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the job service");
    service->config = *config;
    pthread_mutex_init(&service->claim, NULL);
    pthread_mutex_init(&service->mutex, NULL);
    pthread_cond_init(&service->ready, NULL);
    vor_clock_condition(&service->changed);
    if (config->budget == 0)
        service->config.budget = UINT64_MAX;
    status = vor_uuid_make(&service->owner, err);
    VOR_THEN(status, vor_job_service_recover(service, err));
    if (status == VOR_OK)
        vor_job_service_renew(service); /* before any job is claimed */
    VOR_THEN(status, vor_thread_pool_create(&service->pool, POOL_THREADS, SIZE_MAX, err));
    VOR_THEN(status, vor_thread_pool_create(&service->readers, POOL_THREADS, SIZE_MAX, err));
    if (status == VOR_OK && listens(service))
        status =
            vor_store_listen(service->config.store, service->config.listen, hear, service, err);
    VOR_THEN(status, start_threads(service, err));
    if (status != VOR_OK) {
        vor_job_service_destroy(service);
        return status;
    }
    *out = service;
    return VOR_OK;
}

void vor_job_service_drain(struct vor_job_service *service, double seconds)
{
    double deadline = vor_clock_seconds() + seconds;

    pthread_mutex_lock(&service->claim); /* nobody is between a look at `draining` and his run */
    pthread_mutex_lock(&service->mutex);
    service->draining = 1;
    pthread_mutex_unlock(&service->claim);
    pthread_cond_broadcast(&service->changed);
    pthread_cond_broadcast(&service->ready);
    while (service->capacity.running > 0 &&
           !vor_clock_wait(&service->changed, &service->mutex, deadline))
        continue;
    service->aborting = 1;
    for (unsigned i = 0; i < service->runner_count; i++)
        if (service->runners[i].job != NULL)
            vor_job_ask(service->runners[i].job, VOR_CANCEL);
    while (service->capacity.running > 0)
        pthread_cond_wait(&service->changed, &service->mutex);
    pthread_mutex_unlock(&service->mutex);
}

void vor_job_service_destroy(struct vor_job_service *service)
{
    if (service == NULL)
        return;
    vor_job_service_drain(service, 0);
    vor_store_unlisten(service->config.store);
    vor_thread_pool_destroy(service->readers);
    vor_thread_pool_destroy(service->pool);
    for (unsigned i = 0; i < service->runner_count; i++)
        pthread_join(service->runners[i].thread, NULL);
    if (service->keeper_started)
        pthread_join(service->keeper, NULL);
    if (service->sweeper_started)
        pthread_join(service->sweeper, NULL);
    vor_found_free(&service->found);
    vor_job_service_forget_all(service);
    pthread_cond_destroy(&service->ready);
    pthread_mutex_destroy(&service->claim);
    pthread_cond_destroy(&service->changed);
    pthread_mutex_destroy(&service->mutex);
    free(service);
}
