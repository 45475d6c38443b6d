/* A full disk: what does not fit is refused and told apart, what was taken stays, and everything
 * goes on by itself once there is room. The disk is a small tmpfs in a mount namespace of the
 * test's own; where the kernel refuses that, the tests skip by name. */
#define _GNU_SOURCE /* unshare */

#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/reserve.h"
#include "server/work/job_service.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* Puts a disk of `kilobytes` at dir for this process; false when that is not allowed. */
static int small_disk(const char *dir, int kilobytes)
{
    char options[32];

    (void)snprintf(options, sizeof options, "size=%dk", kilobytes);
    if (unshare(CLONE_NEWNS) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0)
        return 0;
    return mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) == 0 &&
           mount("disk", dir, "tmpfs", 0, options) == 0;
}

static void remove_disk(const char *dir)
{
    ck_assert_int_eq(umount2(dir, MNT_DETACH), 0);
}

/* Takes all the room that is left. */
static void fill(const char *dir)
{
    static const char zeros[512];
    char path[512];
    int fd;

    (void)snprintf(path, sizeof path, "%s/filler", dir);
    fd = open(path, O_CREAT | O_WRONLY | O_APPEND, 0600);
    ck_assert_int_ge(fd, 0);
    while (write(fd, zeros, sizeof zeros) > 0)
        continue;
    ck_assert_int_eq(errno, ENOSPC);
    close(fd);
}

static void make_room(const char *dir)
{
    char path[512];

    (void)snprintf(path, sizeof path, "%s/filler", dir);
    ck_assert_int_eq(unlink(path), 0);
}

VT_TEST(a_blob_that_does_not_fit_is_refused_as_such)
{
    const char *dir = vt_dir_make();
    struct vor_blob_writer *writer;
    struct vor_blobs *blobs;
    struct vor_uuid id = vt_row(1).id;
    static const char bytes[100000];

    ck_assert(small_disk(dir, 400));
    blobs = vt_dir_blobs(dir);
    writer = vt_upload(blobs, bytes, sizeof bytes);
    fill(dir);
    vt_assert_fails(VOR_E_IO, vor_blob_append(writer, bytes, sizeof bytes, &vt_err));
    ck_assert(vor_error_storage_full(&vt_err));
    vt_assert_fails(VOR_E_IO, vor_blob_commit(writer, &id, "input", &vt_err));
    ck_assert(vor_error_storage_full(&vt_err));
    make_room(dir);
    vt_assert_ok(vor_blob_commit(vt_upload(blobs, bytes, sizeof bytes), &id, "input", &vt_err));
    vor_blobs_close(blobs);
    remove_disk(dir);
}

VT_TEST(a_store_without_room_refuses_and_goes_on_once_there_is_room)
{
    const char *dir = vt_dir_make();
    struct vor_job_view row = vt_row(10), back;
    struct vor_store *store;
    vor_status status = VOR_OK;
    int64_t rows = 0;
    int found, is_lost;

    ck_assert(small_disk(dir, 1000));
    store = vt_dir_store(dir);
    for (; status == VOR_OK; rows += status == VOR_OK) {
        row = vt_row(10);
        if (rows == 10)
            fill(dir);
        status = vor_store_insert(store, &row, NULL, &vt_err);
    }
    ck_assert_int_ge(rows, 10);
    ck_assert_int_eq(status, VOR_E_IO);
    ck_assert_msg(vor_error_storage_full(&vt_err), "%s", vt_err.message);
    vt_assert_ok(vor_store_check(store, &is_lost, &vt_err)); /* full is not out of order */
    vt_assert_ok(vor_store_get(store, &row.id, NULL, &back, &found, &vt_err));
    ck_assert(!found);
    make_room(dir);
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    ck_assert_int_eq(row.seq, rows + 1);
    vor_store_close(store);
    store = vt_dir_store(dir);
    back = vt_stored(store, &row.id);
    vor_store_close(store);
    remove_disk(dir);
}

/* A daemon that uses such a disk to its end. */
static void start(struct vt_daemon *daemon, const char *dir)
{
    vt_daemon_start(daemon, dir, NULL);
    vor_blobs_set_reserve(daemon->blobs, 0);
}

/* A job that runs until it is told to end, on a disk that is full from now on. */
static struct vor_uuid run_on_full_disk(struct vt_daemon *daemon)
{
    struct vor_spec endless = vt_request(2000, 10000);
    struct vor_uuid id = vt_daemon_submit_sphere(daemon, 1000, &endless);

    (void)vt_daemon_wait_iteration(daemon, &id, 1);
    fill(daemon->dir);
    return id;
}

