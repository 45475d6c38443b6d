/* Room on the disk and in the queue: what is decoded is charged before a job is accepted, and what
 * has been promised to one is not promised to another. */
#include "server/base/disk.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"
#include "tests/support/vt_sync.h"

#include <stdatomic.h>
#include <string.h>
#include <time.h>

static uint64_t available(struct vor_blobs *blobs)
{
    uint64_t bytes, total;

    vt_assert_ok(vor_blobs_space(blobs, &bytes, &total, &vt_err));
    return bytes;
}

static struct vor_blob_writer *create(struct vor_blobs *blobs)
{
    struct vor_blob_writer *writer = NULL;

    vt_assert_ok(vor_blob_create(blobs, &writer, &vt_err));
    return writer;
}

VT_TEST(room_promised_to_one_is_not_promised_to_another)
{
    enum { SPARE = 1 << 30 }; /* what else comes and goes on this disk meanwhile */
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_writer *first = create(blobs), *second = create(blobs);
    struct vor_uuid id = vt_row(1).id;
    uint64_t most = available(blobs) - VOR_BLOBS_RESERVE - SPARE;

    vt_assert_ok(vor_blobs_room(blobs, most, &vt_err));
    vt_assert_ok(vor_blob_promise(first, most, &vt_err));
    vt_assert_fails(VOR_E_IO, vor_blob_promise(second, 2 * (uint64_t)SPARE, &vt_err));
    ck_assert(vor_error_storage_full(&vt_err));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "reserved for other files"));
    vt_assert_fails(VOR_E_IO, vor_blobs_room(blobs, 2 * (uint64_t)SPARE, &vt_err));
    ck_assert(vor_blobs_lack_room(blobs));
    ck_assert(!vor_blobs_lack_room(blobs)); /* until it is asked for again */
    vt_assert_ok(vor_blob_append(first, "bytes", 5, &vt_err));
    vt_assert_ok(vor_blob_commit(first, &id, "input", &vt_err)); /* the rest is free again */
    vt_assert_ok(vor_blobs_room(blobs, most, &vt_err));
    vt_assert_ok(vor_blob_promise(second, most, &vt_err));
    vor_blob_discard(second);
    vt_assert_ok(vor_blobs_room(blobs, most, &vt_err));
    vor_blobs_close(blobs);
}

VT_TEST(bytes_beyond_a_promise_do_not_take_what_stays_free)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_writer *writer = create(blobs), *other = create(blobs);
    struct vor_uuid id = vt_row(1).id;

    vt_assert_ok(vor_blob_promise(writer, 3, &vt_err));
    vor_blobs_set_reserve(blobs, (uint64_t)1 << 60);
    vt_assert_ok(vor_blob_append(writer, "abc", 3, &vt_err));
    vt_assert_fails(VOR_E_IO, vor_blob_append(writer, "d", 1, &vt_err));
    ck_assert(vor_error_storage_full(&vt_err));
    vor_blob_discard(writer);
    vt_assert_ok(vor_blob_append(other, "a result", 8, &vt_err)); /* jobs under way can end */
    vt_assert_ok(vor_blob_commit(other, &id, "cloud", &vt_err));
    vor_blobs_close(blobs);
}

VT_TEST(a_decoded_input_that_does_not_fit_is_refused_before_it_is_written)
{
    struct vor_admit_limits limits = {.codec = VOR_LIMITS_DEFAULT, .memory = (size_t)1 << 30};
    struct vor_admitted admitted = {.count = 0};
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_writer *upload;
    struct vor_cloud cloud;

    vt_cloud_sphere(&cloud, 1, 100);
    upload = vt_upload_cloud(blobs, &cloud);
    vor_blobs_set_reserve(blobs, (uint64_t)1 << 60);
    vt_assert_fails(VOR_E_IO, vor_admit_file(&admitted, "cloud", blobs, upload, &limits, &vt_err));
    ck_assert(vor_error_storage_full(&vt_err));
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 0);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 1); /* the upload */
    vor_blob_discard(upload);
    vor_cloud_free(&cloud);
    vor_blobs_close(blobs);
}

static void count_failure(void *ctx, const struct vor_error *why)
{
    ck_assert_int_eq(why->status, VOR_E_IO);
    atomic_fetch_add((atomic_int *)ctx, 1);
}

