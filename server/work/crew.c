#include "server/work/crew.h"

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
    struct vor_crew *crew;
    int is_alive, is_busy;
    struct vor_fairness_key caller;
};

struct vor_crew {
    pthread_mutex_t mutex;
    pthread_cond_t ready;          /* a task waits, or the crew closes */
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
static struct vor_task *pick(struct vor_crew *crew)
{
    unsigned fewest = crew->closing ? UINT_MAX : crew->caller_running_max;
    struct vor_task **chosen = NULL, *task;

    for (struct vor_task **at = &crew->head; *at != NULL && fewest > 0; at = &(*at)->next) {
        unsigned running = 0; /* of its caller */

        for (unsigned i = 0; i < crew->count; i++)
            running += crew->hand[i].is_busy &&
                       vor_fairness_key_same(&crew->hand[i].caller, &(*at)->caller);

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
        crew->tail = chosen;
    crew->waiting--;
    return task;
}

/* The next task, which then counts as running; NULL when the thread is to end. */
static struct vor_task *next_task(struct hand *hand)
{
    double until = vor_clock_seconds() + IDLE_SECONDS;
    struct vor_crew *crew = hand->crew;
    struct vor_task *task;
    int is_late = 0;

    pthread_mutex_lock(&crew->mutex);
    while ((task = pick(crew)) == NULL && !crew->closing && !is_late) {
        crew->unoccupied++;
        is_late = vor_clock_wait(&crew->ready, &crew->mutex, until);
        crew->unoccupied--;
    }
    if (task != NULL) {
        crew->running++;
        hand->is_busy = 1;
        hand->caller = task->caller;
    } else {
        hand->is_alive = 0;
        crew->alive--;
        pthread_cond_broadcast(&crew->idle);
    }
    pthread_mutex_unlock(&crew->mutex);
    return task;
}

static void *crew_main(void *arg)
{
    struct hand *hand = arg;
    struct vor_crew *crew = hand->crew;
    struct vor_task *task;

    while ((task = next_task(hand)) != NULL) {
        task->run(task->ctx);
        /* Looks for the next one itself, so nobody else is woken. */
        pthread_mutex_lock(&crew->mutex);
        hand->is_busy = 0;
        if (--crew->running == 0 && crew->waiting == 0)
            pthread_cond_broadcast(&crew->idle);
        pthread_mutex_unlock(&crew->mutex);
    }
    return NULL;
}

/* Starts a thread for tasks that wait and find none unoccupied; the mutex is held. False when no
 * thread runs, so that nobody would do them. */
static int start_thread(struct vor_crew *crew)
{
    struct hand *hand = crew->hand;
    pthread_t thread;

    if (crew->waiting <= crew->unoccupied || crew->alive == crew->count)
        return 1;
    while (hand->is_alive)
        hand++;
    hand->crew = crew;
    if (vor_machine_thread(&thread, "vor-pool", crew_main, hand) == 0) {
        (void)pthread_detach(thread);
        hand->is_alive = 1;
        crew->alive++;
    }
    return crew->alive > 0;
}

vor_status vor_crew_create(struct vor_crew **out, unsigned threads, size_t waiting_max,
                           struct vor_error *err)
{
    struct vor_crew *crew = calloc(1, sizeof *crew + threads * sizeof crew->hand[0]);

    assert(threads >= 1 && waiting_max >= 1);
    if (crew == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%u threads", threads);
    crew->tail = &crew->head;
    crew->waiting_max = crew->caller_waiting_max = waiting_max;
    crew->caller_running_max = crew->count = threads;
    pthread_mutex_init(&crew->mutex, NULL);
    vor_clock_condition(&crew->ready);
    vor_clock_condition(&crew->idle);
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
    while (crew->alive > 0)
        pthread_cond_wait(&crew->idle, &crew->mutex);
    pthread_mutex_unlock(&crew->mutex);
    pthread_cond_destroy(&crew->idle);
    pthread_cond_destroy(&crew->ready);
    pthread_mutex_destroy(&crew->mutex);
    free(crew);
}

void vor_crew_share(struct vor_crew *crew, unsigned running_max, size_t waiting_max)
{
    pthread_mutex_lock(&crew->mutex);
    assert(running_max >= 1 && running_max < crew->count && waiting_max >= 1);
    crew->caller_running_max = running_max;
    crew->caller_waiting_max = waiting_max;
    pthread_mutex_unlock(&crew->mutex);
}

/* How many tasks of its caller go before one that comes. */
static size_t before(const struct vor_crew *crew, const struct vor_task *task)
{
    size_t count = 0;

    for (const struct vor_task *at = crew->head; at != NULL; at = at->next)
        count += at->weight <= task->weight && vor_fairness_key_same(&at->caller, &task->caller);
    return count;
}

enum vor_job_outcome vor_crew_take(struct vor_crew *crew, struct vor_task *task,
                                   struct vor_error *err)
{
    enum vor_job_outcome outcome = VOR_DONE;

    pthread_mutex_lock(&crew->mutex);
    if (crew->closing) {
        outcome = VOR_DRAINING;
    } else if (crew->waiting >= crew->waiting_max ||
               before(crew, task) >= crew->caller_waiting_max) {
        outcome = VOR_FULL;
    } else {
        struct vor_task **tail = crew->tail;

        task->next = NULL;
        *tail = task;
        crew->tail = &task->next;
        crew->waiting++;
        pthread_cond_signal(&crew->ready);
        if (!start_thread(crew)) {
            *tail = NULL;
            crew->tail = tail;
            crew->waiting--;
            outcome = VOR_FAILED;
            (void)vor_fail(err, VOR_E_IO,
                           "no thread can be started for this request; try again later");
        }
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
    double until = vor_clock_seconds() + seconds;
    int late = 0;

    pthread_mutex_lock(&crew->mutex);
    while (!late && (crew->waiting > 0 || crew->running > 0))
        late = vor_clock_wait(&crew->idle, &crew->mutex, until);
    pthread_mutex_unlock(&crew->mutex);
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
