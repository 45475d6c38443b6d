/* The first moments of a daemon: what a former life left is in line before anybody is answered, and
 * nobody waits for the tidying up. */
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"
#include "tests/support/vt_sync.h"

#include <errno.h>
#include <stdatomic.h>
#include <unistd.h>

/* A former life: store and blobs, without a job service. */
struct life {
    const char *dir;
    struct vor_store *store;
    struct vor_blobs *blobs;
};

static struct life begin_life(void)
{
    struct life life = {.dir = vt_dir_make()};

    life.store = vt_dir_store(life.dir);
    life.blobs = vt_dir_blobs(life.dir);
    return life;
}

/* As a crash would end it: rows stay as they are. */
static void end_life(struct life *life)
{
    vor_store_close(life->store);
    vor_blobs_close(life->blobs);
}

static void keep(struct life *life, const struct vor_uuid *id, const char *name)
{
    vt_assert_ok(vor_blob_commit(vt_upload(life->blobs, "rubbish", 7), id, name, &vt_err));
}

/* A job that waits and fails once it runs: its input is no cloud. */
static struct vor_job_view leave_waiting(struct life *life)
{
    struct vor_job_view row = vt_row(10);

    keep(life, &row.id, "input");
    vt_assert_ok(vor_store_insert(life->store, &row, NULL, &vt_err));
    return row;
}

/* A job that waits and runs until it is told to end. */
static struct vor_uuid leave_endless(struct life *life)
{
    struct vor_admitted admitted = {.count = 0};
    struct vor_job_view row = vt_row(300);
    struct vor_cloud cloud;

    row.spec = vt_request(300, 10000);
    vt_assert_ok(vor_spec_set(&row.spec, "format", "ply", &vt_err));
    vt_cloud_sphere(&cloud, 1, 500);
    vt_admit(&admitted, life->blobs, "cloud", &cloud);
    row.id = admitted.id;
    row.input[0] = admitted.item[0].found;
    vor_cloud_free(&cloud);
    vt_assert_ok(vor_store_insert(life->store, &row, NULL, &vt_err));
    return row.id;
}

/* The rows of a former life, in the order of acceptance; the first of them were running. */
enum { ROWS = 40, RAN = 8 };

static void leave_rows(struct life *life, struct vor_job_view rows[ROWS])
{
    for (int i = 0; i < ROWS; i++)
        rows[i] = leave_waiting(life);
    for (int i = 0; i < RAN; i++)
        ck_assert_uint_eq(vt_claim(life->store, &rows[i].id), 1);
}

VT_TEST(every_job_of_a_former_life_is_in_line_before_the_worker_is_there)
{
    struct vt_daemon_options options = {.jobs = 1, .queue = 4};
    struct life life = begin_life();
    struct vor_uuid blocker = leave_endless(&life), refused;
    struct vor_job_view rows[ROWS], view;
    struct vor_spec spec = vt_request(10, 1);
    struct vor_job_service_load load;
    struct vt_daemon daemon;
    int64_t started = 0;

    ck_assert_uint_eq(vt_claim(life.store, &blocker), 1);
    leave_rows(&life, rows);
    end_life(&life);
    vt_daemon_start(&daemon, life.dir, &options);
    vor_job_service_load(daemon.service, &load);
    /* The blocker more, which may be on its way from the line to a runner. */
    ck_assert_uint_ge(load.waiting + load.running, ROWS);
    ck_assert_int_eq(vor_job_service_room(daemon.service, NULL, 0, NULL), VOR_FULL);
    ck_assert_int_eq(vt_daemon_try_sphere(&daemon, 100, &spec, &refused), VOR_FULL);
    ck_assert_uint_eq(vt_daemon_wait_iteration(&daemon, &blocker, 0).attempt, 2);
    vor_job_service_load(daemon.service, &load);
    ck_assert_uint_eq(load.waiting + load.running, ROWS + 1);
    for (int i = 0; i < ROWS; i++) {
        view = vt_daemon_get(&daemon, &rows[i].id);
        ck_assert_int_eq(view.status, VOR_JOB_ACCEPTED);
        ck_assert_int_eq(view.queue_position, i);
        ck_assert_uint_eq(view.attempt, i < RAN ? 2 : 1);
    }
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &blocker, "off you go", &vt_err),
                     VOR_DONE);
    for (int i = 0; i < ROWS; i++) {
        view = vt_daemon_wait_over(&daemon, &rows[i].id);
        ck_assert_int_eq(view.status, VOR_JOB_FAILED);
        if (i >= RAN) { /* those that ran before keep the time when they first started */
            ck_assert_int_ge(view.started, started);
            started = view.started;
        }
    }
    vt_daemon_stop(&daemon);
}

