/* Uploads that are kept: as new bytes of another job, within their quota, and gone with their job,
 * also when the daemon died in between. */
#include "server/base/clock.h"
#include "server/work/job_service.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"
#include "tests/support/vt_sync.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* --- blobs of blobs --------------------------------------------------------------------------- */

static struct vor_blob_source source_of(const struct vor_uuid *id)
{
    struct vor_blob_source source = {.id = *id, .name = "upload", .sha256 = "5ha"};

    return source;
}

/* Shared where the first one is still there, else copied; bytes and name are durable, though the
 * first one's commit was lazy. */
VT_TEST_LOOP(a_blob_becomes_that_of_another_job_whether_it_stays_or_goes, 2)
{
    struct vor_uuid first = vt_row(1).id, second = vt_row(1).id;
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_source source = source_of(&first);
    struct vor_blob_writer *writer;
    char sha256[VOR_DIGEST_SIZE], path[512];
    struct stat info;
    int found;

    writer = vt_upload(blobs, "the cloud", 9);
    vor_blob_be_lazy(writer);
    vt_assert_ok(vor_blob_commit(writer, &first, "upload", &vt_err));
    vt_assert_ok(vor_blob_reopen(blobs, &source, &writer, &found, &vt_err));
    ck_assert(found);
    ck_assert_uint_eq(vor_blob_size(writer), 9);
    vor_blob_sha256(writer, sha256);
    ck_assert_str_eq(sha256, "5ha");
    if (_i == 1)
        vt_assert_ok(vor_blob_drop(blobs, &first, "upload", &vt_err));
    vt_sync_close_after(9);
    vt_assert_ok(vor_blob_commit(writer, &second, "upload", &vt_err));
    ck_assert_int_eq(vt_sync_left(), 7);
    ck_assert(vt_sync_open());
    ck_assert_str_eq(vt_blob_text(blobs, &second, "upload"), "the cloud");
    (void)snprintf(path, sizeof path, "%s/blobs/keep/%s.upload", dir, second.text);
    ck_assert_int_eq(stat(path, &info), 0);
    ck_assert_int_eq((int)info.st_nlink, _i == 1 ? 1 : 2);
    vt_assert_ok(vor_blob_drop(blobs, &first, "upload", &vt_err));
    ck_assert_str_eq(vt_blob_text(blobs, &second, "upload"), "the cloud");
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vor_blobs_close(blobs);
}

VT_TEST(a_blob_that_is_not_there_is_not_found_and_one_that_is_discarded_stays)
{
    struct vor_uuid id = vt_row(1).id;
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_source source = source_of(&id);
    struct vor_blob_writer *writer;
    int found;

    vt_assert_ok(vor_blob_reopen(blobs, &source, &writer, &found, &vt_err));
    ck_assert(!found);
    ck_assert_ptr_null(writer);
    vt_blob_put(blobs, &id, "upload", "the cloud");
    vt_assert_ok(vor_blob_reopen(blobs, &source, &writer, &found, &vt_err));
    vor_blob_discard(writer);
    ck_assert_str_eq(vt_blob_text(blobs, &id, "upload"), "the cloud");
    vor_blobs_close(blobs);
}

/* --- a job and its upload --------------------------------------------------------------------- */

/* Admits a sphere and keeps its upload; its bytes. */
static uint64_t admit(struct vor_admitted *admitted, struct vor_blobs *blobs, uint64_t keep)
{
    struct vor_admit_limits limits = {
        .codec = VOR_LIMITS_DEFAULT, .memory = (size_t)1 << 30, .keep = keep};
    struct vor_blob_writer *upload;
    struct vor_cloud cloud;

    vt_cloud_sphere(&cloud, 1, 300);
    upload = vt_upload_cloud(blobs, &cloud);
    vt_assert_ok(vor_admit_file(admitted, "cloud", blobs, upload, &limits, &vt_err));
    vor_admit_keep(admitted, upload, &limits);
    vor_cloud_free(&cloud);
    return admitted->item[0].found.bytes;
}

static struct vor_uuid submit(struct vt_daemon *daemon, int iterations)
{
    struct vor_admitted admitted = {.count = 0};
    struct vor_spec spec = vt_request(50, iterations);

    (void)admit(&admitted, daemon->blobs, UINT64_MAX);
    ck_assert(admitted.item[0].is_kept);
    ck_assert_int_eq(vor_job_service_submit(daemon->service, &admitted, &spec, NULL, NULL, &vt_err),
                     VOR_DONE);
    return admitted.id;
}

/* Before the answer the decoded input, its name and the row, later the result, its name and the
 * last row; a claim and a kept upload wait for no disk. */