static void nap(long milliseconds)
{
    struct timespec pause = {.tv_nsec = milliseconds * 1000000};

    nanosleep(&pause, NULL);
}

VT_TEST(a_result_that_does_not_fit_waits_for_room)
{
    struct vt_daemon daemon;
    const char *dir = vt_dir_make();
    struct vor_job_view view;
    struct vor_uuid id;

    ck_assert(small_disk(dir, 1000));
    start(&daemon, dir);
    id = run_on_full_disk(&daemon);
    ck_assert_int_eq(vor_job_service_stop(daemon.service, &id, &vt_err), VOR_DONE);
    nap(300);
    ck_assert_int_eq(vt_daemon_get(&daemon, &id).status, VOR_JOB_RUNNING);
    make_room(dir);
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert_msg(view.status == VOR_JOB_SUCCESSFUL, "%s", view.message);
    ck_assert_uint_eq(view.output[0].points, 2000);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vt_daemon_stop(&daemon);
    remove_disk(dir);
}

/* By its caller, or because the daemon goes down: then its row is given back. */
VT_TEST_LOOP(a_job_that_waits_for_room_can_be_ended_without_any, 2)
{
    struct vt_daemon daemon;
    const char *dir = vt_dir_make();
    struct vor_job_view view;
    struct vor_uuid id;
    int found;

    ck_assert(small_disk(dir, 1000));
    start(&daemon, dir);
    vor_store_set_reserve(daemon.store, 200000);
    vt_assert_ok(vor_store_check_reserve(daemon.store, &vt_err));
    id = run_on_full_disk(&daemon);
    ck_assert_int_eq(vor_job_service_stop(daemon.service, &id, &vt_err), VOR_DONE);
    nap(100);
    if (_i == 0)
        ck_assert_int_eq(vor_job_service_dismiss(daemon.service, &id, "no", NULL, &vt_err),
                         VOR_DONE);
    else
        vor_job_service_drain(daemon.service, 0);
    vt_assert_ok(vor_store_get(daemon.store, &id, NULL, &view, &found, &vt_err));
    ck_assert_int_eq(view.status, _i == 0 ? VOR_JOB_DISMISSED : VOR_JOB_ACCEPTED);
    vt_daemon_stop(&daemon);
    remove_disk(dir);
}

/* Takes rows until the store has no room for one more, whatever it still had for itself. */
static void exhaust(struct vt_daemon *daemon)
{
    struct vor_job_view row;

    fill(daemon->dir);
    do
        row = vt_row(10);
    while (vor_store_insert(daemon->store, &row, NULL, &vt_err) == VOR_OK);
    ck_assert(vor_error_storage_full(&vt_err));
}

VT_TEST(an_end_that_cannot_be_stored_is_stored_once_there_is_room)
{
    struct vt_daemon daemon;
    const char *dir = vt_dir_make();
    struct vor_spec endless = vt_request(300, 10000);
    struct vor_job_view view;
    struct vor_uuid id;

    ck_assert(small_disk(dir, 1000));
    start(&daemon, dir);
    id = vt_daemon_submit_sphere(&daemon, 500, &endless);
    (void)vt_daemon_wait_iteration(&daemon, &id, 1);
    exhaust(&daemon);
    ck_assert_int_eq(vor_job_service_dismiss(daemon.service, &id, "no", NULL, &vt_err), VOR_FAILED);
    ck_assert(vor_error_storage_full(&vt_err));
    ck_assert_int_eq(vor_job_service_stop(daemon.service, &id, &vt_err), VOR_DONE);
    nap(300);
    view = vt_daemon_get(&daemon, &id);
    ck_assert_int_eq(view.status, VOR_JOB_RUNNING); /* nobody is told what is not stored */
    make_room(dir);
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert(view.status == VOR_JOB_FAILED || view.status == VOR_JOB_SUCCESSFUL);
    vt_daemon_stop(&daemon);
    remove_disk(dir);
}

VT_TEST(what_ends_a_job_spends_the_reserve_which_is_made_again)
{
    struct vt_daemon daemon;
    const char *dir = vt_dir_make();
    struct vor_job_view row = vt_row(10);
    int changed;

    ck_assert(small_disk(dir, 1000));
    start(&daemon, dir);
    vor_blobs_set_reserve(daemon.blobs, 1);
    vor_store_set_reserve(daemon.store, 270000);
    vt_assert_ok(vor_job_service_ready(daemon.service, &vt_err));
    vt_assert_ok(vor_store_insert(daemon.store, &row, NULL, &vt_err));
    exhaust(&daemon);
    vt_assert_fails(VOR_E_IO, vor_job_service_ready(daemon.service, &vt_err));
    row.status = VOR_JOB_DISMISSED;
    vt_assert_ok(vor_store_finish(daemon.store, &row, NULL, NULL, &changed, &vt_err));
    ck_assert(changed);
    vt_assert_fails(VOR_E_IO, vor_store_check_reserve(daemon.store, &vt_err));
    make_room(dir);
    while (vor_job_service_ready(daemon.service, &vt_err) !=
           VOR_OK) /* the sweeper looks twice a second */
        nap(20);
    vt_daemon_stop(&daemon);
    remove_disk(dir);
}

