/* What a flipped bit does: to the log of the table of jobs, to inputs, to results. Nothing is swept
 * away, and no wrong byte is taken for a right one. */
#include "server/base/clock.h"
#include "server/store/sqlite_wal.h"
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

static off_t size_of(const char *path)
{
    struct stat info;

    ck_assert_int_eq(stat(path, &info), 0);
    return info.st_size;
}

/* --- the log ---------------------------------------------------------------------------------- */

enum { ROWS = 12 };

struct life {
    const char *dir;
    char database[512], log[512], middle[512];
    struct vor_job_view row[ROWS];
};

/* Successful jobs with a result each; then a kill, so that the log stays. The file "middle" is as
 * long as the log was behind half of them. */
static void live_and_die(void *ctx)
{
    struct life *life = ctx;
    struct vor_blobs *blobs = vt_dir_blobs(life->dir);
    struct vor_store *store = vt_dir_store(life->dir);

    for (int i = 0; i < ROWS; i++) {
        struct vor_job_view *row = &life->row[i];
        int changed, middle = i == ROWS / 2 ? creat(life->middle, 0600) : -1;

        if (middle >= 0)
            ck_assert_int_eq(ftruncate(middle, size_of(life->log)), 0);
        vt_blob_put(blobs, &row->id, "cloud", "result");
        vt_assert_ok(vor_store_insert(store, row, NULL, &vt_err));
        row->status = VOR_JOB_SUCCESSFUL;
        row->finished = vor_clock_wall_ms();
        row->expires = row->finished + 1000000;
        vt_assert_ok(vor_store_finish(store, row, NULL, NULL, &changed, &vt_err));
    }
    raise(SIGKILL);
}

static struct life dead_life(void)
{
    struct life life = {.dir = vt_dir_make()};

    (void)snprintf(life.database, sizeof life.database, "%s/jobs.sqlite", life.dir);
    (void)snprintf(life.log, sizeof life.log, "%s/jobs.sqlite-wal", life.dir);
    (void)snprintf(life.middle, sizeof life.middle, "%s/middle", life.dir);
    for (int i = 0; i < ROWS; i++)
        life.row[i] = vt_row(10);
    vt_killed(live_and_die, &life);
    return life;
}

VT_TEST(a_log_is_damaged_by_any_flipped_bit_and_by_nothing_else)
{
    struct life life = dead_life();
    off_t size = size_of(life.log);

    ck_assert_int_gt(size, 20000);
    ck_assert(!vor_sqlite_wal_is_damaged(life.database));
    for (off_t at = 0; at < size; at += 97) {
        flip_at(life.log, at);
        ck_assert_msg(vor_sqlite_wal_is_damaged(life.database), "byte %ld", (long)at);
        flip_at(life.log, at);
    }
    ck_assert(!vor_sqlite_wal_is_damaged(life.database));
    vor_store_close(vt_dir_store(life.dir)); /* which empties the log */
    ck_assert(!vor_sqlite_wal_is_damaged(life.database));
}

/* Appends a frame of this round, or of an earlier one, whose page is not what its head says. */
static void tear(const char *log, int is_of_round, int ends_a_change)
{
    uint8_t head[32], frame[24 + 4096] = {0};
    FILE *file = fopen(log, "r+be");

    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fread(head, 1, sizeof head, file), sizeof head);
    ck_assert_int_eq(head[10] << 8 | head[11], 4096); /* its pages */
    frame[3] = 2;
    frame[7] = ends_a_change ? 9 : 0;
    memcpy(frame + 8, head + 16, 8);
    frame[8] ^= is_of_round ? 0 : 1;
    frame[12] ^= is_of_round ? 0 : 1;
    ck_assert_int_eq(fseek(file, 0, SEEK_END), 0);
    ck_assert_uint_eq(fwrite(frame, 1, sizeof frame, file), sizeof frame);
    ck_assert_int_eq(fclose(file), 0);
}

/* Regression: one kill of a thousand had the bytes of an upload that nobody was told of set aside,
 * with a warning that rows were lost. */
VT_TEST(a_change_that_a_kill_cut_short_is_no_damage)
{
    static const struct {
        int is_of_round[2], ends_a_change, is_damaged;
    } cases[] = {{{1, 0}, 0, 0}, {{1, 0}, 1, 1}, {{1, 1}, 0, 1}, {{0, 1}, 0, 1}, {{0, 0}, 1, 0}};
    struct life life = dead_life();
    off_t size = size_of(life.log);

    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        tear(life.log, cases[i].is_of_round[0], cases[i].ends_a_change);
        tear(life.log, cases[i].is_of_round[1], 0);
        ck_assert_msg(vor_sqlite_wal_is_damaged(life.database) == cases[i].is_damaged, "case %zu",
                      i);
        ck_assert_int_eq(truncate(life.log, size), 0);
    }
}