static void leave_expired(struct life *life, struct vor_job_view *row)
{
    int changed;

    *row = vt_row(10);
    vt_assert_ok(vor_store_insert(life->store, row, NULL, &vt_err));
    keep(life, &row->id, "cloud");
    row->status = VOR_JOB_SUCCESSFUL;
    row->finished = vor_clock_wall_ms() - 3600000;
    row->expires = vor_clock_wall_ms();
    vt_assert_ok(vor_store_finish(life->store, row, NULL, NULL, &changed, &vt_err));
}

/* Regression: the start wrote every expired row before it looked at the jobs that waited. */
VT_TEST(a_start_does_not_wait_for_what_has_expired)
{
    enum { EXPIRED = 40, SYNCS = 8 }; /* of the recovery itself, with the first of a log file */
    struct life life = begin_life();
    struct vor_uuid endless = leave_endless(&life);
    struct vor_job_view rows[EXPIRED];
    struct vt_daemon daemon;

    for (int i = 0; i < EXPIRED; i++)
        leave_expired(&life, &rows[i]);
    ck_assert_uint_eq(vt_claim(life.store, &endless), 1);
    end_life(&life);
    vt_sync_close_after(SYNCS);
    vt_daemon_start(&daemon, life.dir, NULL);
    ck_assert(!vor_job_status_over(vt_daemon_get(&daemon, &endless).status));
    ck_assert(vt_sync_open());
    for (int i = 0; i < EXPIRED; i++)
        while (!vt_daemon_get(&daemon, &rows[i].id).expired)
            vt_nap();
    while (vt_dir_count(life.dir, "blobs/keep") > 1)
        vt_nap();
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &endless, "enough", &vt_err), VOR_DONE);
    vt_daemon_stop(&daemon);
}

/* An upload that is admitted while strays are looked for has bytes and no row yet; what is a stray
 * later goes as well. */
VT_TEST(bytes_that_came_after_the_start_are_no_strays)
{
    enum { STRAYS = 60 };
    const struct vt_daemon_options options = {.tidies = 1};
    const struct vor_uuid old = {"01908d7e-0000-7000-8000-000000000003"};
    struct vor_admitted admitted = {.count = 0};
    struct vor_spec spec = vt_request(20, 1);
    struct life life = begin_life();
    struct vt_daemon daemon;
    struct vor_cloud cloud;
    struct vor_uuid id;

    for (int i = 0; i < STRAYS; i++) {
        id = vt_row(1).id;
        keep(&life, &id, "input");
    }
    end_life(&life);
    vt_daemon_start(&daemon, life.dir, &options);
    vt_cloud_sphere(&cloud, 1, 100);
    vt_admit(&admitted, daemon.blobs, "cloud", &cloud);
    for (int later = 0; later < 2; later++) {
        while (vt_dir_count(life.dir, "blobs/keep") > 1)
            vt_nap();
        if (!later)
            vt_blob_put(daemon.blobs, &old, "cloud", "a result that nobody needs");
    }
    ck_assert_int_eq(vor_job_service_submit(daemon.service, &admitted, &spec, NULL, NULL, &vt_err),
                     VOR_DONE);
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &admitted.id).status, VOR_JOB_SUCCESSFUL);
    vor_cloud_free(&cloud);
    vt_daemon_stop(&daemon);
}

