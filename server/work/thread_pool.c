#include "server/work/thread_pool.h"

#include "server/base/clock.h"
#include "server/base/machine.h"

#include <assert.h>
#include <limits.h>
#include <pthread.h>
#include <stdlib.h>

/* A thread that finds nothing to do for so long ends: the next task starts one again, which takes
 * some 30 us. */
enum { IDLE_SECONDS = 10 };

/* What a thread is doing, and for whom. */
struct hand {
    struct vor_thread_pool *pool;
    int is_alive, is_busy;
    struct vor_fairness_key caller;
};

struct vor_thread_pool {
    pthread_mutex_t mutex;
    pthread_cond_t ready;          /* a task waits, or the pool closes */
    pthread_cond_t idle;           /* nothing waits or runs, or a thread has ended */
    struct vor_task *head, **tail; /* wait, in order */
    size_t waiting, waiting_max, running;
    size_t caller_waiting_max; /* of each caller */
    unsigned caller_running_max;
    int closing;
    unsigned count, alive, unoccupied; /* threads: at most, that run, and of these wait for tasks */
    struct hand hand[];
};

/* Takes the task that is to begin off the list; NULL when none may. Waiting tasks are few. */
static struct vor_task *pick(struct vor_thread_pool *pool)
{
    unsigned fewest = pool->closing ? UINT_MAX : pool->caller_running_max;
    struct vor_task **chosen = NULL, *task;

    for (struct vor_task **at = &pool->head; *at != NULL && fewest > 0; at = &(*at)->next) {
        unsigned running = 0; /* of its caller */

        for (unsigned i = 0; i < pool->count; i++)
            running += pool->hand[i].is_busy &&
                       vor_fairness_key_same(&pool->hand[i].caller, &(*at)->caller);

        if (running >= fewest)
            continue;
        fewest = running;
        chosen = at;
    }
    if (chosen == NULL)
        return NULL;
    /* The lightest of that caller's. */
    for (struct vor_task **at = chosen; *at != NULL; at = &(*at)->next)
        if ((*at)->weight < (*chosen)->weight &&
            vor_fairness_key_same(&(*at)->caller, &(*chosen)->caller))
            chosen = at;
    task = *chosen;
    *chosen = task->next;
    if (*chosen == NULL)
        pool->tail = chosen;
    pool->waiting--;
    return task;
}

/* The next task, which then counts as running; NULL when the thread is to end. */
static struct vor_task *next_task(struct hand *hand)
{
    double until = vor_clock_seconds() + IDLE_SECONDS;
    struct vor_thread_pool *pool = hand->pool;
    struct vor_task *task;
    int is_late = 0;

    pthread_mutex_lock(&pool->mutex);
    while ((task = pick(pool)) == NULL && !pool->closing && !is_late) {
        pool->unoccupied++;
        is_late = vor_clock_wait(&pool->ready, &pool->mutex, until);
        pool->unoccupied--;
    }
    if (task != NULL) {
        pool->running++;
        hand->is_busy = 1;
        hand->caller = task->caller;
    } else {
        hand->is_alive = 0;
        pool->alive--;
        pthread_cond_broadcast(&pool->idle);
    }
    pthread_mutex_unlock(&pool->mutex);
    return task;
}

static void *pool_main(void *arg)
{
    struct hand *hand = arg;
    struct vor_thread_pool *pool = hand->pool;
    struct vor_task *task;

    while ((task = next_task(hand)) != NULL) {
        task->run(task->ctx);
        /* Looks for the next one itself, so nobody else is woken. */
        pthread_mutex_lock(&pool->mutex);
        hand->is_busy = 0;
        if (--pool->running == 0 && pool->waiting == 0)
            pthread_cond_broadcast(&pool->idle);
        pthread_mutex_unlock(&pool->mutex);
    }
    return NULL;
}

/* Starts a thread for tasks that wait and find none unoccupied; the mutex is held. False when no
 * thread runs, so that nobody would do them. */
static int start_thread(struct vor_thread_pool *pool)
{
    struct hand *hand = pool->hand;
    pthread_t thread;

    if (pool->waiting <= pool->unoccupied || pool->alive == pool->count)
        return 1;
    while (hand->is_alive)
        hand++;
    hand->pool = pool;
    if (vor_machine_thread(&thread, "vor-pool", pool_main, hand) == 0) {
        (void)pthread_detach(thread);
        hand->is_alive = 1;
        pool->alive++;
    }
    return pool->alive > 0;
}