VT_TEST(a_job_waits_for_the_disk_six_times)
{
    struct vt_daemon daemon;
    struct vor_uuid id;

    vt_daemon_start(&daemon, vt_dir_make(), &(struct vt_daemon_options){.keep = 1 << 20});
    id = submit(&daemon, 3); /* the first one begins a log of the store as well */
    (void)vt_daemon_wait_over(&daemon, &id);
    vt_daemon_wait_idle(&daemon);
    vt_sync_close_after(6);
    id = submit(&daemon, 3);
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &id).status, VOR_JOB_SUCCESSFUL);
    vt_daemon_wait_idle(&daemon);
    ck_assert_int_eq(vt_sync_waiting(), 0);
    ck_assert(vt_sync_open());
    vt_daemon_stop(&daemon);
}

static int is_there(const char *dir, const struct vor_uuid *id)
{
    char path[512];

    (void)snprintf(path, sizeof path, "%s/blobs/keep/%s.upload", dir, id->text);
    return access(path, R_OK) == 0;
}

static void wait_until_gone(const char *dir, const struct vor_uuid *id)
{
    while (is_there(dir, id))
        vt_nap();
}

VT_TEST(an_upload_is_kept_if_it_fits_and_dropped_with_what_is_not_submitted)
{
    struct vor_admitted admitted = {.count = 0}, other = {.count = 0}, none = {.count = 0};
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    uint64_t size = admit(&admitted, blobs, UINT64_MAX);

    ck_assert(admitted.item[0].is_kept && is_there(dir, &admitted.id));
    (void)admit(&other, blobs, size - 1);
    ck_assert(!other.item[0].is_kept && !is_there(dir, &other.id));
    (void)admit(&none, blobs, 0);
    ck_assert(!none.item[0].is_kept && !is_there(dir, &none.id));
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 4);
    vor_admit_drop(blobs, &admitted);
    vor_admit_drop(blobs, &other);
    vor_admit_drop(blobs, &none);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 0);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vor_blobs_close(blobs);
}

VT_TEST(the_quota_never_takes_the_upload_of_a_job_that_waits_or_runs)
{
    struct vt_daemon_options options = {.jobs = 1, .keep = 1};
    const char *dir = vt_dir_make();
    struct vt_daemon daemon;
    struct vor_uuid runs, waits;

    vt_daemon_start(&daemon, dir, &options);
    runs = submit(&daemon, 10000);
    (void)vt_daemon_wait_iteration(&daemon, &runs, 0);
    waits = submit(&daemon, 1);
    vt_assert_ok(vor_job_service_sweep(daemon.service, &vt_err));
    ck_assert(is_there(dir, &runs) && is_there(dir, &waits));
    ck_assert_uint_gt(vt_daemon_get(&daemon, &waits).kept, 1);
    ck_assert_int_eq(vor_job_service_stop(daemon.service, &runs, &vt_err), VOR_DONE);
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &waits).status, VOR_JOB_SUCCESSFUL);
    wait_until_gone(dir, &runs);
    wait_until_gone(dir, &waits);
    ck_assert_uint_eq(vt_daemon_get(&daemon, &runs).kept, 0);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_dismissal_drops_the_upload_and_a_failure_keeps_it)
{
    struct vt_daemon_options options = {.jobs = 1, .keep = UINT64_MAX / 2};
    const char *dir = vt_dir_make();
    struct vt_daemon daemon;
    struct vor_uuid runs, waits;

    vt_daemon_start(&daemon, dir, &options);
    runs = submit(&daemon, 10000);
    (void)vt_daemon_wait_iteration(&daemon, &runs, 0);
    waits = submit(&daemon, 1);
    vt_assert_ok(vor_blob_drop(daemon.blobs, &waits, "input", &vt_err)); /* so that it fails */
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &runs, "enough", &vt_err), VOR_DONE);
    ck_assert(!is_there(dir, &runs));
    ck_assert_uint_eq(vt_daemon_get(&daemon, &runs).kept, 0);
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &waits).status, VOR_JOB_FAILED);
    ck_assert(is_there(dir, &waits));
    ck_assert_int_eq(vor_job_service_dismiss(daemon.service, &waits, "", NULL, &vt_err), VOR_DONE);
    ck_assert(!is_there(dir, &waits));
    vt_daemon_stop(&daemon);
}

/* --- between two steps ------------------------------------------------------------------------ */

/* What a daemon leaves that is killed between two of its steps. */
enum left {
    NO_ROW,    /* the upload is there, the job is not */
    WAITS,     /* both are */
    DONE,      /* the job has ended well */
    SHED,      /* the store has given the upload up */
    EXPIRED,   /* or the job */
    DISMISSED, /* likewise */
    REMOVED,   /* the row is gone */
    LEFTS
};

static const int stays[LEFTS] = {[WAITS] = 1, [DONE] = 1};