/* Bytes of the disk that it has; -1: there is none. */
static long room_of(const char *path)
{
    struct stat info;

    return stat(path, &info) == 0 ? (long)info.st_blocks * 512 : -1;
}

/* Others may have taken its file away or made it sparse; a small one gives a half up, and does not
 * grow. */
VT_TEST(a_reserve_claims_no_room_that_its_file_does_not_have)
{
    enum { BYTES = 64 << 10 };
    const char *dir = vt_dir_make();
    struct vor_reserve *reserve;
    struct vor_error full;
    char path[512];

    ck_assert(small_disk(dir, 1000));
    (void)snprintf(path, sizeof path, "%s/reserve", dir);
    vt_assert_ok(vor_reserve_open(&reserve, path, &vt_err));
    vor_reserve_want(reserve, BYTES);
    ck_assert_int_eq(room_of(path), BYTES);
    (void)vor_fail_errno(&full, ENOSPC, "a row");
    ck_assert(vor_reserve_made_room(reserve, 0, VOR_E_IO, &full));
    ck_assert(!vor_reserve_made_room(reserve, 0, VOR_E_IO, &full));
    ck_assert_int_eq(room_of(path), BYTES / 2);
    ck_assert_int_eq(unlink(path), 0);
    vor_reserve_want(reserve, 1 << 30); /* which is more than the disk has */
    ck_assert_int_eq(room_of(path), -1);
    vor_reserve_want(reserve, 4096);
    vor_reserve_close(reserve);
    ck_assert_int_eq(room_of(path), 4096);
    ck_assert_int_eq(truncate(path, 0) | truncate(path, BYTES), 0);
    vt_assert_ok(vor_reserve_open(&reserve, path, &vt_err));
    vor_reserve_want(reserve, BYTES);
    vor_reserve_close(reserve);
    ck_assert_int_eq(room_of(path), BYTES);
    remove_disk(dir);
}

/* While the first hundred go, others take whatever there is. */
VT_TEST(small_files_that_go_give_their_room_to_the_disk)
{
    static const char bytes[20000];
    const char *dir = vt_dir_make();
    const struct vor_small_files *small;
    struct vt_daemon daemon;
    uint64_t was;
    char name[16];
    int count = 0;

    ck_assert(small_disk(dir, 40000));
    start(&daemon, dir);
    vor_blobs_set_reserve(daemon.blobs, 1);
    vor_store_set_reserve(daemon.store, 8400000);
    small = vor_store_small_files(daemon.store);
    do
        (void)snprintf(name, sizeof name, "%d", count++);
    while (small->put(small->ctx, name, bytes, sizeof bytes, &was, &vt_err) == VOR_OK);
    ck_assert(vor_error_storage_full(&vt_err));
    for (int i = 0; i < count - 1; i++) {
        if (i < 100)
            fill(dir);
        (void)snprintf(name, sizeof name, "%d", i);
        vt_assert_ok(small->drop(small->ctx, name, &was, NULL));
        ck_assert_uint_eq(was, sizeof bytes);
    }
    while (vor_job_service_ready(daemon.service, &vt_err) != VOR_OK)
        nap(20);
    vt_daemon_stop(&daemon);
    remove_disk(dir);
}

/* A start whose disk has no room but for the opening: the log has some of it. */
VT_TEST(jobs_can_be_removed_after_a_start_on_a_full_disk)
{
    const char *dir = vt_dir_make();
    struct vor_job_view row[300];
    struct vt_daemon daemon;
    char reserve[512];

    ck_assert(small_disk(dir, 20000));
    start(&daemon, dir);
    vor_store_set_reserve(daemon.store, 4000000);
    for (int i = 0; i < 300; i++) {
        row[i] = vt_row(10);
        vt_assert_ok(vor_store_insert(daemon.store, &row[i], NULL, &vt_err));
        ck_assert_int_eq(vor_job_service_dismiss(daemon.service, &row[i].id, "no", NULL, &vt_err),
                         VOR_DONE);
    }
    vt_daemon_stop(&daemon);
    (void)snprintf(reserve, sizeof reserve, "%s/jobs.sqlite.reserve", dir);
    ck_assert_int_eq(truncate(reserve, 250000), 0); /* what is left to an opening */
    fill(dir);
    start(&daemon, dir);
    for (int i = 0; i < 300; i++) {
        ck_assert_msg(vor_job_service_dismiss(daemon.service, &row[i].id, "no", NULL, &vt_err) ==
                          VOR_DONE,
                      "%d: %s", i, vt_err.message);
    }
    vt_daemon_stop(&daemon);
    remove_disk(dir);
}

