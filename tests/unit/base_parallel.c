/* The pool: every row exactly once, loops side by side, and an end when the watch says so. */
#include "tests/support/vt.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static const unsigned threads_of[] = {1, 2, 3, 8};

enum { COUNTS = 4 };

struct rows {
    size_t n, block;
    unsigned threads;
    unsigned char *seen;
    atomic_uint bad;
    atomic_size_t done;
};

static void mark(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct rows *rows = ctx;

    if (begin >= end || end > rows->n || begin % rows->block != 0 || end - begin > rows->block ||
        (end - begin < rows->block && end != rows->n) || worker >= rows->threads)
        atomic_fetch_add(&rows->bad, 1);
    for (size_t i = begin; i < end; i++)
        rows->seen[i]++;
    atomic_fetch_add(&rows->done, end - begin);
}

static void rows_init(struct rows *rows, size_t n, size_t block, unsigned threads)
{
    memset(rows, 0, sizeof *rows);
    rows->n = n;
    rows->block = block;
    rows->threads = threads;
    rows->seen = calloc(n + 1, 1);
}

static int rows_once(const struct rows *rows)
{
    for (size_t i = 0; i < rows->n; i++)
        if (rows->seen[i] != 1)
            return 0;
    return 1;
}

static struct vor_pool *pool_of(unsigned threads)
{
    struct vor_pool *pool = NULL;

    vt_assert_ok(vor_pool_create(&pool, threads, &vt_err));
    ck_assert_uint_eq(vor_pool_threads(pool), threads);
    return pool;
}

/* Property. */
VT_TEST_LOOP(every_row_runs_exactly_once_in_whole_blocks, COUNTS)
{
    static const size_t sizes[] = {0, 1, 2, 63, 64, 65, 1000, 4096, 10007};
    static const size_t blocks[] = {1, 7, 64, 20000};
    struct vor_pool *pool = pool_of(threads_of[_i]);

    for (int s = 0; s < 9; s++)
        for (int b = 0; b < 4; b++) {
            struct rows rows;

            rows_init(&rows, sizes[s], blocks[b], threads_of[_i]);
            ck_assert_int_eq(vor_parallel_for(pool, NULL, rows.n, rows.block, mark, &rows),
                             VOR_CONTINUE);
            ck_assert_uint_eq(atomic_load(&rows.bad), 0);
            ck_assert(rows_once(&rows));
            free(rows.seen);
        }
    vor_pool_destroy(pool);
}

/* Scratch space for each worker number, which only one block uses at a time, on any thread. */
struct scratch {
    struct vor_pool *pool;
    atomic_int busy[VOR_THREADS_MAX];
    atomic_uint clashes;
};

static void use_scratch(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct scratch *scratch = ctx;

    if (atomic_fetch_add(&scratch->busy[worker], 1) != 0)
        atomic_fetch_add(&scratch->clashes, 1);
    for (volatile size_t i = begin; i < end + 200;)
        i = i + 1;
    atomic_fetch_sub(&scratch->busy[worker], 1);
}

static void *use_all(void *ctx)
{
    struct scratch *scratch = ctx;

    for (size_t n = 1; n < 3000; n *= 3)
        if (vor_parallel_for(scratch->pool, NULL, n, 3, use_scratch, scratch) != VOR_CONTINUE)
            atomic_fetch_add(&scratch->clashes, 1);
    return NULL;
}

VT_TEST_LOOP(a_worker_s_scratch_space_is_its_own, COUNTS)
{
    struct scratch scratch;
    pthread_t other[2];

    memset(&scratch, 0, sizeof scratch);
    scratch.pool = pool_of(threads_of[_i]);
    for (int i = 0; i < 2; i++)
        ck_assert_int_eq(pthread_create(&other[i], NULL, use_all, &scratch), 0);
    use_all(&scratch);
    for (int i = 0; i < 2; i++)
        pthread_join(other[i], NULL);
    ck_assert_uint_eq(atomic_load(&scratch.clashes), 0);
    vor_pool_destroy(scratch.pool);
}

enum { CALLERS = 6, LOOPS = 25 };

struct caller {
    struct vor_pool *pool;
    unsigned index;
    int good;
};

static void *call_loops(void *ctx)
{
    struct caller *caller = ctx;

    caller->good = 1;
    for (size_t i = 0; i < LOOPS; i++) {
        struct rows rows;

        rows_init(&rows, 1 + (caller->index * 311 + i * 97) % 3000, 1 + (i * 13) % 100,
                  vor_pool_threads(caller->pool));
        if (rows.seen == NULL ||
            vor_parallel_for(caller->pool, NULL, rows.n, rows.block, mark, &rows) != VOR_CONTINUE)
            caller->good = 0;
        caller->good &= rows_once(&rows) && atomic_load(&rows.bad) == 0;
        free(rows.seen);
    }
    return NULL;
}

