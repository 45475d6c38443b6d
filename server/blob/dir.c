#define _GNU_SOURCE /* memfd_create */
#include "server/blob/dir.h"

#include "server/base/disk.h"
#include "server/blob/pieces.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

enum { ID_LENGTH = 36, FILE_SIZE = VOR_BLOB_FILE_SIZE };

struct writer {
    struct vor_blob_writer base;
    char file[FILE_SIZE]; /* in tmp; "" once it was committed, and for what is in keep already */
    char from[FILE_SIZE]; /* in keep: whose bytes these are; "" for new ones */
};

const char *vor_blob_of_file(struct vor_uuid *id, const char *file)
{
    size_t length = strlen(file);

    if (length <= ID_LENGTH + 1 || length >= FILE_SIZE || file[ID_LENGTH] != '.' ||
        !vor_uuid_parse(id, file, ID_LENGTH))
        return NULL;
    return file + ID_LENGTH + 1;
}

static int open_directory(const char *path, const char *name, struct vor_error *err)
{
    char full[4096];
    int fd;

    if ((size_t)snprintf(full, sizeof full, "%s/%s", path, name) >= sizeof full) {
        (void)vor_fail_errno(err, ENAMETOOLONG, name);
        return -1;
    }
    if (vor_storage_directory(full, err) != VOR_OK)
        return -1;
    fd = open(full, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        (void)vor_fail_access(err, errno, full);
    return fd;
}

/* Calls visit for every name in a directory. */
static vor_status each_name(int directory, void (*visit)(void *ctx, const char *name), void *ctx,
                            struct vor_error *err)
{
    int fd = openat(directory, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *stream = fd >= 0 ? fdopendir(fd) : NULL;
    struct dirent *entry;
    vor_status status;

    if (stream == NULL) {
        int number = errno;

        if (fd >= 0)
            close(fd);
        return vor_fail_errno(err, number, "the folder of stored files");
    }
    while ((errno = 0, entry = readdir(stream)) != NULL)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            visit(ctx, entry->d_name);
    status = errno == 0 ? VOR_OK : vor_fail_errno(err, errno, "the folder of stored files");
    closedir(stream);
    return status;
}

/* Leaves what another process has locked: it is being written. */
static void unlink_tmp(void *ctx, const char *name)
{
    const struct vor_blob_directory *directory = ctx;
    int fd = directory->is_shared ? openat(directory->tmp, name, O_RDWR | O_CLOEXEC) : -1;

    if (fd < 0 || flock(fd, LOCK_EX | LOCK_NB) == 0)
        (void)unlinkat(directory->tmp, name, 0);
    if (fd >= 0)
        close(fd);
}

/* Where others share the directory they add to it and take from it as well: what is told then is
 * what this process has seen. */
static void count_less(struct vor_blobs *blobs, uint64_t size)
{
    uint64_t had = atomic_load(&blobs->bytes);

    while (!atomic_compare_exchange_weak(&blobs->bytes, &had, had - (size < had ? size : had)))
        continue;
}

/* A small file that was asked for: its size, and, unless only that was, a copy in memory. */
struct small {
    uint64_t size;
    int found, fd;
    int number; /* errno, if there is no copy */
};

static void take_small(void *ctx, const void *bytes, size_t size)
{
    struct small *small = ctx;

    small->found = 1;
    small->size = size;
    if (bytes != NULL)
        small->fd = memfd_create("small", MFD_CLOEXEC);
    small->number = errno;
    if (small->fd >= 0 && pwrite(small->fd, bytes, size, 0) != (ssize_t)size) {
        small->number = errno;
        close(small->fd);
        small->fd = -1;
    }
}

/* Bytes of a file in keep; 0 when there is none. */
static uint64_t size_of(const struct vor_blob_directory *directory, const char *file)
{
    struct stat info;

    return fstatat(directory->keep, file, &info, 0) == 0 ? (uint64_t)info.st_size : 0;
}

/* Counts a blob; removes what lies among them and is none, by its name. */
static void take_in(void *ctx, const char *name)
{
    struct vor_blob_directory *directory = ctx;
    struct vor_uuid id;

    if (vor_blob_of_file(&id, name) != NULL)
        directory->base.bytes += size_of(directory, name);
    else
        (void)unlinkat(directory->keep, name, 0);
}

vor_status vor_blob_directory_open(struct vor_blob_directory *directory, const char *path,
                                   long *holder, struct vor_error *err)
{
    char lock[4096];
    vor_status status;

    directory->parent = open_directory(path, ".", err);
    directory->keep = directory->parent >= 0 ? open_directory(path, "keep", err) : -1;
    directory->tmp = directory->keep >= 0 ? open_directory(path, "tmp", err) : -1;
    if (directory->tmp < 0)
        return VOR_E_IO;
    (void)snprintf(lock, sizeof lock, "%s/lock", path);
    status = vor_storage_lock(&directory->lock, lock, directory->is_shared, holder, err);
    if (status != VOR_OK)
        return status;
    status = each_name(directory->tmp, unlink_tmp, directory, err);
    return status == VOR_OK ? each_name(directory->keep, take_in, directory, err) : status;
}

void vor_blob_directory_close(struct vor_blob_directory *directory)
{
    if (directory->parent >= 0)
        close(directory->parent);
    if (directory->keep >= 0)
        close(directory->keep);
    if (directory->tmp >= 0)
        close(directory->tmp);
    if (directory->lock >= 0)
        close(directory->lock);
}

static void close_blobs(struct vor_blobs *blobs)
{
    vor_blob_directory_close((struct vor_blob_directory *)blobs);
    free(blobs);
}

static vor_status open_blobs(struct vor_blobs **out, const char *place,
                             const struct vor_blob_cache *cache, long *holder,
                             struct vor_error *err)
{
    struct vor_blob_directory *directory = malloc(sizeof *directory);
    vor_status status;

    if (directory == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the files in %.80s", place);
    *directory = (struct vor_blob_directory){.lock = -1,
                                             .parent = -1,
                                             .keep = -1,
                                             .tmp = -1,
                                             .is_shared = cache != NULL && cache->is_shared};
    status = vor_blob_directory_open(directory, place, holder, err);
    if (status != VOR_OK) {
        vor_blob_directory_close(directory);
        free(directory);
        return status;
    }
    *out = (struct vor_blobs *)directory;
    return VOR_OK;
}

vor_status vor_blob_directory_space(struct vor_blobs *blobs, uint64_t *available, uint64_t *total,
                                    struct vor_error *err)
{
    struct statvfs disk;

    if (fstatvfs(((struct vor_blob_directory *)blobs)->keep, &disk) != 0)
        return vor_fail_errno(err, errno, "the folder of stored files");
    *available = (uint64_t)disk.f_bavail * disk.f_frsize;
    *total = (uint64_t)disk.f_blocks * disk.f_frsize;
    return VOR_OK;
}

/* Opens a file of the writer's own in tmp. */
static vor_status open_temporary(struct vor_blob_directory *directory, struct writer *writer,
                                 struct vor_error *err)
{
    struct stat info;
    struct vor_uuid id;
    vor_status status = vor_uuid_make(&id, err);
    int is_ours;

    if (status != VOR_OK)
        return status;
    do { /* another process may take it for left over before it is locked */
        writer->base.fd =
            openat(directory->tmp, id.text, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
        if (writer->base.fd < 0)
            return vor_fail_errno(err, errno, "a temporary file");
        if (!directory->is_shared)
            break;
        if (flock(writer->base.fd, LOCK_SH) != 0 || fstat(writer->base.fd, &info) != 0) {
            (void)vor_fail_errno(err, errno, "a temporary file");
            close(writer->base.fd);
            (void)unlinkat(directory->tmp, id.text, 0);
            return VOR_E_IO;
        }
        is_ours = info.st_nlink > 0;
        if (!is_ours)
            close(writer->base.fd);
    } while (!is_ours);
    (void)snprintf(writer->file, sizeof writer->file, "%s", id.text);
    return VOR_OK;
}

vor_status vor_blob_directory_create(struct vor_blobs *blobs, struct vor_blob_writer **out,
                                     struct vor_error *err)
{
    struct writer *writer = calloc(1, sizeof *writer);
    vor_status status;

    if (writer == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a temporary file");
    writer->base.fd = blobs->small != NULL ? memfd_create("small", MFD_CLOEXEC) : -1;
    writer->base.is_in_memory = writer->base.fd >= 0;
    status = writer->base.is_in_memory
                 ? VOR_OK
                 : open_temporary((struct vor_blob_directory *)blobs, writer, err);
    if (status != VOR_OK) {
        free(writer);
        return status;
    }
    *out = (struct vor_blob_writer *)writer;
    return VOR_OK;
}

/* Makes a name in keep durable, or takes it away; with the bytes, if those are another blob's,
 * whose commit may have been lazy. */
static vor_status sync_name(struct vor_blob_writer *base, const char *file, int with_bytes,
                            struct vor_error *err)
{
    struct vor_blob_directory *directory = (struct vor_blob_directory *)base->blobs;
    vor_status status;

    if (base->is_lazy || ((!with_bytes || fsync(base->fd) == 0) && fsync(directory->keep) == 0))
        return VOR_OK;
    status = vor_fail_errno(err, errno, "writing the name of a stored file to the disk");
    (void)unlinkat(directory->keep, file, 0);
    return status;
}

/* Gives a writer that reads another blob, or is in memory, a file of its own with the same bytes.
 */
static vor_status spill(struct vor_blob_writer *base, struct vor_error *err)
{
    enum { STEP = 1 << 30 }; /* bytes; one call takes somewhat fewer than 2 GiB */
    struct vor_blob_directory *directory = (struct vor_blob_directory *)base->blobs;
    struct writer *writer = (struct writer *)base;
    int from = writer->base.fd;
    off_t at = 0;
    ssize_t got;
    vor_status status = open_temporary(directory, writer, err);

    if (status != VOR_OK) {
        writer->base.fd = from;
        return status;
    }
    do
        got = sendfile(writer->base.fd, from, &at, STEP);
    while (got > 0 || (got < 0 && errno == EINTR));
    if (got < 0)
        status = vor_fail_errno(err, errno, "copying a stored file");
    close(from);
    base->is_in_memory = 0;
    return status;
}

static vor_status name_file(struct vor_blob_writer *base, const char *file, struct vor_error *err)
{
    struct vor_blob_directory *directory = (struct vor_blob_directory *)base->blobs;
    struct writer *writer = (struct writer *)base;
    vor_status status = VOR_OK;

    /* Not on every file system, and not once the other blob is dropped. */
    if (writer->from[0] != '\0' &&
        linkat(directory->keep, writer->from, directory->keep, file, 0) == 0)
        return sync_name(base, file, 1, err);
    if (writer->from[0] != '\0' || base->is_in_memory)
        status = spill(base, err);
    if (status != VOR_OK)
        return status;
    if (!base->is_lazy && fsync(base->fd) != 0)
        return vor_fail_errno(err, errno, "writing a stored file to the disk");
    if (renameat(directory->tmp, writer->file, directory->keep, file) != 0)
        return vor_fail_errno(err, errno, "naming a stored file");
    writer->file[0] = '\0';
    return sync_name(base, file, 0, err);
}

static vor_status keep_small(struct vor_blob_writer *base, const char *file, uint64_t *was,
                             struct vor_error *err)
{
    const struct vor_small_files *small = base->blobs->small;
    char bytes[VOR_SMALL_FILE_MAX];
    const struct vor_blob_patience *patience = &base->patience;
    vor_status status = vor_piece_read(base->fd, 0, bytes, (size_t)base->size, err);

    if (status != VOR_OK)
        return status;
    do
        status = small->put(small->ctx, file, bytes, (size_t)base->size, was, err);
    while (status != VOR_OK && vor_error_storage_full(err) && patience->may_wait != NULL &&
           patience->may_wait(patience->ctx, err));
    return status;
}

/* What it takes the place of may stand elsewhere. A file goes before a small one of its name. */
static vor_status commit(struct vor_blob_writer *base, const char *file, struct vor_error *err)
{
    struct vor_blob_directory *directory = (struct vor_blob_directory *)base->blobs;
    const struct vor_small_files *small = base->blobs->small;
    uint64_t before = size_of(directory, file), was = 0;
    vor_status status;

    if (small != NULL && base->size <= VOR_SMALL_FILE_MAX) {
        status = keep_small(base, file, &was, err);
        if (status == VOR_OK && before > 0)
            (void)unlinkat(directory->keep, file, 0);
    } else {
        status = name_file(base, file, err);
        if (status == VOR_OK && small != NULL)
            (void)(small->drop(small->ctx, file, &was, NULL) == VOR_OK);
    }
    if (status != VOR_OK)
        return status;
    base->blobs->bytes += base->size;
    count_less(base->blobs, before + was);
    return VOR_OK;
}

void vor_blob_directory_discard(struct vor_blob_writer *base)
{
    struct writer *writer = (struct writer *)base;

    if (writer->file[0] != '\0')
        (void)unlinkat(((struct vor_blob_directory *)base->blobs)->tmp, writer->file, 0);
    close(base->fd);
    free(writer);
}

static vor_status get_small(struct vor_blobs *blobs, const char *file, int *fd, uint64_t *size,
                            int *found, struct vor_error *err)
{
    struct small small = {.fd = -1};
    vor_status status = VOR_OK;

    if (blobs->small != NULL)
        status = blobs->small->get(blobs->small->ctx, file, fd == NULL, take_small, &small, err);
    if (status == VOR_OK && small.found && fd != NULL && small.fd < 0)
        status = vor_fail_errno(err, small.number, "a copy of a stored file in memory");
    *found = status == VOR_OK && small.found;
    *size = small.size;
    if (fd != NULL)
        *fd = small.fd;
    return status;
}

static vor_status get(struct vor_blobs *blobs, const char *file, int *fd, uint64_t *size,
                      int *found, struct vor_error *err)
{
    struct stat info;
    int keep = ((struct vor_blob_directory *)blobs)->keep, opened = -1;

    if (fd != NULL)
        opened = openat(keep, file, O_RDONLY | O_CLOEXEC);
    if ((fd != NULL && opened < 0) ||
        (fd != NULL ? fstat(opened, &info) : fstatat(keep, file, &info, 0)) != 0) {
        vor_status status = errno == ENOENT ? get_small(blobs, file, fd, size, found, err)
                                            : vor_fail_errno(err, errno, file);

        if (opened >= 0)
            close(opened);
        return status;
    }
    if (fd != NULL)
        *fd = opened;
    *size = (uint64_t)info.st_size;
    *found = 1;
    return VOR_OK;
}

static vor_status reopen(struct vor_blobs *blobs, const char *file, struct vor_blob_writer **out,
                         int *found, struct vor_error *err)
{
    struct writer *writer = calloc(1, sizeof *writer);
    vor_status status;

    if (writer == NULL)
        return vor_fail(err, VOR_E_NOMEM, "reading a file again");
    status = get(blobs, file, &writer->base.fd, &writer->base.size, found, err);
    if (status != VOR_OK || !*found) {
        free(writer);
        return status;
    }
    (void)snprintf(writer->from, sizeof writer->from, "%s", file);
    *out = (struct vor_blob_writer *)writer;
    return VOR_OK;
}

static vor_status drop(struct vor_blobs *blobs, const char *file, struct vor_error *err)
{
    uint64_t size = size_of((struct vor_blob_directory *)blobs, file), small = 0;

    if (unlinkat(((struct vor_blob_directory *)blobs)->keep, file, 0) != 0 && errno != ENOENT)
        return vor_fail_errno(err, errno, file);
    if (blobs->small != NULL && blobs->small->drop(blobs->small->ctx, file, &small, err) != VOR_OK)
        return VOR_E_IO;
    count_less(blobs, size + small);
    return VOR_OK;
}

struct naming {
    void (*each)(void *ctx, const char *file);
    void *ctx;
};

static void name_small(void *ctx, const char *name, VOR_UNUSED size_t size)
{
    ((struct naming *)ctx)->each(((struct naming *)ctx)->ctx, name);
}

static vor_status list(struct vor_blobs *blobs, void (*each)(void *ctx, const char *file),
                       void *ctx, struct vor_error *err)
{
    const struct vor_small_files *small = blobs->small;
    struct naming naming = {each, ctx};
    vor_status status = each_name(((struct vor_blob_directory *)blobs)->keep, each, ctx, err);

    return status == VOR_OK && small != NULL ? small->list(small->ctx, name_small, &naming, err)
                                             : status;
}

const struct vor_blob_driver vor_blob_dir = {
    .scheme = "dir",
    .place = "PATH",
    .open = open_blobs,
    .close = close_blobs,
    .space = vor_blob_directory_space,
    .create = vor_blob_directory_create,
    .reopen = reopen,
    .spill = spill,
    .commit = commit,
    .discard = vor_blob_directory_discard,
    .get = get,
    .drop = drop,
    .list = list,
};
