/* The worker from its start to its end: recovery, threads, draining. */
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/work/live.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>

/* The store has one connection that writes, so a second thread only helps while the first one
 * removes files. */
enum { CREW_THREADS = 2 };

static const double again_seconds = 0.5; /* after a claim that failed */

/* Between two times that a job's progress is stored, for daemons that poll and for those that are
 * told. */
static const double late_seconds = 1, told_seconds = 0.25;

/* A claimed row becomes what its runner runs; false when memory is out, or a runner here has not
 * heard yet that it lost the job: it is told. */
static int take_job(struct vor_runner *runner, const struct vor_job_view *row)
{
    struct vor_worker *worker = runner->worker;
    struct vor_job *job = vor_worker_enliven(worker, row);

    if (job == NULL)
        return 0;
    if (vor_store_is_shared(worker->config.store)) { /* its last attempt may have been elsewhere */
        struct vor_job_view waits = *row;

        if (vor_worker_is_running(worker, job)) {
            vor_job_ask(job, VOR_CANCEL);
            vor_job_release(job);
            return 0;
        }
        waits.status = VOR_JOB_ACCEPTED;
        vor_job_mirror(job, &waits, 0);
        vor_job_unask(job); /* who lost the lease was told to end */
    }
    pthread_mutex_lock(&worker->mutex);
    vor_capacity_run(worker, row);
    runner->job = job;
    runner->attempt = row->attempt;
    pthread_mutex_unlock(&worker->mutex);
    return 1;
}

/* A claimed row cannot be run, and is to wait again. */
static void untake_job(struct vor_worker *worker, const struct vor_job_view *row)
{
    struct vor_hand_back back = {.lease = {worker->owner.text, row->attempt},
                                 .now_ms = row->updated};

    vor_log(VOR_LOG_WARN, "a job cannot begin here yet; it keeps waiting", VOR_OF_JOB(row));
    while (!vor_worker_hand_back(worker, &row->id, &back) &&
           !vor_worker_pause(worker, again_seconds))
        continue; /* the next start finds it otherwise */
}

/* accepted -> running of the next job, which the runner then has; false when there is none, or it
 * may not run yet. Tries again where the store or memory fails. */
static int claim_next(struct vor_runner *runner, struct vor_job_view *row)
{
    struct vor_worker *worker = runner->worker;
    struct vor_claim claim;
    struct vor_error err;

    do {
        vor_status status = VOR_OK;
        int found = 0, taken;

        pthread_mutex_lock(&worker->claim);
        if (vor_capacity_claim(worker, &claim))
            status = vor_store_claim_next(worker->config.store, &claim, row, &found, &err);
        taken = found && take_job(runner, row);
        pthread_mutex_unlock(&worker->claim);
        if (status == VOR_OK && found == taken)
            return taken;
        if (found) {
            untake_job(worker, row);
        } else {
            atomic_store(&worker->may_be_unheard, 1);
            vor_log(VOR_LOG_ERROR, "no job can be claimed", VOR_TEXT("error", err.message));
        }
    } while (!vor_worker_pause(worker, again_seconds));
    return 0;
}

static void *runner_main(void *arg)
{
    struct vor_runner *runner = arg;
    struct vor_worker *worker = runner->worker;
    struct vor_job_view row;
    unsigned heard = 0;
    int draining = 0;

    while (!draining) {
        while (claim_next(runner, &row)) {
            struct vor_job *job = runner->job;

            vor_worker_run(runner, &row);
            pthread_mutex_lock(&worker->mutex);
            runner->job = NULL;
            vor_capacity_leave(worker, &row);
            pthread_mutex_unlock(&worker->mutex);
            vor_job_release(job);
        }
        pthread_mutex_lock(&worker->mutex);
        while (!worker->draining && heard == worker->news)
            pthread_cond_wait(&worker->ready, &worker->mutex);
        heard = worker->news;
        draining = worker->draining;
        pthread_mutex_unlock(&worker->mutex);
    }
    return NULL;
}

static int listens(const struct vor_worker *worker)
{
    return worker->config.listen != NULL && worker->config.listen[0] != '\0';
}

/* Where others take the jobs of one that is late: whatever the sweeper waits for. */
static void *keeper_main(void *arg)
{
    do {
        vor_worker_renew(arg);
        vor_worker_store_late(arg);
    } while (!vor_worker_pause(arg, listens(arg) ? told_seconds : late_seconds));
    return NULL;
}