VT_TEST_LOOP(loops_of_several_callers_all_finish, COUNTS)
{
    struct vor_pool *pool = pool_of(threads_of[_i]);
    struct caller callers[CALLERS];
    pthread_t threads[CALLERS];

    for (unsigned i = 0; i < CALLERS; i++) {
        callers[i] = (struct caller){pool, i, 0};
        ck_assert_int_eq(pthread_create(&threads[i], NULL, call_loops, &callers[i]), 0);
    }
    for (unsigned i = 0; i < CALLERS; i++) {
        pthread_join(threads[i], NULL);
        ck_assert(callers[i].good);
    }
    vor_pool_destroy(pool);
}

/* A long loop on the pool's only thread must not keep a short one waiting for its end. It would run
 * for half a minute; the short one's end stops it. */
enum { LONG = 2000000 };

struct turn {
    atomic_size_t done;
    atomic_int started, short_ended;
    struct vor_pool *pool;
    enum vor_answer answer;
};

static void long_task(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct turn *turn = ctx;

    (void)worker;
    atomic_store(&turn->started, 1);
    for (volatile int i = 0; i < 10000;)
        i = i + 1;
    atomic_fetch_add(&turn->done, end - begin);
}

static enum vor_answer until_short_ended(void *ctx)
{
    struct turn *turn = ctx;

    return atomic_load(&turn->short_ended) ? VOR_STOP : VOR_CONTINUE;
}

static void *long_loop(void *ctx)
{
    struct turn *turn = ctx;
    struct vor_watch watch = {.ctx = turn, .poll = until_short_ended};

    turn->answer = vor_parallel_for(turn->pool, &watch, LONG, 1, long_task, turn);
    return NULL;
}

VT_TEST(loops_that_run_together_take_turns)
{
    struct turn turn = {.pool = pool_of(1)};
    struct rows rows;
    pthread_t thread;

    rows_init(&rows, 10, 1, 1);
    ck_assert_int_eq(pthread_create(&thread, NULL, long_loop, &turn), 0);
    while (!atomic_load(&turn.started))
        sched_yield();
    ck_assert_int_eq(vor_parallel_for(turn.pool, NULL, 10, 1, mark, &rows), VOR_CONTINUE);
    atomic_store(&turn.short_ended, 1);
    pthread_join(thread, NULL);
    ck_assert_int_eq(turn.answer, VOR_STOP);
    ck_assert_uint_lt(atomic_load(&turn.done), LONG);
    ck_assert(rows_once(&rows));
    free(rows.seen);
    vor_pool_destroy(turn.pool);
}

/* A watch that lets `grace` blocks begin and then gives its answer for good. */
struct brake {
    atomic_int polls;
    int grace;
    enum vor_answer answer;
};

static enum vor_answer brake_poll(void *ctx)
{
    struct brake *brake = ctx;

    return atomic_fetch_add(&brake->polls, 1) < brake->grace ? VOR_CONTINUE : brake->answer;
}

VT_TEST_LOOP(no_block_begins_after_the_watch_says_so, COUNTS)
{
    static const enum vor_answer answers[] = {VOR_STOP, VOR_CANCEL};

    for (int a = 0; a < 2; a++)
        for (int grace = 0; grace < 40; grace += 13) {
            struct vor_pool *pool = pool_of(threads_of[_i]);
            struct brake brake = {.grace = grace, .answer = answers[a]};
            struct vor_watch watch = {.ctx = &brake, .poll = brake_poll};
            struct rows rows;

            rows_init(&rows, 5000, 10, threads_of[_i]);
            ck_assert_int_eq(vor_parallel_for(pool, &watch, rows.n, rows.block, mark, &rows),
                             answers[a]);
            ck_assert_uint_eq(atomic_load(&rows.done), (size_t)grace * 10);
            ck_assert_uint_eq(atomic_load(&rows.bad), 0);
            free(rows.seen);
            vor_pool_destroy(pool);
        }
}

VT_TEST_LOOP(a_watch_that_lets_go_on_changes_nothing, COUNTS)
{
    struct vor_pool *pool = pool_of(threads_of[_i]);
    struct brake brake = {.grace = INT32_MAX};
    struct vor_watch watch = {.ctx = &brake, .poll = brake_poll}, silent = {.ctx = NULL};
    struct rows rows;

    rows_init(&rows, 1000, 10, threads_of[_i]);
    ck_assert_int_eq(vor_parallel_for(pool, &watch, 1000, 10, mark, &rows), VOR_CONTINUE);
    ck_assert(rows_once(&rows));
    ck_assert_int_eq(atomic_load(&brake.polls), 100);
    ck_assert_int_eq(vor_parallel_for(pool, &silent, 1000, 10, mark, &rows), VOR_CONTINUE);
    ck_assert_int_eq(vor_parallel_for(pool, &watch, 0, 10, mark, &rows), VOR_CONTINUE);
    free(rows.seen);
    vor_pool_destroy(pool);
}

VT_TEST(a_pool_has_1_to_256_threads)
{
    struct vor_pool *pool = NULL;

    vt_assert_fails(VOR_E_PARAM, vor_pool_create(&pool, 0, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "threads");
    vt_assert_fails(VOR_E_PARAM, vor_pool_create(&pool, VOR_THREADS_MAX + 1, &vt_err));
    ck_assert_ptr_null(pool);
    vor_pool_destroy(NULL);
    vor_pool_destroy(pool_of(1));
    vor_pool_destroy(pool_of(VOR_THREADS_MAX));
}
