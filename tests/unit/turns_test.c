/* Who runs beside whom. */
#include "server/base/clock.h"
#include "server/base/log.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

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

    ck_assert_uint_gt(vt_claim(store, id), 1);
    vt_assert_ok(vor_store_reap(store, "this life", INT64_MAX, 1, &requeued, &vt_err));
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
    vt_add(suite, what_ran_in_a_crash_runs_with_nothing_beside_it);
}
