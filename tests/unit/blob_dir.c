/* Blobs in a folder: nothing until committed; what a crash leaves is swept. */
#include "server/base/disk.h"
#include "server/blob/blob.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

VT_TEST(a_discarded_blob_leaves_nothing)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_writer *writer = vt_upload(blobs, "abc", 3);

    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 1);
    vor_blob_discard(writer);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 0);
    vor_blob_discard(NULL);
    vor_blobs_close(blobs);
}

struct crash {
    const char *dir;
    struct vor_uuid id;
};

static void die_writing(void *ctx)
{
    struct crash *crash = ctx;
    struct vor_blobs *blobs = vt_dir_blobs(crash->dir);

    (void)vt_upload(blobs, "half of i", 9);
    raise(SIGKILL);
}

VT_TEST(what_a_killed_writer_left_is_gone_after_the_next_start)
{
    struct crash crash = {.dir = vt_dir_make(), .id = vt_row(1).id};
    struct vor_blobs *blobs;

    vt_killed(die_writing, &crash);
    ck_assert_int_eq(vt_dir_count(crash.dir, "blobs/tmp"), 1);
    blobs = vt_dir_blobs(crash.dir);
    ck_assert_int_eq(vt_dir_count(crash.dir, "blobs/tmp"), 0);
    ck_assert_str_eq(vt_blob_text(blobs, &crash.id, "input"), "");
    vor_blobs_close(blobs);
}

VT_TEST(an_opening_drops_what_is_no_blob)
{
    static const char *const rubbish[] = {"rubbish", "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11",
                                          "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11.",
                                          "0193B5F2-7c1e-7f7a-9d3e-2a6c1f0b8e11.input"};
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_uuid one = vt_row(1).id;
    char path[512];

    vt_blob_put(blobs, &one, "input", "a");
    vor_blob_discard(vt_upload(blobs, "d", 1));
    for (size_t i = 0; i < sizeof rubbish / sizeof rubbish[0]; i++) {
        (void)snprintf(path, sizeof path, "%s/blobs/keep/%s", dir, rubbish[i]);
        close(open(path, O_CREAT | O_WRONLY, 0600));
    }
    vor_blobs_close(blobs);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 5);
    blobs = vt_dir_blobs(dir);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 1);
    ck_assert_str_eq(vt_blob_text(blobs, &one, "input"), "a");
    vor_blobs_close(blobs);
}

/* Refusal: the first failure sticks, the codec's sink reports it, a commit repeats it. */
VT_TEST(a_writer_that_failed_cannot_be_committed)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_writer *writer = vt_upload(blobs, "abc", 3);
    struct vor_sink sink = vor_blob_sink(writer);
    struct rlimit limit = {.rlim_cur = 8, .rlim_max = RLIM_INFINITY};
    struct vor_uuid id = vt_row(1).id;

    vt_assert_ok(vor_blob_failure(writer, &vt_err));
    signal(SIGXFSZ, SIG_IGN);
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = 8;
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    ck_assert_int_lt(sink.write(sink.ctx, "0123456789", 10), 0);
    vt_assert_fails(VOR_E_IO, vor_blob_append(writer, "x", 1, &vt_err));
    ck_assert_uint_eq(vt_err.got, EFBIG);
    ck_assert(!vor_error_storage_full(&vt_err));
    vt_assert_fails(VOR_E_IO, vor_blob_commit(writer, &id, "cloud", &vt_err));
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    ck_assert_str_eq(vt_blob_text(blobs, &id, "cloud"), "");
    limit.rlim_cur = limit.rlim_max;
    (void)setrlimit(RLIMIT_FSIZE, &limit);
    vor_blobs_close(blobs);
}

VT_TEST(a_second_opener_and_a_wrong_name_are_refused)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir), *second = NULL;
    char where[512];
    long holder;

    (void)snprintf(where, sizeof where, "dir:%s/blobs", dir);
    vt_assert_fails(VOR_E_IO, vor_blobs_open(&second, where, NULL, &holder, &vt_err));
    ck_assert_int_eq(holder, getpid());
    vt_assert_fails(VOR_E_IO, vor_blobs_open(&second, where + 4, NULL, &holder, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "blobs");
    vt_assert_fails(VOR_E_IO, vor_blobs_open(&second, "dir:", NULL, &holder, &vt_err));
    ck_assert_str_eq(vt_err.message, "blobs is \"dir:\", want dir:PATH or "
                                     "s3:https://HOST/BUCKET/PREFIX or postgres:URI");
    vt_assert_fails(VOR_E_IO, vor_blobs_open(&second, "dir:/dev/null/x", NULL, &holder, &vt_err));
    ck_assert_int_eq(holder, 0);
    ck_assert_ptr_null(second);
    vor_blobs_close(blobs);
}

VT_TEST(the_bytes_of_all_blobs_and_of_the_disk_are_known)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_uuid id = vt_row(1).id, other = vt_row(1).id;
    uint64_t available = 0, total = 0;

    vt_assert_ok(vor_blobs_space(blobs, &available, &total, &vt_err));
    ck_assert_uint_gt(total, 0);
    ck_assert_uint_le(available, total);
    ck_assert_uint_eq(vor_blobs_bytes(blobs), 0);
    vor_blob_discard(vt_upload(blobs, "discarded", 9));
    vt_blob_put(blobs, &id, "input", "12345");
    vt_blob_put(blobs, &id, "cloud", "1234567");
    ck_assert_uint_eq(vor_blobs_bytes(blobs), 12);
    vt_blob_put(blobs, &id, "cloud", "123"); /* in its place */
    vt_blob_put(blobs, &other, "cloud", "1");
    ck_assert_uint_eq(vor_blobs_bytes(blobs), 9);
    vt_assert_ok(vor_blob_drop(blobs, &id, "input", &vt_err));
    vt_assert_ok(vor_blob_drop(blobs, &id, "input", &vt_err)); /* which is gone */
    ck_assert_uint_eq(vor_blobs_bytes(blobs), 4);
    vt_assert_ok(vor_blob_drop(blobs, &other, "cloud", &vt_err));
    ck_assert_uint_eq(vor_blobs_bytes(blobs), 3);
    vor_blobs_close(blobs);
    blobs = vt_dir_blobs(dir);
    ck_assert_uint_eq(vor_blobs_bytes(blobs), 3);
    vor_blobs_close(blobs);
}