static void finish(struct vor_store *store, struct vor_job_view *row, enum vor_job_status status,
                   int64_t expires)
{
    int changed;

    row->status = status;
    row->kept = status == VOR_JOB_DISMISSED ? 0 : row->kept;
    row->finished = vor_clock_wall_ms() - 1000;
    row->expires = expires;
    vt_assert_ok(vor_store_finish(store, row, NULL, NULL, &changed, &vt_err));
    ck_assert(changed);
}

static void leave(struct vor_store *store, struct vor_job_view *row, enum left left)
{
    int64_t now = vor_clock_wall_ms(), later = now + 3600000;
    struct vor_evicted gone[1];
    struct vor_evictions evictions = {.job = gone, .max = 1, .count = 1};
    int changed;

    if (left == NO_ROW)
        return;
    vt_assert_ok(vor_store_insert(store, row, NULL, &vt_err));
    if (left == WAITS)
        return;
    finish(store, row, left == DISMISSED ? VOR_JOB_DISMISSED : VOR_JOB_SUCCESSFUL,
           left == EXPIRED ? now : later);
    if (left == SHED)
        vt_assert_ok(vor_store_evict(store, VOR_EVICT_UPLOADS, 0, &evictions, &vt_err));
    else if (left == EXPIRED)
        vt_assert_ok(vor_store_evict(store, VOR_EVICT_EXPIRED, now, &evictions, &vt_err));
    else if (left == REMOVED)
        vt_assert_ok(vor_store_remove(store, &row->id, &changed, &vt_err));
    ck_assert_uint_eq(evictions.count, 1);
}

VT_TEST_LOOP(the_next_start_drops_the_uploads_that_no_row_counts_and_no_others, LEFTS)
{
    struct vt_daemon_options options = {.keep = UINT64_MAX / 2};
    struct vor_admitted admitted = {.count = 0};
    struct vor_job_view row = vt_row(10);
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_uuid stray = vt_row(1).id;
    struct timespec rest = {.tv_nsec = 20000000}; /* the stray may be the first of the blobs */
    struct vt_daemon daemon;

    row.kept = admit(&admitted, blobs, UINT64_MAX);
    row.id = admitted.id;
    row.input[0] = admitted.item[0].found;
    vt_blob_put(blobs, &stray, "upload", "x");
    leave(store, &row, (enum left)_i);
    vor_store_close(store);
    vor_blobs_close(blobs);
    vt_daemon_start(&daemon, dir, &options);
    if (_i == WAITS)
        ck_assert_int_eq(vt_daemon_wait_over(&daemon, &row.id).status, VOR_JOB_SUCCESSFUL);
    wait_until_gone(dir, &stray);
    if (stays[_i])
        nanosleep(&rest, NULL);
    else
        wait_until_gone(dir, &row.id);
    vt_daemon_stop(&daemon);
    ck_assert_int_eq(is_there(dir, &row.id), stays[_i]);
}

/* What a power cut takes that comes after the rows and before the bytes of kept uploads: all of
 * them, or their end. */
VT_TEST(the_next_start_forgets_uploads_that_are_missing_or_not_whole)
{
    enum { MISSING, SHORT, WHOLE, JOBS };
    struct vt_daemon_options options = {.keep = UINT64_MAX / 2};
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_job_view rows[JOBS];
    struct vt_daemon daemon;
    char path[512];

    for (int i = 0; i < JOBS; i++) {
        struct vor_admitted admitted = {.count = 0};

        rows[i] = vt_row(10);
        rows[i].kept = admit(&admitted, blobs, UINT64_MAX);
        rows[i].id = admitted.id;
        rows[i].input[0] = admitted.item[0].found;
        leave(store, &rows[i], DONE);
        (void)snprintf(path, sizeof path, "%s/blobs/keep/%.36s.upload", dir, rows[i].id.text);
        ck_assert_int_eq(i == MISSING ? unlink(path) : i == SHORT ? truncate(path, 100) : 0, 0);
    }
    vor_store_close(store);
    vor_blobs_close(blobs);
    vt_daemon_start(&daemon, dir, &options);
    wait_until_gone(dir, &rows[SHORT].id);
    while (vt_daemon_get(&daemon, &rows[MISSING].id).kept > 0) /* the oldest is the last */
        vt_nap();
    ck_assert_uint_eq(vt_daemon_get(&daemon, &rows[SHORT].id).kept, 0);
    ck_assert_uint_eq(vt_daemon_get(&daemon, &rows[WHOLE].id).kept, rows[WHOLE].kept);
    vt_daemon_stop(&daemon);
    ck_assert(is_there(dir, &rows[WHOLE].id));
}

VT_LOG(VOR_LOG_ERROR)