vor_status vor_thread_pool_create(struct vor_thread_pool **out, unsigned threads,
                                  size_t waiting_max, struct vor_error *err)
{
    struct vor_thread_pool *pool = calloc(1, sizeof *pool + threads * sizeof pool->hand[0]);

    assert(threads >= 1 && waiting_max >= 1);
    if (pool == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%u threads", threads);
    pool->tail = &pool->head;
    pool->waiting_max = pool->caller_waiting_max = waiting_max;
    pool->caller_running_max = pool->count = threads;
    pthread_mutex_init(&pool->mutex, NULL);
    vor_clock_condition(&pool->ready);
    vor_clock_condition(&pool->idle);
    *out = pool;
    return VOR_OK;
}

void vor_thread_pool_destroy(struct vor_thread_pool *pool)
{
    if (pool == NULL)
        return;
    pthread_mutex_lock(&pool->mutex);
    pool->closing = 1;
    pthread_cond_broadcast(&pool->ready);
    while (pool->alive > 0)
        pthread_cond_wait(&pool->idle, &pool->mutex);
    pthread_mutex_unlock(&pool->mutex);
    pthread_cond_destroy(&pool->idle);
    pthread_cond_destroy(&pool->ready);
    pthread_mutex_destroy(&pool->mutex);
    free(pool);
}

void vor_thread_pool_share(struct vor_thread_pool *pool, unsigned running_max, size_t waiting_max)
{
    pthread_mutex_lock(&pool->mutex);
    assert(running_max >= 1 && running_max < pool->count && waiting_max >= 1);
    pool->caller_running_max = running_max;
    pool->caller_waiting_max = waiting_max;
    pthread_mutex_unlock(&pool->mutex);
}

enum vor_job_outcome vor_thread_pool_submit(struct vor_thread_pool *pool, struct vor_task *task,
                                            struct vor_error *err)
{
    enum vor_job_outcome outcome = VOR_DONE;
    size_t before = 0; /* tasks of its caller that go before it */

    pthread_mutex_lock(&pool->mutex);
    for (const struct vor_task *at = pool->head; at != NULL; at = at->next)
        before += at->weight <= task->weight && vor_fairness_key_same(&at->caller, &task->caller);
    if (pool->closing) {
        outcome = VOR_DRAINING;
    } else if (pool->waiting >= pool->waiting_max || before >= pool->caller_waiting_max) {
        outcome = VOR_FULL;
    } else {
        struct vor_task **tail = pool->tail;

        task->next = NULL;
        *tail = task;
        pool->tail = &task->next;
        pool->waiting++;
        pthread_cond_signal(&pool->ready);
        if (!start_thread(pool)) {
            *tail = NULL;
            pool->tail = tail;
            pool->waiting--;
            outcome = VOR_FAILED;
            (void)vor_fail(err, VOR_E_IO,
                           "no thread can be started for this request; try again later");
        }
    }
    pthread_mutex_unlock(&pool->mutex);
    return outcome;
}

int vor_thread_pool_is_closing(struct vor_thread_pool *pool)
{
    int closing;

    pthread_mutex_lock(&pool->mutex);
    closing = pool->closing;
    pthread_mutex_unlock(&pool->mutex);
    return closing;
}

void vor_thread_pool_wait(struct vor_thread_pool *pool, double seconds)
{
    double until = vor_clock_seconds() + seconds;
    int late = 0;

    pthread_mutex_lock(&pool->mutex);
    while (!late && (pool->waiting > 0 || pool->running > 0))
        late = vor_clock_wait(&pool->idle, &pool->mutex, until);
    pthread_mutex_unlock(&pool->mutex);
}

/* --- who waits -------------------------------------------------------------------------------- */

struct vor_askers {
    struct vor_askers *next;
    struct vor_asker asker;
};

int vor_waiting_add(struct vor_askers **list, const struct vor_asker *asker)
{
    struct vor_askers *waiting = malloc(sizeof *waiting);

    if (waiting == NULL)
        return 0;
    *waiting = (struct vor_askers){*list, *asker};
    *list = waiting;
    return 1;
}

struct vor_askers *vor_waiting_take(struct vor_askers **list)
{
    struct vor_askers *taken = *list;

    *list = NULL;
    return taken;
}

void vor_waiting_wake(struct vor_askers *list)
{
    while (list != NULL) {
        struct vor_askers *next = list->next;

        list->asker.wake(list->asker.ctx);
        free(list);
        list = next;
    }
}
