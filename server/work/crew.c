#include "server/work/crew.h"

#include "server/base/clock.h"

#include <assert.h>
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <time.h>

struct vor_crew {
    pthread_mutex_t mutex;
    pthread_cond_t ready;          /* a task waits, or the crew closes */
    pthread_cond_t idle;           /* nothing waits or runs; on the monotonic clock */
    struct vor_task *head, **tail; /* wait, in order */
    size_t waiting, waiting_max, running;
    int closing;
    unsigned started;
    pthread_t thread[];
};

/* The next task, which then counts as running; NULL once there is none and none will come. */
static struct vor_task *next_task(struct vor_crew *crew)
{
    struct vor_task *task;

    pthread_mutex_lock(&crew->mutex);
    while (crew->head == NULL && !crew->closing)
        pthread_cond_wait(&crew->ready, &crew->mutex);
    task = crew->head;
    if (task != NULL) {
        crew->head = task->next;
        if (crew->head == NULL)
            crew->tail = &crew->head;
        crew->waiting--;
        crew->running++;
    }
    pthread_mutex_unlock(&crew->mutex);
    return task;
}

static void end_task(struct vor_crew *crew)
{
    pthread_mutex_lock(&crew->mutex);
    if (--crew->running == 0 && crew->waiting == 0)
        pthread_cond_broadcast(&crew->idle);
    pthread_mutex_unlock(&crew->mutex);
}

static void *crew_main(void *arg)
{
    struct vor_crew *crew = arg;
    struct vor_task *task;

    while ((task = next_task(crew)) != NULL) {
        task->run(task->ctx);
        end_task(crew);
    }
    return NULL;
}

static void init_locks(struct vor_crew *crew)
{
    pthread_condattr_t monotonic;

    pthread_mutex_init(&crew->mutex, NULL);
    pthread_cond_init(&crew->ready, NULL);
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&crew->idle, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

vor_status vor_crew_create(struct vor_crew **out, unsigned threads, size_t waiting_max,
                           struct vor_error *err)
{
    struct vor_crew *crew = calloc(1, sizeof *crew + threads * sizeof crew->thread[0]);

    assert(threads >= 1 && waiting_max >= 1);
    if (crew == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a crew of %u threads", threads);
    crew->tail = &crew->head;
    crew->waiting_max = waiting_max;
    init_locks(crew);
    for (; crew->started < threads; crew->started++) {
        if (pthread_create(&crew->thread[crew->started], NULL, crew_main, crew) == 0)
            continue;
        vor_crew_destroy(crew);
        return vor_fail(err, VOR_E_NOMEM, "cannot start a crew of %u threads", threads);
    }
    *out = crew;
    return VOR_OK;
}

void vor_crew_destroy(struct vor_crew *crew)
{
    if (crew == NULL)
        return;
    pthread_mutex_lock(&crew->mutex);
    crew->closing = 1;
    pthread_cond_broadcast(&crew->ready);
    pthread_mutex_unlock(&crew->mutex);
    for (unsigned i = 0; i < crew->started; i++)
        pthread_join(crew->thread[i], NULL);
    pthread_cond_destroy(&crew->idle);
    pthread_cond_destroy(&crew->ready);
    pthread_mutex_destroy(&crew->mutex);
    free(crew);
}

enum vor_job_outcome vor_crew_take(struct vor_crew *crew, struct vor_task *task)
{
    enum vor_job_outcome outcome = VOR_DONE;

    pthread_mutex_lock(&crew->mutex);
    if (crew->closing) {
        outcome = VOR_DRAINING;
    } else if (crew->waiting >= crew->waiting_max) {
        outcome = VOR_FULL;
    } else {
        task->next = NULL;
        *crew->tail = task;
        crew->tail = &task->next;
        crew->waiting++;
        pthread_cond_signal(&crew->ready);
    }
    pthread_mutex_unlock(&crew->mutex);
    return outcome;
}

int vor_crew_closing(struct vor_crew *crew)
{
    int closing;

    pthread_mutex_lock(&crew->mutex);
    closing = crew->closing;
    pthread_mutex_unlock(&crew->mutex);
    return closing;
}

void vor_crew_settle(struct vor_crew *crew, double seconds)
{
    double deadline = vor_clock_seconds() + seconds;
    struct timespec at = {.tv_sec = (time_t)deadline};
    int late = 0;

    at.tv_nsec = (long)((deadline - (double)at.tv_sec) * 1e9);
    pthread_mutex_lock(&crew->mutex);
    while (!late && (crew->waiting > 0 || crew->running > 0))
        late = pthread_cond_timedwait(&crew->idle, &crew->mutex, &at) == ETIMEDOUT;
    pthread_mutex_unlock(&crew->mutex);
}