static void hear(void *ctx)
{
    struct vor_worker *worker = ctx;

    pthread_mutex_lock(&worker->mutex);
    worker->has_news = 1;
    pthread_cond_broadcast(&worker->changed);
    pthread_mutex_unlock(&worker->mutex);
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

static vor_status start_threads(struct vor_worker *worker, struct vor_error *err)
{
    vor_status status = VOR_OK;

    while (status == VOR_OK && worker->runner_count < worker->config.jobs) {
        struct vor_runner *runner = &worker->runners[worker->runner_count];

        runner->worker = worker;
        status =
            start_thread(&runner->thread, "vor-runner", runner_main, runner, "runs a job", err);
        pthread_mutex_lock(&worker->mutex);
        worker->runner_count += status == VOR_OK; /* which those before it read */
        pthread_mutex_unlock(&worker->mutex);
    }
    if (status == VOR_OK && vor_store_is_shared(worker->config.store)) {
        status =
            start_thread(&worker->keeper, "vor-keeper", keeper_main, worker, "renews leases", err);
        worker->keeper_started = status == VOR_OK;
    }
    if (status == VOR_OK)
        status = start_thread(&worker->sweeper, "vor-sweeper", vor_worker_sweep_on, worker,
                              "deletes expired jobs", err);
    worker->sweeper_started = status == VOR_OK;
    return status;
}

vor_status vor_worker_create(struct vor_worker **out, const struct vor_worker_config *config,
                             struct vor_error *err)
{
    struct vor_worker *worker = calloc(1, sizeof *worker);
    vor_status status;

    assert(config->jobs <= VOR_WORKER_JOBS_MAX && config->queue >= 1);
    if (worker == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the worker");
    worker->config = *config;
    pthread_mutex_init(&worker->claim, NULL);
    pthread_mutex_init(&worker->mutex, NULL);
    pthread_cond_init(&worker->ready, NULL);
    vor_clock_condition(&worker->changed);
    if (config->budget == 0)
        worker->config.budget = UINT64_MAX;
    status = vor_uuid_make(&worker->owner, err);
    if (status == VOR_OK)
        status = vor_worker_recover(worker, err);
    if (status == VOR_OK)
        vor_worker_renew(worker); /* before any job is claimed */
    if (status == VOR_OK)
        status = vor_crew_create(&worker->crew, CREW_THREADS, SIZE_MAX, err);
    if (status == VOR_OK)
        status = vor_crew_create(&worker->readers, CREW_THREADS, SIZE_MAX, err);
    if (status == VOR_OK && listens(worker))
        status = vor_store_listen(worker->config.store, worker->config.listen, hear, worker, err);
    if (status == VOR_OK)
        status = start_threads(worker, err);
    if (status != VOR_OK) {
        vor_worker_destroy(worker);
        return status;
    }
    *out = worker;
    return VOR_OK;
}

void vor_worker_drain(struct vor_worker *worker, double seconds)
{
    double deadline = vor_clock_seconds() + seconds;

    pthread_mutex_lock(&worker->claim); /* nobody is between a look at `draining` and his run */
    pthread_mutex_lock(&worker->mutex);
    worker->draining = 1;
    pthread_mutex_unlock(&worker->claim);
    pthread_cond_broadcast(&worker->changed);
    pthread_cond_broadcast(&worker->ready);
    while (worker->capacity.running > 0 &&
           !vor_clock_wait(&worker->changed, &worker->mutex, deadline))
        continue;
    worker->aborting = 1;
    for (unsigned i = 0; i < worker->runner_count; i++)
        if (worker->runners[i].job != NULL)
            vor_job_ask(worker->runners[i].job, VOR_CANCEL);
    while (worker->capacity.running > 0)
        pthread_cond_wait(&worker->changed, &worker->mutex);
    pthread_mutex_unlock(&worker->mutex);
}

void vor_worker_destroy(struct vor_worker *worker)
{
    if (worker == NULL)
        return;
    vor_worker_drain(worker, 0);
    vor_store_unlisten(worker->config.store);
    vor_crew_destroy(worker->readers);
    vor_crew_destroy(worker->crew);
    for (unsigned i = 0; i < worker->runner_count; i++)
        pthread_join(worker->runners[i].thread, NULL);
    if (worker->keeper_started)
        pthread_join(worker->keeper, NULL);
    if (worker->sweeper_started)
        pthread_join(worker->sweeper, NULL);
    vor_found_free(&worker->found);
    vor_worker_forget_all(worker);
    pthread_cond_destroy(&worker->ready);
    pthread_mutex_destroy(&worker->claim);
    pthread_cond_destroy(&worker->changed);
    pthread_mutex_destroy(&worker->mutex);
    free(worker);
}
