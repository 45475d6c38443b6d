/* Who runs beside whom: by memory, and alone where that is asked for. */
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/jobs/queue.h"
#include "server/jobs/turns.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

static const struct vor_turn alone = {.bytes = 1, .alone = 1};

static struct vor_turn of(uint64_t bytes)
{
    return (struct vor_turn){.bytes = bytes};
}

START_TEST(turns_that_fit_together_run_together)
{
    struct vor_turns turns;
    const struct vor_turn first = of(60), second = of(40), third = of(1);

    vor_turns_init(&turns, 100);
    ck_assert(vor_turns_begin(&turns, &first));
    ck_assert(vor_turns_begin(&turns, &second));
    ck_assert(!vor_turns_begin(&turns, &third));
    ck_assert_uint_eq(vor_turns_used(&turns), 100);
    vor_turns_end(&turns, &second);
    ck_assert(vor_turns_begin(&turns, &third));
    ck_assert_uint_eq(vor_turns_used(&turns), 61);
    vor_turns_free(&turns);
}
END_TEST

START_TEST(a_turn_larger_than_everything_runs_once_nothing_else_does)
{
    struct vor_turns turns;
    const struct vor_turn small = of(1), huge = of(UINT64_MAX);

    vor_turns_init(&turns, 100);
    ck_assert(vor_turns_begin(&turns, &small));
    ck_assert(!vor_turns_begin(&turns, &huge));
    vor_turns_end(&turns, &small);
    ck_assert(vor_turns_begin(&turns, &huge));
    ck_assert(!vor_turns_begin(&turns, &small));
    vor_turns_end(&turns, &huge);
    ck_assert_uint_eq(vor_turns_used(&turns), 0);
    ck_assert(vor_turns_begin(&turns, &small));
    vor_turns_free(&turns);
}
END_TEST

START_TEST(a_turn_alone_has_nothing_beside_it)
{
    struct vor_turns turns;
    const struct vor_turn small = of(1);

    vor_turns_init(&turns, 100);
    ck_assert(vor_turns_begin(&turns, &small));
    ck_assert(!vor_turns_begin(&turns, &alone));
    vor_turns_end(&turns, &small);
    ck_assert(vor_turns_begin(&turns, &alone));
    ck_assert(!vor_turns_begin(&turns, &small));
    ck_assert(!vor_turns_begin(&turns, &alone));
    vor_turns_end(&turns, &alone);
    ck_assert(vor_turns_begin(&turns, &small));
    vor_turns_free(&turns);
}
END_TEST

static int is_open(void *ctx, struct vor_job *job)
{
    (void)job;
    return atomic_load((atomic_int *)ctx);
}

static struct vor_job *enqueue(struct vor_queue *queue, int64_t seq)
{
    struct vor_job_view row = vt_row(10);
    struct vor_job *job = vor_job_create(&row);

    ck_assert_int_eq(vor_queue_reserve(queue), VOR_DONE);
    vor_queue_push(queue, job, seq);
    vor_job_release(job);
    return job;
}

static void *pop(void *queue)
{
    return vor_queue_pop(queue);
}

START_TEST(a_guarded_queue_hands_out_its_first_job_once_the_guard_allows_it)
{
    struct vor_queue *queue = vor_queue_create(4);
    const struct timespec pause = {.tv_nsec = 5000000};
    atomic_int open = 0;
    struct vor_job *first;
    pthread_t thread;
    void *out;

    vor_queue_guard(queue, is_open, &open);
    first = enqueue(queue, 1);
    (void)enqueue(queue, 2);
    pthread_create(&thread, NULL, pop, queue);
    nanosleep(&pause, NULL);
    ck_assert_uint_eq(vor_queue_depth(queue), 2);
    atomic_store(&open, 1);
    vor_queue_look(queue);
    pthread_join(thread, &out);
    ck_assert_ptr_eq(out, first);
    vor_job_release(out);
    vor_queue_destroy(queue);
}
END_TEST

static struct vor_uuid submit(struct vt_daemon *daemon, int iterations)
{
    struct vor_spec spec = vt_request(200, iterations);

    return vt_daemon_submit_sphere(daemon, 1500, &spec);
}

/* Marks a waiting job as one that was running when the daemon ended. */
static void suspect(const char *dir, const struct vor_uuid *id)
{
    struct vor_store *store = vt_dir_store(dir);
    uint64_t requeued;
    uint32_t attempt;
    int changed;

    vt_assert_ok(vor_store_claim(store, id, vor_clock_wall_ms(), &attempt, &changed, &vt_err));
    ck_assert(changed);
    vt_assert_ok(vor_store_recover(store, 1, &requeued, &vt_err));
    ck_assert_uint_eq(requeued, 1);
    vor_store_close(store);
}

START_TEST(what_ran_in_a_crash_runs_with_nothing_beside_it)
{
    struct vt_daemon daemon;
    const char *dir = vt_dir_make();
    struct vor_uuid suspected, innocent;
    struct vor_worker_load load;

    vt_daemon_start(&daemon, dir, NULL);
    suspected = submit(&daemon, 10000);
    (void)vt_daemon_wait_iteration(&daemon, &suspected, 1);
    vt_daemon_stop(&daemon); /* gives it back: it waits */
    suspect(dir, &suspected);

    vt_daemon_start(&daemon, dir, NULL);
    innocent = submit(&daemon, 3);
    (void)vt_daemon_wait_iteration(&daemon, &suspected, 20);
    vor_worker_load(daemon.worker, &load);
    ck_assert_uint_eq(load.running, 1);
    ck_assert_uint_eq(load.waiting, 1);
    ck_assert_int_eq(vt_daemon_get(&daemon, &innocent).queue_position, 0);
    ck_assert_int_eq(vor_worker_cancel(daemon.worker, &suspected, "enough", &vt_err), VOR_DONE);
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &innocent).status, VOR_JOB_SUCCESSFUL);
    vt_daemon_stop(&daemon);
}
END_TEST

void vt_suite(Suite *suite)
{
    vor_log_open(2, VOR_LOG_ERROR);
    vt_add(suite, turns_that_fit_together_run_together);
    vt_add(suite, a_turn_larger_than_everything_runs_once_nothing_else_does);
    vt_add(suite, a_turn_alone_has_nothing_beside_it);
    vt_add(suite, a_guarded_queue_hands_out_its_first_job_once_the_guard_allows_it);
    vt_add(suite, what_ran_in_a_crash_runs_with_nothing_beside_it);
}