/* A crash between a result's bytes and its row leaves them to the next attempt, or to nobody. */
VT_TEST_LOOP(the_bytes_of_a_crashed_attempt_go_when_its_job_is_dismissed, 2)
{
    struct vt_daemon_options options = {.jobs = 1};
    struct life life = begin_life();
    struct vor_uuid runs = leave_endless(&life);
    struct vor_job_view waits = leave_waiting(&life);
    struct vt_daemon daemon;

    keep(&life, &waits.id, "cloud");
    ck_assert(vt_claim(life.store, &runs) && vt_claim(life.store, &waits.id));
    end_life(&life);
    vt_daemon_start(&daemon, life.dir, &options);
    (void)vt_daemon_wait_iteration(&daemon, &runs, 0);
    if (_i == 1)
        vor_job_service_drain(daemon.service, 0); /* no job is live any more */
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &waits.id, "enough", &vt_err),
                     VOR_DONE);
    ck_assert_int_eq(vt_dir_count(life.dir, "blobs/keep"), 1);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &runs, "enough", &vt_err), VOR_DONE);
    vt_daemon_stop(&daemon);
    ck_assert_int_eq(vt_dir_count(life.dir, "blobs/keep"), 0);
}

/* A crash between a row that says that the job is over and the removal of what former attempts
 * left. */
VT_TEST(the_bytes_of_a_former_attempt_go_and_those_of_the_last_one_stay)
{
    const struct vt_daemon_options options = {.tidies = 1};
    struct life life = begin_life();
    struct vor_job_view row = vt_row(10);
    struct vt_daemon daemon;
    uint64_t reaped;
    int changed;

    vt_assert_ok(vor_store_insert(life.store, &row, NULL, &vt_err));
    ck_assert_uint_eq(vt_claim(life.store, &row.id), 1);
    keep(&life, &row.id, "cloud");
    vt_assert_ok(vor_store_reap(life.store, "another", 1, vor_clock_wall_ms(), &reaped, &vt_err));
    ck_assert_uint_eq(vt_claim(life.store, &row.id), 2);
    row.status = VOR_JOB_SUCCESSFUL;
    row.attempt = 2;
    row.finished = vor_clock_wall_ms();
    row.expires = row.finished + 1000000;
    vt_assert_ok(vor_store_finish(life.store, &row, NULL, NULL, &changed, &vt_err));
    keep(&life, &row.id, "cloud-try-2");
    end_life(&life);
    vt_daemon_start(&daemon, life.dir, &options);
    while (vt_dir_count(life.dir, "blobs/keep") > 1)
        vt_nap();
    ck_assert_str_ne(vt_blob_text(daemon.blobs, &row.id, "cloud-try-2"), "");
    vt_daemon_stop(&daemon);
}

/* Stands for a store whose disk is full at the first recovery, and which breaks off behind the
 * second; once fail_first was called. */
static atomic_int fails, recoveries, counts;
vor_status __real_vor_store_reap(struct vor_store *store, const char *owner, int is_alone,
                                 int64_t now_ms, uint64_t *reaped, struct vor_error *err);
vor_status __wrap_vor_store_reap(struct vor_store *store, const char *owner, int is_alone,
                                 int64_t now_ms, uint64_t *reaped, struct vor_error *err);
vor_status __real_vor_store_waiting(struct vor_store *store, struct vor_waiting *out,
                                    struct vor_error *err);
vor_status __wrap_vor_store_waiting(struct vor_store *store, struct vor_waiting *out,
                                    struct vor_error *err);

vor_status __wrap_vor_store_reap(struct vor_store *store, const char *owner, int is_alone,
                                 int64_t now_ms, uint64_t *reaped, struct vor_error *err)
{
    if (atomic_load(&fails) && atomic_fetch_add(&recoveries, 1) == 0)
        return vor_fail_errno(err, ENOSPC, "the job store");
    return __real_vor_store_reap(store, owner, is_alone, now_ms, reaped, err);
}

