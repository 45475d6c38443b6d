/* The pool: every task once, in order, within its bound, and none forgotten at the end. */
#include "server/base/clock.h"
#include "server/work/thread_pool.h"
#include "tests/support/vt.h"

#include <dirent.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

enum { TASKS = 20 };

/* Tasks that note the order in which they run; the gate holds each of them until it is opened. */
struct work {
    struct vor_task tasks[TASKS];
    struct vor_thread_pool *pool;
    atomic_int held, begun;
    atomic_int released;     /* the number of a task that is not held */
    atomic_int order[TASKS]; /* numbers of tasks as they begin; -1 where none has yet */
    atomic_int closing_seen;
};

struct job {
    struct work *work;
    int number;
};

static struct job jobs[TASKS];

static void run_one(void *ctx)
{
    struct job *job = ctx;
    int at = atomic_fetch_add(&job->work->begun, 1);

    atomic_store(&job->work->order[at], job->number);
    while (atomic_load(&job->work->held) && atomic_load(&job->work->released) != job->number)
        vt_nap();
    if (vor_thread_pool_is_closing(job->work->pool))
        atomic_fetch_add(&job->work->closing_seen, 1);
}

static void begin(struct work *work, unsigned threads, size_t waiting_max, int held)
{
    *work = (struct work){.pool = NULL};
    atomic_init(&work->held, held);
    atomic_init(&work->released, -1);
    for (int i = 0; i < TASKS; i++) {
        jobs[i] = (struct job){work, i};
        work->tasks[i] = (struct vor_task){.run = run_one, .ctx = &jobs[i]};
        atomic_init(&work->order[i], -1);
    }
    vt_assert_ok(vor_thread_pool_create(&work->pool, threads, waiting_max, &vt_err));
}

/* The number of the task that begins as that one, once it does. */
static int begun_at(struct work *work, int at)
{
    while (atomic_load(&work->order[at]) < 0)
        vt_nap();
    return atomic_load(&work->order[at]);
}

VT_TEST(tasks_begin_in_the_order_in_which_they_came)
{
    struct work work;

    begin(&work, 1, TASKS, 0);
    for (int i = 0; i < TASKS; i++)
        ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[i], NULL), VOR_DONE);
    vor_thread_pool_wait(work.pool, 60);
    ck_assert_int_eq(atomic_load(&work.begun), TASKS);
    for (int i = 0; i < TASKS; i++)
        ck_assert_int_eq(begun_at(&work, i), i);
    vor_thread_pool_destroy(work.pool);
    ck_assert_int_eq(atomic_load(&work.begun), TASKS); /* each once */
}

/* ThreadSanitizer has a thread of its own from the first one on. */
#if defined(__SANITIZE_THREAD__)
enum { OF_SANITIZER = 1 };
#else
enum { OF_SANITIZER = 0 };
#endif

static int count_threads(void)
{
    DIR *folder = opendir("/proc/self/task");
    int count = -2; /* "." and ".." */

    ck_assert_ptr_nonnull(folder);
    while (readdir(folder) != NULL)
        count++;
    (void)closedir(folder);
    return count;
}

VT_TEST(no_more_tasks_wait_than_may)
{
    int threads = count_threads();
    struct work work;

    begin(&work, 2, 3, 1);
    ck_assert_int_eq(count_threads(), threads); /* they come with the tasks */
    for (int i = 0; i < 2; i++)
        ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[i], NULL), VOR_DONE);
    while (atomic_load(&work.begun) < 2) /* two run at the same time, and do not wait any more */
        vt_nap();
    ck_assert_int_eq(count_threads(), threads + 2 + OF_SANITIZER);
    for (int i = 2; i < 5; i++)
        ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[i], NULL), VOR_DONE);
    ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[5], NULL), VOR_FULL);
    atomic_store(&work.held, 0);
    vor_thread_pool_wait(work.pool, 60);
    ck_assert_int_eq(atomic_load(&work.begun), 5);
    ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[5], NULL), VOR_DONE);
    vor_thread_pool_destroy(work.pool);
    ck_assert_int_eq(atomic_load(&work.begun), 6);
}

VT_TEST(a_caller_with_many_tasks_leaves_a_thread_and_room_to_others)
{
    struct work work;

    begin(&work, 2, 8, 1);
    vor_thread_pool_share(work.pool, 1, 4);
    for (int i = 0; i < 5; i++) { /* one runs, four wait */
        (void)snprintf(work.tasks[i].caller.name, VOR_FAIRNESS_KEY_SIZE, "greedy");
        ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[i], NULL), VOR_DONE);
        while (atomic_load(&work.begun) == 0)
            vt_nap();
    }
    work.tasks[5].caller = work.tasks[0].caller;
    ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[5], NULL), VOR_FULL);
    ck_assert_int_eq(atomic_load(&work.begun), 1);
    ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[6], NULL), VOR_DONE);
    while (atomic_load(&work.begun) < 2) /* the other thread has it at once */
        vt_nap();
    ck_assert_int_eq(begun_at(&work, 1), 6);
    atomic_store(&work.held, 0);
    vor_thread_pool_destroy(work.pool);
    ck_assert_int_eq(atomic_load(&work.begun), 6);
}

/* One thread: the greedy one's first task runs; then whoever came first among those who have none.
 */
