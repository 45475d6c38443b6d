#include "core/base/parallel.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>

/* A running loop; lives on its caller's stack. All members are guarded by the pool's mutex. */
struct loop {
    vor_task task;
    void *ctx;
    const struct vor_watch *watch;
    size_t n, block, next; /* rows; first row not handed out */
    size_t busy;           /* blocks being worked on */
    enum vor_answer answer;
    struct loop *following; /* in the ring of loops with blocks left */
};

struct vor_pool {
    pthread_mutex_t mutex;
    pthread_cond_t work, done;
    struct loop *head, *tail; /* loops with blocks left, in the order of their turn */
    int closing;
    unsigned threads, started;
    unsigned seats; /* free ones */
    struct place {
        pthread_t thread;
        unsigned seat; /* the first `seats` places have the numbers of the free ones */
    } place[];
};

static void push(struct vor_pool *pool, struct loop *loop)
{
    loop->following = NULL;
    if (pool->tail != NULL)
        pool->tail->following = loop;
    else
        pool->head = loop;
    pool->tail = loop;
}

/* Takes a loop with blocks left out of the queue; none of them will start. */
static void abandon(struct vor_pool *pool, struct loop *loop)
{
    struct loop *before = NULL, *at = pool->head;

    while (at != loop) {
        before = at;
        at = at->following;
    }
    if (before != NULL)
        before->following = loop->following;
    else
        pool->head = loop->following;
    if (pool->tail == loop)
        pool->tail = before;
    loop->next = loop->n;
}

/* Works on one block of the loop whose turn it is, on a free seat; the mutex is held on entry and
 * on return. */
static void work_once(struct vor_pool *pool)
{
    struct loop *loop = pool->head;
    unsigned seat = pool->place[--pool->seats].seat;
    size_t begin = loop->next;
    size_t end = loop->n - begin > loop->block ? begin + loop->block : loop->n;
    enum vor_answer answer;

    pool->head = loop->following;
    if (pool->head == NULL)
        pool->tail = NULL;
    loop->next = end;
    loop->busy++;
    if (end < loop->n)
        push(pool, loop); /* to the end of the queue: the other loops have their turn first */
    pthread_mutex_unlock(&pool->mutex);

    answer = loop->watch != NULL && loop->watch->poll != NULL ? loop->watch->poll(loop->watch->ctx)
                                                              : VOR_CONTINUE;
    if (answer == VOR_CONTINUE)
        loop->task(loop->ctx, begin, end, seat);

    pthread_mutex_lock(&pool->mutex);
    if (answer > loop->answer)
        loop->answer = answer;
    if (loop->answer != VOR_CONTINUE && loop->next < loop->n)
        abandon(pool, loop);
    loop->busy--;
    if (loop->busy == 0 && (loop->next == loop->n))
        pthread_cond_broadcast(&pool->done);
    pool->place[pool->seats++].seat = seat;
}

/* Wakes a worker that may have found no seat, if there is one now. */
static void leave_seats(struct vor_pool *pool)
{
    if (pool->head != NULL && pool->seats > 0)
        pthread_cond_signal(&pool->work);
}

static void *worker_main(void *arg)
{
    struct vor_pool *pool = arg;

    pthread_mutex_lock(&pool->mutex);
    while (!pool->closing) {
        if (pool->head == NULL || pool->seats == 0)
            pthread_cond_wait(&pool->work, &pool->mutex);
        else
            work_once(pool);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

vor_status vor_pool_create(struct vor_pool **out, unsigned threads, struct vor_error *err)
{
    struct vor_pool *pool;

    if (threads < 1 || threads > VOR_THREADS_MAX)
        return vor_fail_param(err, VOR_E_PARAM, "threads", "threads is %u, want 1 to %d", threads,
                              VOR_THREADS_MAX);
    pool = calloc(1, sizeof *pool + threads * sizeof pool->place[0]);
    if (pool == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%u threads", threads);
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->done, NULL);
    pool->threads = pool->seats = threads;
    for (unsigned i = 0; i < threads; i++)
        pool->place[i].seat = i;
    for (; pool->started < threads; pool->started++)
        if (pthread_create(&pool->place[pool->started].thread, NULL, worker_main, pool) != 0) {
            vor_pool_destroy(pool);
            return vor_fail(err, VOR_E_NOMEM,
                            "cannot start %u threads: too little memory, or a limit on the number "
                            "of processes",
                            threads);
        }
    *out = pool;
    return VOR_OK;
}

void vor_pool_destroy(struct vor_pool *pool)
{
    if (pool == NULL)
        return;
    pthread_mutex_lock(&pool->mutex);
    assert(pool->head == NULL);
    pool->closing = 1;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->mutex);
    for (unsigned i = 0; i < pool->started; i++)
        pthread_join(pool->place[i].thread, NULL);
    pthread_cond_destroy(&pool->done);
    pthread_cond_destroy(&pool->work);
    pthread_mutex_destroy(&pool->mutex);
    free(pool);
}

unsigned vor_pool_threads(const struct vor_pool *pool)
{
    return pool->threads;
}

enum vor_answer vor_parallel_for(struct vor_pool *pool, const struct vor_watch *watch, size_t n,
                                 size_t block, vor_task task, void *ctx)
{
    struct loop loop = {.task = task, .ctx = ctx, .watch = watch, .n = n, .block = block};

    assert(block > 0);
    if (n == 0)
        return VOR_CONTINUE;
    pthread_mutex_lock(&pool->mutex);
    push(pool, &loop);
    for (size_t i = pool->seats > 0; i < vor_blocks_of(n, block) && i < pool->threads; i++)
        pthread_cond_signal(&pool->work);
    while (loop.next < n || loop.busy > 0) {
        if (loop.next < n && pool->seats > 0) {
            work_once(pool);
            continue;
        }
        leave_seats(pool);
        pthread_cond_wait(&pool->done, &pool->mutex);
    }
    leave_seats(pool);
    pthread_mutex_unlock(&pool->mutex);
    return loop.answer;
}

struct rows {
    vor_row_task task;
    void *ctx;
};

static void do_rows(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct rows *rows = ctx;

    for (size_t i = begin; i < end; i++)
        rows->task(rows->ctx, i, worker);
}

enum vor_answer vor_parallel_rows(struct vor_pool *pool, const struct vor_watch *watch, size_t n,
                                  size_t block, vor_row_task task, void *ctx)
{
    return vor_parallel_for(pool, watch, n, block, do_rows, &(struct rows){task, ctx});
}