/* Regression: every change was refused for ever, and the daemon lived on. */
VT_TEST_LOOP(a_disk_that_fails_is_told_once_and_the_next_start_has_what_was_accepted, 2)
{
    static atomic_int told;
    struct vt_daemon_options options = {.failed = count_failure, .failed_ctx = &told};
    struct timespec pause = {.tv_nsec = 20000000};
    const char *dir = vt_dir_make();
    struct vor_spec spec = vt_request(20, 1);
    struct vor_job_view row = vt_row(10);
    struct vt_daemon daemon;
    struct vor_uuid id;

    vt_daemon_start(&daemon, dir, &options);
    id = vt_daemon_submit_sphere(&daemon, 100, &spec);
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &id).status, VOR_JOB_SUCCESSFUL);
    if (_i == 0) {
        vt_sync_fail(1, 0);
        vt_assert_fails(VOR_E_IO, vor_store_insert(daemon.store, &row, NULL, &vt_err));
    } else {
        vt_sync_fail(0, 1);
        vt_assert_fails(
            VOR_E_IO, vor_blob_commit(vt_upload(daemon.blobs, "x", 1), &row.id, "input", &vt_err));
    }
    while (atomic_load(&told) == 0)
        nanosleep(&pause, NULL);
    for (int i = 0; i < 30 && _i == 0; i++)
        nanosleep(&pause, NULL); /* it looks twice a second */
    ck_assert_int_eq(atomic_load(&told), 1);
    vt_daemon_stop(&daemon);
    vt_sync_fail(0, 0);
    vt_daemon_start(&daemon, dir, NULL);
    ck_assert_int_eq(vt_daemon_get(&daemon, &id).status, VOR_JOB_SUCCESSFUL);
    vt_daemon_stop(&daemon);
}

/* --- the queue -------------------------------------------------------------------------------- */

/* Bytes of the dump of 500 points, and of its seal. */
enum { DECODED = 500 * 12 + 56 + 72 };

static enum vor_job_outcome submit(struct vt_daemon *daemon, struct vor_uuid *id)
{
    struct vor_spec endless = vt_request(300, 10000);

    return vt_daemon_try_sphere(daemon, 500, &endless, id);
}

VT_TEST(inputs_that_wait_are_bounded_by_their_decoded_bytes)
{
    struct vt_daemon_options options = {.jobs = 1, .queue_bytes = 2 * DECODED + 1000};
    const char *dir = vt_dir_make();
    struct vor_uuid runs, waits, other, refused;
    struct vt_daemon daemon;

    vt_daemon_start(&daemon, dir, &options);
    ck_assert_int_eq(submit(&daemon, &runs), VOR_DONE);
    (void)vt_daemon_wait_iteration(&daemon, &runs, 0); /* what runs does not count */
    ck_assert_int_eq(submit(&daemon, &waits), VOR_DONE);
    ck_assert_int_eq(submit(&daemon, &other), VOR_DONE);
    ck_assert_int_eq(submit(&daemon, &refused), VOR_FULL);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 3); /* nothing is left of it */
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &waits, "enough", &vt_err), VOR_DONE);
    ck_assert_int_eq(submit(&daemon, &waits), VOR_DONE);
    vt_daemon_stop(&daemon); /* all wait for the next start, which counts them again */
    vt_daemon_start(&daemon, dir, &options);
    (void)vt_daemon_wait_iteration(&daemon, &runs, 0);
    ck_assert_int_eq(submit(&daemon, &refused), VOR_FULL);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &other, "enough", &vt_err), VOR_DONE);
    ck_assert_int_eq(submit(&daemon, &other), VOR_DONE);
    vt_daemon_stop(&daemon);
}

VT_TEST(an_input_that_never_fits_into_the_queue_is_told_the_bound)
{
    struct vt_daemon_options options = {.jobs = 1, .queue_bytes = 2000};
    const char *dir = vt_dir_make();
    struct vt_daemon daemon;
    struct vor_uuid id;

    vt_daemon_start(&daemon, dir, &options);
    ck_assert_int_eq(submit(&daemon, &id), VOR_FAILED);
    ck_assert_int_eq(vt_err.status, VOR_E_BYTES);
    ck_assert_uint_eq(vt_err.limit, 2000);
    ck_assert_uint_ge(vt_err.got, DECODED);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 0);
    vt_daemon_stop(&daemon);
}

VT_LOG(VOR_LOG_OFF)