vor_status __wrap_vor_store_waiting(struct vor_store *store, struct vor_waiting *out,
                                    struct vor_error *err)
{
    if (atomic_load(&fails) && atomic_fetch_add(&counts, 1) == 0)
        return vor_fail(err, VOR_E_IO, "broken off");
    return __real_vor_store_waiting(store, out, err);
}

static void fail_first(struct vt_daemon *daemon)
{
    (void)daemon;
    atomic_store(&fails, 1);
}

/* Regression: the second round set what ran in this life back to accepted, and ran it again. */
VT_TEST(a_recovery_that_is_repeated_leaves_alone_what_runs_since)
{
    struct vt_daemon_options options = {.jobs = 2, .prepare = fail_first};
    struct life life = begin_life();
    struct vor_uuid runs = leave_endless(&life);
    struct vor_job_view row;
    struct vt_daemon daemon;

    ck_assert_uint_eq(vt_claim(life.store, &runs), 1);
    end_life(&life);
    vt_daemon_start(&daemon, life.dir, &options);
    (void)vt_daemon_wait_iteration(&daemon, &runs, 0);
    while (atomic_load(&counts) < 2)
        usleep(10000);
    while (vor_job_service_ready(daemon.service, &vt_err) != VOR_OK)
        usleep(10000);
    ck_assert_int_eq(atomic_load(&recoveries), 3);
    row = vt_stored(daemon.store, &runs);
    ck_assert(row.status == VOR_JOB_RUNNING && row.attempt == 2);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &runs, "enough", &vt_err), VOR_DONE);
    vt_daemon_stop(&daemon);
}

/* Stands for an allocation that fails: the first jobs are not made, and the store refuses to take
 * the first one back. */
static atomic_int unmade, refuses, refused;
vor_status __real_vor_store_hand_back(struct vor_store *store, const struct vor_uuid *id,
                                      struct vor_hand_back *run, struct vor_error *err);
vor_status __wrap_vor_store_hand_back(struct vor_store *store, const struct vor_uuid *id,
                                      struct vor_hand_back *run, struct vor_error *err);
struct vor_job *__real_vor_job_create(const struct vor_job_view *row);
struct vor_job *__wrap_vor_job_create(const struct vor_job_view *row);

struct vor_job *__wrap_vor_job_create(const struct vor_job_view *row)
{
    return atomic_fetch_sub(&unmade, 1) > 0 ? NULL : __real_vor_job_create(row);
}

vor_status __wrap_vor_store_hand_back(struct vor_store *store, const struct vor_uuid *id,
                                      struct vor_hand_back *run, struct vor_error *err)
{
    if (atomic_load(&refuses) && atomic_fetch_add(&refused, 1) == 0)
        return vor_fail(err, VOR_E_IO, "refused");
    return __real_vor_store_hand_back(store, id, run, err);
}

static void fail_memory(struct vt_daemon *daemon)
{
    (void)daemon;
    atomic_store(&refuses, 1);
    atomic_store(&unmade, 2);
}

/* Regression: it stayed running, with nobody to run it, until the next start. */
VT_TEST(a_job_for_which_there_was_no_memory_is_tried_again)
{
    struct vt_daemon_options options = {.jobs = 1, .prepare = fail_memory};
    struct life life = begin_life();
    struct vor_job_view row = leave_waiting(&life);
    struct vt_daemon daemon;

    end_life(&life);
    vt_daemon_start(&daemon, life.dir, &options);
    row = vt_daemon_wait_over(&daemon, &row.id);
    ck_assert_int_eq(row.status, VOR_JOB_FAILED);
    ck_assert_uint_eq(row.attempt, 3);
    ck_assert_int_eq(atomic_load(&refused), 3); /* the first call, its repetition, and one more */
    vt_daemon_stop(&daemon);
}

static void share(struct vt_daemon *daemon)
{
    daemon->store->is_shared = 1;
}