static size_t rows_left(struct vt_daemon *daemon, const struct life *life)
{
    struct vor_job_view row;
    size_t left = 0;
    int found;

    for (int i = 0; i < ROWS; i++) {
        vt_assert_ok(vor_store_get(daemon->store, &life->row[i].id, NULL, &row, &found, &vt_err));
        left += found && row.status == VOR_JOB_SUCCESSFUL;
    }
    return left;
}

/* Regression: the results of jobs whose rows were behind the damage were removed as strays. */
VT_TEST(results_whose_rows_are_lost_are_set_aside)
{
    struct life life = dead_life();
    struct vt_daemon daemon;
    off_t middle = size_of(life.middle);
    size_t left;

    flip_at(life.log, middle + 40);
    vt_daemon_start(&daemon, life.dir, NULL);
    left = rows_left(&daemon, &life);
    ck_assert_uint_lt(left, ROWS);
    while (vt_dir_count(life.dir, "blobs/lost") != (int)(ROWS - left))
        vt_nap();
    ck_assert_int_eq(vt_dir_count(life.dir, "blobs/keep"), (int)left);
    vt_daemon_stop(&daemon);
}

/* The table was replaced by an older one, or by none: its log tells nothing. */
VT_TEST(more_results_without_rows_than_a_crash_leaves_are_set_aside_as_well)
{
    struct life life = dead_life();
    struct vt_daemon daemon;

    ck_assert_int_eq(unlink(life.database), 0);
    ck_assert_int_eq(unlink(life.log), 0);
    vt_daemon_start(&daemon, life.dir, NULL);
    while (vt_dir_count(life.dir, "blobs/lost") != ROWS)
        vt_nap();
    vt_daemon_stop(&daemon);
}

VT_TEST(lost_bytes_are_bounded_by_age_and_size)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    int64_t hour = 3600000, now = vor_clock_wall_ms();
    struct vor_lost_bounds bounds = {.oldest_ms = now - hour, .bytes = 100};
    struct vor_uuid id[3];
    char path[512];
    struct stat info;

    vt_assert_ok(vor_blobs_trim_lost(blobs, &bounds, &vt_err)); /* there is none yet */
    for (int i = 0; i < 3; i++) {
        struct timespec since[2] = {{.tv_sec = now / 1000 - 60 * (3 - i)}};

        since[1] = since[0];
        vt_assert_ok(vor_uuid_make(&id[i], &vt_err));
        vt_blob_put(blobs, &id[i], "x", "0123456789");
        vt_assert_ok(vor_blob_set_aside(blobs, &id[i], "x", &vt_err));
        (void)snprintf(path, sizeof path, "%s/blobs/lost/%s.x", dir, id[i].text);
        ck_assert_int_eq(utimensat(AT_FDCWD, path, since, 0), 0);
    }
    vt_assert_ok(vor_blobs_trim_lost(blobs, &bounds, &vt_err));
    ck_assert_int_eq(vt_dir_count(dir, "blobs/lost"), 3);
    bounds.bytes = 20;
    bounds.shift_ms = hour; /* the clock was set forward: ages stay as they are */
    vt_assert_ok(vor_blobs_trim_lost(blobs, &bounds, &vt_err));
    ck_assert_int_eq(vt_dir_count(dir, "blobs/lost"), 2); /* the oldest went */
    ck_assert_int_eq(stat(path, &info), 0);
    ck_assert_int_ge(info.st_mtim.tv_sec * 1000, now + hour - 61000);
    bounds.oldest_ms = now + 2 * hour;
    vt_assert_ok(vor_blobs_trim_lost(blobs, &bounds, &vt_err));
    ck_assert_int_eq(vt_dir_count(dir, "blobs/lost"), 0);
    vor_blobs_close(blobs);
}

/* --- the bytes -------------------------------------------------------------------------------- */

VT_TEST(a_seal_tells_every_flipped_bit_of_what_it_seals)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_writer *writer = vt_upload(blobs, "the bytes", 9);
    uint8_t bytes[256];
    ssize_t sealed;
    size_t size;

    vt_assert_ok(vor_blob_seal(writer, &vt_err));
    sealed = pread(vor_blob_fd(writer), bytes, sizeof bytes, 0);
    for (ssize_t at = 0; at < 9; at++) {
        size = (size_t)sealed;
        vt_assert_ok(vor_blob_unseal(bytes, &size, "input", &vt_err));
        ck_assert_uint_eq(size, 9);
        size = (size_t)sealed;
        bytes[at] ^= 1;
        vt_assert_fails(VOR_E_DAMAGED, vor_blob_unseal(bytes, &size, "input", &vt_err));
        ck_assert_ptr_nonnull(strstr(vt_err.message, "the stored file input is damaged"));
        bytes[at] ^= 1;
    }
    size = 9; /* without a seal, as it was written before there were any */
    vt_assert_ok(vor_blob_unseal(bytes, &size, "input", &vt_err));
    ck_assert_uint_eq(size, 9);
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
    ck_assert_int_eq(vor_worker_cancel(daemon.worker, &blocker, "off", &vt_err), VOR_DONE);
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
