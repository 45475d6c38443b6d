#define _GNU_SOURCE /* fallocate */

#include "server/base/reserve.h"

#include "server/base/disk.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

struct vor_reserve {
    pthread_mutex_t mutex; /* changes of what follows; who only looks does not wait for them */
    char *path;
    _Atomic uint64_t wanted, held; /* bytes */
};

/* Bytes of the disk that a file has: none where it is sparse. */
static uint64_t room_in(const struct stat *file)
{
    uint64_t size = (uint64_t)file->st_size, blocks = (uint64_t)file->st_blocks * 512;

    return size < blocks ? size : blocks;
}

vor_status vor_reserve_open(struct vor_reserve **out, const char *path, struct vor_error *err)
{
    struct vor_reserve *reserve = calloc(1, sizeof *reserve);
    struct stat info;

    if (reserve == NULL || (reserve->path = strdup(path)) == NULL) {
        free(reserve);
        return vor_fail(err, VOR_E_NOMEM, "opening the job store");
    }
    pthread_mutex_init(&reserve->mutex, NULL);
    if (stat(path, &info) == 0)
        reserve->held = room_in(&info);
    *out = reserve;
    return VOR_OK;
}

/* Where the file system cannot allocate, it is given bytes that it cannot leave out. */
static int fill(int fd, uint64_t bytes)
{
    char block[1 << 16];

    memset(block, 0xa5, sizeof block);
    for (uint64_t at = 0; at < bytes;) {
        size_t left = bytes - at < sizeof block ? (size_t)(bytes - at) : sizeof block;
        ssize_t wrote = write(fd, block, left);

        if (wrote < 0 && errno != EINTR)
            return -1;
        at += wrote > 0 ? (uint64_t)wrote : 0;
    }
    return 0;
}

/* Gives up what is beyond so many bytes; false when that fails, and the file is none any more. The
 * mutex is held. */
static int cut(struct vor_reserve *reserve, uint64_t bytes)
{
    int failed = bytes > 0 ? truncate(reserve->path, (off_t)bytes) : unlink(reserve->path);

    reserve->held = failed ? 0 : bytes;
    return !failed;
}

/* Makes the file if as much as `free` bytes are, with those that it has; 0, or an errno. The mutex
 * is held. */
static int make_file(struct vor_reserve *reserve, uint64_t free)
{
    int fd = open(reserve->path, O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
    struct statvfs disk;
    struct stat file;
    int failed;

    if (fd < 0)
        return errno;
    if (fstat(fd, &file) != 0 || fstatvfs(fd, &disk) != 0) {
        failed = errno;
        close(fd);
        return failed;
    }
    if (reserve->held > room_in(&file)) /* others took from it */
        reserve->held = room_in(&file);
    failed = (uint64_t)disk.f_bavail * disk.f_frsize + reserve->held < free ? ENOSPC : 0;
    if (!failed)
        failed = (fallocate(fd, 0, 0, (off_t)reserve->wanted) != 0 &&
                  (errno != EOPNOTSUPP || fill(fd, reserve->wanted) != 0))
                     ? errno
                     : 0;
    close(fd);
    (void)cut(reserve, failed ? reserve->held : reserve->wanted);
    return failed;
}

/* Bytes that SQLite takes to open a file that was closed in order: 32 KiB of memory that
 * connections share and the head of the log, with some more. */
static const uint64_t least = 64 << 10;

/* What is left to the next opening; of a large reserve a part in which the log has room for the
 * first rows that go, and of a small one no more than half. */
static uint64_t opening_bytes(uint64_t wanted)
{
    uint64_t part = wanted / 16 > least ? wanted / 16 : least;

    return part < wanted / 2 ? part : wanted / 2;
}

/* Gives up a half: others may take what is left over, and then there is room for another change.
 * True when there was any. */
static int spend(struct vor_reserve *reserve, int is_opening)
{
    uint64_t half, kept;
    int had;

    if (reserve == NULL)
        return 0;
    pthread_mutex_lock(&reserve->mutex);
    half = reserve->held > least ? reserve->held / 2 : 0;
    kept = is_opening ? 0 : opening_bytes(reserve->wanted);
    kept = half > kept ? half : kept;
    had = reserve->held > kept && cut(reserve, kept);
    pthread_mutex_unlock(&reserve->mutex);
    return had;
}

void vor_reserve_close(struct vor_reserve *reserve)
{
    if (reserve == NULL)
        return;
    reserve->wanted = opening_bytes(reserve->wanted);
    if (reserve->held < reserve->wanted)
        (void)make_file(reserve, reserve->wanted);
    pthread_mutex_destroy(&reserve->mutex);
    free(reserve->path);
    free(reserve);
}

void vor_reserve_want(struct vor_reserve *reserve, uint64_t bytes)
{
    pthread_mutex_lock(&reserve->mutex);
    reserve->wanted = bytes;
    if (bytes == 0)
        (void)cut(reserve, 0);
    else if (reserve->held != bytes)
        (void)make_file(reserve, bytes); /* vor_reserve_check tells */
    pthread_mutex_unlock(&reserve->mutex);
}

static vor_status fail_missing(const struct vor_reserve *reserve, int number, struct vor_error *err)
{
    (void)vor_fail(err, VOR_E_IO, "the disk is full: the reserve of %llu bytes is used up",
                   (unsigned long long)atomic_load(&reserve->wanted));
    if (err != NULL)
        err->got = (uint64_t)number;
    return VOR_E_IO;
}

vor_status vor_reserve_make(struct vor_reserve *reserve, struct vor_error *err)
{
    vor_status status = VOR_OK;
    int failed = 0;

    pthread_mutex_lock(&reserve->mutex);
    if (reserve->held != reserve->wanted)
        failed = make_file(reserve, 2 * reserve->wanted);
    if (failed)
        status = failed == ENOSPC || failed == EDQUOT ? fail_missing(reserve, failed, err)
                                                      : vor_fail_errno(err, failed, reserve->path);
    pthread_mutex_unlock(&reserve->mutex);
    return status;
}

vor_status vor_reserve_check(struct vor_reserve *reserve, struct vor_error *err)
{
    if (reserve == NULL || atomic_load(&reserve->held) >= atomic_load(&reserve->wanted))
        return VOR_OK;
    return fail_missing(reserve, ENOSPC, err);
}

int vor_reserve_made_room(struct vor_reserve *reserve, int is_opening, vor_status status,
                          const struct vor_error *err)
{
    return status != VOR_OK && vor_error_storage_full(err) && spend(reserve, is_opening);
}