VT_TEST(a_store_on_a_full_disk_opens_by_its_reserve)
{
    const char *dir = vt_dir_make();
    struct vor_job_view row = vt_row(10);
    struct vor_store *store;
    uint64_t requeued;

    ck_assert(small_disk(dir, 1000));
    store = vt_dir_store(dir);
    vor_store_set_reserve(store, 200000);
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    ck_assert_uint_eq(vt_claim(store, &row.id), 1);
    vor_store_close(store);
    fill(dir);
    store = vt_dir_store(dir);
    vt_assert_ok(vor_store_reap(store, "this life", 1, 1, &requeued, &vt_err));
    ck_assert_uint_eq(requeued, 1);
    vor_store_close(store);
    remove_disk(dir);
}

/* _i: after an end in order, and after a start that has spent what was kept for it. */
VT_TEST_LOOP(a_store_opens_on_a_full_disk_whose_reserve_is_spent, 2)
{
    const char *dir = vt_dir_make();
    struct vor_job_view row = vt_row(10);
    char reserve[512];
    struct vor_store *store;

    ck_assert(small_disk(dir, 1000));
    store = vt_dir_store(dir);
    vor_store_set_reserve(store, 200000);
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    vor_store_close(store);
    (void)snprintf(reserve, sizeof reserve, "%s/jobs.sqlite.reserve", dir);
    ck_assert_int_eq(truncate(reserve, 64 << 10), 0);
    fill(dir);
    for (int i = 0; i <= _i; i++) {
        store = vt_dir_store(dir);
        vor_store_set_reserve(store, 200000);
        row = vt_stored(store, &row.id);
        vt_assert_fails(VOR_E_IO, vor_store_check_reserve(store, &vt_err));
        vor_store_close(store);
    }
    remove_disk(dir);
}

/* A job that ran when the last daemon ended, on a disk that has no byte for its row. */
VT_TEST(what_a_start_cannot_put_in_order_waits_for_room)
{
    const char *dir = vt_dir_make();
    struct vor_spec spec = vt_request(300, 3);
    struct vor_job_view row = vt_row(10);
    struct vt_daemon daemon;
    struct vor_uuid id;

    ck_assert(small_disk(dir, 1000));
    vt_daemon_start(&daemon, dir, NULL);
    vt_assert_ok(vor_store_insert(daemon.store, &row, NULL, &vt_err));
    ck_assert_uint_eq(vt_claim(daemon.store, &row.id), 1);
    exhaust(&daemon);
    vt_daemon_stop(&daemon);
    fill(dir);
    start(&daemon, dir);
    vt_assert_fails(VOR_E_IO, vor_job_service_ready(daemon.service, &vt_err));
    ck_assert(vor_error_storage_full(&vt_err));
    ck_assert_int_eq(vor_job_service_get(daemon.service, &row.id, NULL, &row, &vt_err), VOR_DONE);
    ck_assert_int_eq(row.status, VOR_JOB_RUNNING);
    make_room(dir);
    while (row.status == VOR_JOB_RUNNING) { /* the sweeper looks twice a second */
        nap(20);
        ck_assert_int_eq(vor_job_service_get(daemon.service, &row.id, NULL, &row, &vt_err),
                         VOR_DONE);
    }
    while (vt_daemon_try_sphere(&daemon, 1000, &spec, &id) != VOR_DONE)
        nap(20);
    vt_daemon_stop(&daemon);
    remove_disk(dir);
}

/* Whether a child may have such a disk. */
static int allowed(void)
{
    char dir[] = "/tmp/voronoid-test-XXXXXX";
    int status = -1;
    pid_t child;

    if (mkdtemp(dir) == NULL)
        return 0;
    child = fork();
    if (child == 0)
        _exit(small_disk(dir, 100) ? 0 : 1);
    (void)waitpid(child, &status, 0);
    (void)rmdir(dir);
    return status == 0;
}

int main(void)
{
    Suite *suite;

    if (!allowed()) {
        puts("1..0 # SKIP storage_full: no mount namespace here");
        return 0;
    }
    vor_log_open(2, VOR_LOG_OFF);
    suite = suite_create("storage_full");
    return vt_run(suite);
}