/* Starts a daemon with an endless run and takes the lease of that away. */
static struct life lose_lease(struct vt_daemon *daemon, struct vor_uuid *runs,
                              void (*prepare)(struct vt_daemon *))
{
    struct life life = begin_life();
    uint64_t reaped;

    *runs = leave_endless(&life);
    end_life(&life);
    vt_daemon_start(daemon, life.dir, &(struct vt_daemon_options){.jobs = 1, .prepare = prepare});
    (void)vt_daemon_wait_iteration(daemon, runs, 0);
    vt_assert_ok(vor_store_reap(daemon->store, VT_OWNER, 1, 1, &reaped, &vt_err));
    ck_assert_uint_eq(reaped, 1);
    return life;
}

/* As a daemon that was stopped for longer than its lease goes on: here it is told within seconds.
 */
VT_TEST(a_run_whose_job_another_owner_has_ends_and_leaves_it_alone)
{
    struct vor_uuid runs;
    struct vor_job_view row;
    struct vt_daemon daemon;
    struct life life = lose_lease(&daemon, &runs, NULL);
    int changed;

    ck_assert_uint_eq(vt_claim(daemon.store, &runs), 2);
    vt_daemon_wait_idle(&daemon);
    row = vt_stored(daemon.store, &runs);
    ck_assert(row.status == VOR_JOB_RUNNING && row.attempt == 2);
    ck_assert_int_eq(vt_dir_count(life.dir, "blobs/keep"), 1);
    row.status = VOR_JOB_FAILED;
    vt_assert_ok(vor_store_finish(daemon.store, &row, VT_LEASE(2), NULL, &changed, &vt_err));
    ck_assert(changed);
    vt_daemon_stop(&daemon);
}

/* Regression: what told the run before to end also ended the next one, "cancelled by the caller".
 */
VT_TEST(a_job_that_was_lost_and_comes_back_runs_again)
{
    struct vor_uuid runs;
    struct vor_job_view row;
    struct vt_daemon daemon;
    int found;

    (void)lose_lease(&daemon, &runs, share);
    do { /* a stop that comes before the second run begins counts for the first */
        vt_nap();
        vt_assert_ok(vor_store_get(daemon.store, &runs, NULL, &row, &found, &vt_err));
        if (row.attempt == 2 && row.status == VOR_JOB_RUNNING)
            ck_assert_int_ne(vor_job_service_stop(daemon.service, &runs, &vt_err), VOR_FAILED);
    } while (!vor_job_status_over(row.status));
    ck_assert_msg(row.status == VOR_JOB_SUCCESSFUL && row.attempt == 2, "%s", row.message);
    vt_daemon_stop(&daemon);
}

VT_TEST(what_ran_in_a_crash_runs_with_nothing_beside_it)
{
    struct vor_spec endless = vt_request(200, 10000), brief = vt_request(200, 3);
    struct vt_daemon daemon;
    struct life life = {.dir = vt_dir_make()};
    struct vor_uuid suspected, innocent;
    struct vor_job_service_load load;
    uint64_t requeued;

    vt_daemon_start(&daemon, life.dir, NULL);
    suspected = vt_daemon_submit_sphere(&daemon, 1500, &endless);
    (void)vt_daemon_wait_iteration(&daemon, &suspected, 1);
    vt_daemon_stop(&daemon); /* gives it back: it waits */
    life.store = vt_dir_store(life.dir);
    ck_assert_uint_gt(vt_claim(life.store, &suspected), 1);
    vt_assert_ok(vor_store_reap(life.store, "this life", 1, 1, &requeued, &vt_err));
    ck_assert_uint_eq(requeued, 1);
    vor_store_close(life.store);

    vt_daemon_start(&daemon, life.dir, NULL);
    innocent = vt_daemon_submit_sphere(&daemon, 1500, &brief);
    (void)vt_daemon_wait_iteration(&daemon, &suspected, 20);
    vor_job_service_load(daemon.service, &load);
    ck_assert(load.running == 1 && load.waiting == 1);
    ck_assert_int_eq(vt_daemon_get(&daemon, &innocent).queue_position, 0);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &suspected, "enough", &vt_err),
                     VOR_DONE);
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &innocent).status, VOR_JOB_SUCCESSFUL);
    vt_daemon_stop(&daemon);
}

VT_LOG(VOR_LOG_OFF)
