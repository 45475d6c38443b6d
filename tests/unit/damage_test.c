/* What a flipped bit does to inputs and results, and a missing table of jobs: no wrong byte is
 * taken for a right one, and nothing is swept away. */
#include "server/base/clock.h"
#include "server/work/verify.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static void flip_at(const char *path, off_t at)
{
    int fd = open(path, O_RDWR);
    uint8_t byte;

    ck_assert_int_ge(fd, 0);
    ck_assert_int_eq(pread(fd, &byte, 1, at), 1);
    byte ^= 16;
    ck_assert_int_eq(pwrite(fd, &byte, 1, at), 1);
    close(fd);
}

/* The table was replaced by an older one, or by none: results are not swept away before their time.
 */
VT_TEST(more_results_without_rows_than_a_crash_leaves_stay)
{
    enum { RESULTS = 12 };
    const struct vor_uuid old = {"01908d7e-0000-7000-8000-000000000003"};
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_uuid id[RESULTS];
    struct vt_daemon daemon;

    for (int i = 0; i < RESULTS; i++) {
        id[i] = vt_row(10).id;
        vt_blob_put(blobs, &id[i], "cloud", "result");
    }
    vt_blob_put(blobs, &old, "cloud", "result");
    vor_blobs_close(blobs);
    vt_daemon_start(&daemon, dir, NULL);
    while (vt_dir_count(dir, "blobs/keep") > RESULTS)
        vt_nap();
    for (int i = 0; i < RESULTS; i++)
        ck_assert_str_eq(vt_blob_text(daemon.blobs, &id[i], "cloud"), "result");
    vt_daemon_stop(&daemon);
}

/* --- the bytes -------------------------------------------------------------------------------- */

VT_TEST(a_seal_tells_every_flipped_bit)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_writer *writer = vt_upload(blobs, "the bytes", 9);
    uint8_t bytes[256];
    ssize_t sealed;
    size_t size;

    vt_assert_ok(vor_blob_seal(writer, &vt_err));
    sealed = pread(vor_blob_fd(writer), bytes, sizeof bytes, 0);
    for (ssize_t at = 0; at < sealed; at++) {
        size = (size_t)sealed;
        vt_assert_ok(vor_blob_unseal(bytes, &size, "input", &vt_err));
        ck_assert_uint_eq(size, 9);
        size = (size_t)sealed;
        bytes[at] ^= 1;
        vt_assert_fails(VOR_E_DAMAGED, vor_blob_unseal(bytes, &size, "input", &vt_err));
        ck_assert_ptr_nonnull(strstr(vt_err.message, "the stored file input is damaged"));
        bytes[at] ^= 1;
    }
    size = 9; /* without a seal */
    vt_assert_fails(VOR_E_DAMAGED, vor_blob_unseal(bytes, &size, "input", &vt_err));
    vor_blob_discard(writer);
    vor_blobs_close(blobs);
}

VT_TEST(a_job_whose_input_is_damaged_fails_for_that)
{
    struct vt_daemon_options options = {.jobs = 1};
    struct vor_spec endless = vt_request(300, 10000), spec = vt_request(20, 1);
    const char *dir = vt_dir_make();
    struct vor_uuid blocker, id;
    struct vor_job_view view;
    struct vt_daemon daemon;
    char path[512];

    vt_daemon_start(&daemon, dir, &options);
    blocker = vt_daemon_submit_sphere(&daemon, 200, &endless);
    id = vt_daemon_submit_sphere(&daemon, 200, &spec);
    (void)snprintf(path, sizeof path, "%s/blobs/keep/%s.input", dir, id.text);
    flip_at(path, 1000);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &blocker, "off", &vt_err), VOR_DONE);
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert_int_eq(view.status, VOR_JOB_FAILED);
    ck_assert_int_eq(view.problem.status, VOR_E_DAMAGED);
    ck_assert_ptr_nonnull(strstr(view.message, "the stored file input is damaged"));
    vt_daemon_stop(&daemon);
}

/* Counts how often it is woken. */
static atomic_int woken;

static void wake(void *ctx)
{
    (void)ctx;
    atomic_fetch_add(&woken, 1);
}

/* Asks until there is a verdict. */
static enum vor_verdict verdict_of(struct vor_verify *verify, const char *path, uint64_t size,
                                   const char *sha256)
{
    const struct vor_asker asker = {.wake = wake};
    int fd = open(path, O_RDONLY), before = atomic_load(&woken);
    enum vor_verdict verdict = vor_verify_ask(verify, fd, size, sha256, &asker);

    if (verdict == VOR_VERDICT_WAIT) {
        while (atomic_load(&woken) == before)
            vt_nap();
        verdict = vor_verify_ask(verify, fd, size, sha256, &asker);
    }
    close(fd);
    return verdict;
}

VT_TEST(a_file_is_read_once_and_again_when_it_changed)
{
    static const char sha256[] = "51c1d66e5b5d052e71457ea002b13b57af45e639e35092b4874e0591b30f05d4";
    const char *dir = vt_dir_make();
    struct vor_verify *verify = NULL;
    char path[512];
    FILE *file;

    vt_assert_ok(vor_verify_create(&verify, NULL, &vt_err));
    (void)snprintf(path, sizeof path, "%s/file", dir);
    file = fopen(path, "w");
    fputs("the cloud and a trailer", file);
    fclose(file);
    ck_assert_int_eq(verdict_of(verify, path, 9, sha256), VOR_VERDICT_SOUND);
    ck_assert_int_eq(atomic_load(&woken), 1);
    ck_assert_int_eq(verdict_of(verify, path, 9, sha256), VOR_VERDICT_SOUND);
    ck_assert_int_eq(atomic_load(&woken), 1);
    ck_assert_int_eq(verdict_of(verify, path, 8, sha256), VOR_VERDICT_DAMAGED);
    ck_assert_int_eq(verdict_of(verify, path, 99, sha256), VOR_VERDICT_DAMAGED); /* too short */
    ck_assert_int_eq(verdict_of(verify, path, 8, "ab"), VOR_VERDICT_SOUND);      /* no digest */
    vt_nap(); /* the date is another one */
    vt_nap();
    flip_at(path, 3);
    ck_assert_int_eq(verdict_of(verify, path, 9, sha256), VOR_VERDICT_DAMAGED);
    vor_verify_destroy(verify);
}

VT_LOG(VOR_LOG_OFF)
