/* The worker from its start to its end: recovery, threads, draining. */
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/work/calendar.h"
#include "server/work/live.h"
#include "server/work/recover.h"
#include "server/work/room.h"
#include "server/work/runner.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <time.h>

/* The store has one connection that writes, so a second thread only helps while the first one
 * removes files. */
enum { SWEEP_SECONDS = 60, CREW_THREADS = 2 };

static const double look_seconds = 0.5; /* between two looks at the disk: a restart takes as long */

/* A run never has more memory than its cap. A suspect need not wait where it is apart anyway. */
static struct vor_turn turn_of(const struct vor_worker *worker, const struct vor_job *job)
{
    struct vor_turn turn = *vor_job_turn(job);

    if (turn.bytes > worker->config.memory)
        turn.bytes = worker->config.memory;
    if (worker->config.executor->is_apart)
        turn.alone = 0;
    return turn;
}

/* The queue asks this before it hands out a job. */
static int may_run(void *ctx, struct vor_job *job)
{
    struct vor_worker *worker = ctx;
    const struct vor_turn turn = turn_of(worker, job);

    return vor_turns_begin(&worker->turns, &turn);
}

static void *runner_main(void *arg)
{
    struct vor_worker *worker = arg;
    struct vor_job *job;

    while ((job = vor_queue_pop(worker->queue)) != NULL) {
        const struct vor_turn turn = turn_of(worker, job);

        if (vor_worker_enter(worker, job)) {
            if (vor_worker_run(worker, job))
                vor_worker_requeue(worker, job);
            else
                vor_worker_forget(worker, job);
            vor_worker_leave(worker);
        }
        vor_turns_end(&worker->turns, &turn);
        vor_queue_look(worker->queue);
        vor_job_release(job);
    }
    return NULL;
}

static void *sweeper_main(void *arg)
{
    struct vor_worker *worker = arg;
    double swept = vor_clock_seconds() - SWEEP_SECONDS;
    struct vor_error err;

    vor_worker_drop_strays(worker);
    do {
        double now = vor_clock_seconds();

        vor_worker_recover_late(worker);
        vor_worker_look(worker);
        if (!vor_calendar_look(worker))
            continue;
        if (now - swept < SWEEP_SECONDS)
            continue;
        swept = now;
        if (vor_worker_sweep(worker, &err) != VOR_OK)
            vor_log(VOR_LOG_ERROR, "sweeping failed", VOR_TEXT("error", err.message));
    } while (!vor_worker_pause(worker, look_seconds));
    return NULL;
}

static vor_status start_threads(struct vor_worker *worker, struct vor_error *err)
{
    while (worker->runner_count < worker->config.jobs) {
        if (vor_machine_thread(&worker->runners[worker->runner_count], "vor-runner", runner_main,
                               worker) != 0)
            return vor_fail(err, VOR_E_NOMEM, "cannot start %u runners", worker->config.jobs);
        worker->runner_count++;
    }
    if (vor_machine_thread(&worker->sweeper, "vor-sweeper", sweeper_main, worker) != 0)
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
    vor_turns_init(&worker->turns, config->budget > 0 ? config->budget : UINT64_MAX);
    worker->queue = vor_queue_create(config->queue);
    if (worker->queue == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "the queue");
    else
        vor_queue_guard(worker->queue, may_run, worker);
    if (status == VOR_OK)
        status = vor_worker_recover(worker, err);
    if (status == VOR_OK)
        status = vor_crew_create(&worker->crew, CREW_THREADS, SIZE_MAX, err);
    if (status == VOR_OK)
        status = vor_crew_create(&worker->readers, CREW_THREADS, SIZE_MAX, err);
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
    while (worker->running > 0 && !vor_worker_wait_until(worker, deadline))
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
    vor_crew_destroy(worker->readers);
    vor_crew_destroy(worker->crew);
    for (unsigned i = 0; i < worker->runner_count; i++)
        pthread_join(worker->runners[i], NULL);
    if (worker->sweeper_started)
        pthread_join(worker->sweeper, NULL);
    vor_found_free(&worker->found);
    vor_queue_destroy(worker->queue);
    while (worker->live != NULL)
        vor_worker_forget(worker, worker->live->job);
    vor_turns_free(&worker->turns);
    pthread_cond_destroy(&worker->changed);
    pthread_mutex_destroy(&worker->mutex);
    free(worker);
}