VT_TEST(a_free_thread_goes_to_the_caller_for_whom_fewest_run)
{
    struct work work;

    begin(&work, 2, TASKS, 1);
    for (int i = 0; i < 6; i++) {
        (void)snprintf(work.tasks[i].caller.name, VOR_FAIRNESS_KEY_SIZE,
                       i < 4 ? "greedy" : "caller %d", i);
        ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[i], NULL), VOR_DONE);
        while (atomic_load(&work.begun) < (i < 2 ? i + 1 : 2))
            vt_nap();
    }
    atomic_store(&work.released, 0);
    while (atomic_load(&work.begun) < 3)
        vt_nap();
    ck_assert_int_eq(begun_at(&work, 2), 4); /* before 2 and 3, which came earlier */
    atomic_store(&work.released, 4);
    while (atomic_load(&work.begun) < 4)
        vt_nap();
    ck_assert_int_eq(begun_at(&work, 3), 5);
    atomic_store(&work.held, 0);
    vor_thread_pool_destroy(work.pool);
    ck_assert_int_eq(begun_at(&work, 4) + begun_at(&work, 5), 2 + 3);
}

/* A caller's heavy tasks wait, as many as may: a light one of the same caller is taken, and is
 * next. */
VT_TEST(of_a_callers_tasks_the_lightest_begins)
{
    struct work work;

    begin(&work, 2, TASKS, 1);
    vor_thread_pool_share(work.pool, 1, 3);
    for (int i = 0; i < 5; i++) {
        work.tasks[i].weight = i < 4 ? 1000 : 10;
        ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[i], NULL), VOR_DONE);
        while (atomic_load(&work.begun) == 0)
            vt_nap();
    }
    work.tasks[5].weight = 1000;
    ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[5], NULL), VOR_FULL);
    atomic_store(&work.held, 0);
    vor_thread_pool_destroy(work.pool);
    ck_assert_int_eq(atomic_load(&work.begun), 5);
    ck_assert_int_eq(begun_at(&work, 0), 0);
    ck_assert_int_eq(begun_at(&work, 1), 4);
}

VT_TEST(callers_are_told_apart_by_address_and_of_ipv6_by_network)
{
    static const struct {
        const char *a, *b;
        bool same;
    } pairs[] = {
        {"192.0.2.1", "192.0.2.1", true},
        {"192.0.2.1", "192.0.2.2", false},
        {"192.0.2.1", "::ffff:192.0.2.1", true},
        {"2001:db8::1", "2001:db8::ffff:1", true},
        {"2001:db8::1", "2001:db8:0:1::1", false},
        {"2001:db8::1", "192.0.2.1", false},
        {"", "nonsense", true},
        {"", "192.0.2.1", false},
    };

    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        struct vor_fairness_key a = vor_fairness_key_of_address(pairs[i].a),
                                b = vor_fairness_key_of_address(pairs[i].b);

        ck_assert_msg(vor_fairness_key_same(&a, &b) == pairs[i].same, "%s and %s", a.name, b.name);
    }
}

VT_TEST(a_key_shares_with_itself_alone_and_with_no_address)
{
    struct vor_fairness_key key = vor_fairness_key_of_key("192.0.2.1"),
                            other = vor_fairness_key_of_key("render"),
                            address = vor_fairness_key_of_address("192.0.2.1");

    ck_assert(vor_fairness_key_same(&key, &key));
    ck_assert(!vor_fairness_key_same(&key, &other));
    ck_assert(!vor_fairness_key_same(&key, &address));
}

static void *destroy(void *pool)
{
    vor_thread_pool_destroy(pool);
    return NULL;
}

VT_TEST(what_waits_at_the_end_is_done_and_nothing_more_is_taken)
{
    enum vor_job_outcome outcome;
    struct work work;
    pthread_t thread;

    begin(&work, 1, 4, 1);
    for (int i = 0; i < 4; i++)
        ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[i], NULL), VOR_DONE);
    while (atomic_load(&work.begun) == 0)
        vt_nap();
    ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[4], NULL),
                     VOR_DONE); /* now four wait */
    ck_assert_int_eq(pthread_create(&thread, NULL, destroy, work.pool), 0);
    while ((outcome = vor_thread_pool_submit(work.pool, &work.tasks[5], NULL)) == VOR_FULL)
        vt_nap();
    ck_assert_int_eq(outcome, VOR_DRAINING);
    atomic_store(&work.held, 0);
    pthread_join(thread, NULL);
    ck_assert_int_eq(atomic_load(&work.begun), 5);
    ck_assert_int_eq(atomic_load(&work.closing_seen), 5);
}

VT_TEST(settling_gives_up_after_its_time)
{
    struct work work;
    double began;

    begin(&work, 1, 4, 1);
    vor_thread_pool_wait(work.pool, 60); /* nothing to wait for */
    ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[0], NULL), VOR_DONE);
    began = vor_clock_seconds();
    vor_thread_pool_wait(work.pool, 0.05);
    ck_assert_double_ge(vor_clock_seconds() - began, 0.05);
    atomic_store(&work.held, 0);
    vor_thread_pool_destroy(work.pool);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) /* which need room too */
VT_TEST(a_task_that_gets_no_thread_is_refused_for_that_and_not_as_one_too_many)
{
    struct rlimit limit, tight;
    struct work work;

    begin(&work, 1, 4, 0);
    ck_assert_int_eq(getrlimit(RLIMIT_AS, &limit), 0);
    tight = (struct rlimit){.rlim_cur = 1, .rlim_max = limit.rlim_max};
    ck_assert_int_eq(setrlimit(RLIMIT_AS, &tight), 0); /* no stack for a thread */
    ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[0], &vt_err), VOR_FAILED);
    ck_assert_int_eq(setrlimit(RLIMIT_AS, &limit), 0);
    ck_assert_int_eq(vt_err.status, VOR_E_IO);
    ck_assert_ptr_nonnull(strstr(vt_err.message, "no thread can be started"));
    ck_assert_int_eq(vor_thread_pool_submit(work.pool, &work.tasks[1], &vt_err), VOR_DONE);
    vor_thread_pool_destroy(work.pool);
    ck_assert_int_eq(begun_at(&work, 0), 1);
}
#endif
