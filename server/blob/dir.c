/* Blobs in a directory: PATH/keep/ID.KIND, unfinished ones in PATH/tmp, and PATH/lock, which says
 * that nobody else writes here, so that whatever is in tmp at the start is rubbish. */
#include "server/blob/blob.h"

#include "server/base/disk.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

struct vor_blobs {
    int lock, keep, tmp; /* file descriptors */
};

/* "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11.input" */
enum { NAME_SIZE = 48, ID_LENGTH = 36 };

struct vor_blob_writer {
    struct vor_blobs *blobs;
    int fd;
    char name[NAME_SIZE]; /* in tmp */
    uint64_t size;
    struct vor_digest *digest;
    struct vor_error failure; /* the first one; status VOR_OK when there was none */
};

static const char *const suffixes[VOR_BLOB_KINDS] = {
#define SUFFIX_ROW(name, suffix) suffix,
    VOR_BLOB_TABLE(SUFFIX_ROW)
#undef SUFFIX_ROW
};

static void blob_name(char out[NAME_SIZE], const struct vor_uuid *id, enum vor_blob_kind kind)
{
    (void)snprintf(out, NAME_SIZE, "%s.%s", id->text, suffixes[kind]);
}

/* False when a file's name is not that of a blob. */
static int parse_name(struct vor_uuid *id, enum vor_blob_kind *kind, const char *name)
{
    size_t length = strlen(name);

    if (length <= ID_LENGTH || name[ID_LENGTH] != '.' || !vor_uuid_parse(id, name, ID_LENGTH))
        return 0;
    for (int i = 0; i < VOR_BLOB_KINDS; i++) {
        *kind = (enum vor_blob_kind)i;
        if (strcmp(name + ID_LENGTH + 1, suffixes[i]) == 0)
            return 1;
    }
    return 0;
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
        (void)vor_fail_errno(err, errno, full);
    return fd;
}

static int is_dots(const char *name)
{
    return strcmp(name, ".") == 0 || strcmp(name, "..") == 0;
}

/* Calls visit for every name in a directory. */
static vor_status each_name(int directory, void (*visit)(void *ctx, const char *name), void *ctx,
                            struct vor_error *err)
{
    int fd = openat(directory, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *stream = fd >= 0 ? fdopendir(fd) : NULL;
    struct dirent *entry;

    if (stream == NULL) {
        int number = errno;

        if (fd >= 0)
            close(fd);
        return vor_fail_errno(err, number, "the blob directory");
    }
    while ((errno = 0, entry = readdir(stream)) != NULL)
        if (!is_dots(entry->d_name))
            visit(ctx, entry->d_name);
    closedir(stream);
    return VOR_OK;
}

static void unlink_tmp(void *ctx, const char *name)
{
    (void)unlinkat(((struct vor_blobs *)ctx)->tmp, name, 0);
}

static vor_status open_parts(struct vor_blobs *blobs, const char *path, long *holder,
                             struct vor_error *err)
{
    char lock[4096];
    vor_status status;

    blobs->keep = open_directory(path, "keep", err);
    blobs->tmp = blobs->keep >= 0 ? open_directory(path, "tmp", err) : -1;
    if (blobs->tmp < 0)
        return VOR_E_IO;
    (void)snprintf(lock, sizeof lock, "%s/lock", path);
    status = vor_storage_lock(&blobs->lock, lock, holder, err);
    if (status != VOR_OK)
        return status;
    return each_name(blobs->tmp, unlink_tmp, blobs, err);
}

vor_status vor_blobs_open(struct vor_blobs **out, const char *where, long *holder,
                          struct vor_error *err)
{
    struct vor_blobs *blobs;
    vor_status status;

    *holder = 0;
    if (strncmp(where, "dir:", 4) != 0 || where[4] == '\0')
        return vor_fail_param(err, VOR_E_PARAM, "blobs", "blobs is \"%.80s\", want dir:PATH",
                              where);
    blobs = malloc(sizeof *blobs);
    if (blobs == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the blobs of %.80s", where);
    *blobs = (struct vor_blobs){.lock = -1, .keep = -1, .tmp = -1};
    status = open_parts(blobs, where + 4, holder, err);
    if (status != VOR_OK) {
        vor_blobs_close(blobs);
        return status;
    }
    *out = blobs;
    return VOR_OK;
}

void vor_blobs_close(struct vor_blobs *blobs)
{
    if (blobs == NULL)
        return;
    if (blobs->keep >= 0)
        close(blobs->keep);
    if (blobs->tmp >= 0)
        close(blobs->tmp);
    if (blobs->lock >= 0)
        close(blobs->lock);
    free(blobs);
}

vor_status vor_blobs_space(struct vor_blobs *blobs, uint64_t *available, uint64_t *total,
                           struct vor_error *err)
{
    struct statvfs disk;

    if (fstatvfs(blobs->keep, &disk) != 0)
        return vor_fail_errno(err, errno, "the blob directory");
    *available = (uint64_t)disk.f_bavail * disk.f_frsize;
    *total = (uint64_t)disk.f_blocks * disk.f_frsize;
    return VOR_OK;
}

vor_status vor_blob_create(struct vor_blobs *blobs, struct vor_blob_writer **out,
                           struct vor_error *err)
{
    struct vor_blob_writer *writer = calloc(1, sizeof *writer);
    struct vor_uuid id;
    vor_status status;

    if (writer == NULL || (writer->digest = vor_digest_create()) == NULL) {
        free(writer);
        return vor_fail(err, VOR_E_NOMEM, "a temporary file");
    }
    writer->blobs = blobs;
    writer->fd = -1;
    status = vor_uuid_make(&id, err);
    if (status == VOR_OK) {
        (void)snprintf(writer->name, sizeof writer->name, "%s", id.text);
        writer->fd = openat(blobs->tmp, writer->name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
        if (writer->fd < 0)
            status = vor_fail_errno(err, errno, "a temporary file");
    }
    if (status != VOR_OK) {
        vor_blob_discard(writer);
        return status;
    }
    *out = writer;
    return VOR_OK;
}

vor_status vor_blob_append(struct vor_blob_writer *writer, const void *bytes, size_t size,
                           struct vor_error *err)
{
    const char *at = bytes;
    size_t left = size;

    while (writer->failure.status == VOR_OK && left > 0) {
        ssize_t wrote = write(writer->fd, at, left);

        if (wrote < 0 && errno != EINTR)
            (void)vor_fail_errno(&writer->failure, errno, "a temporary file");
        if (wrote <= 0)
            continue;
        at += wrote;
        left -= (size_t)wrote;
    }
    if (writer->failure.status != VOR_OK)
        return vor_blob_failure(writer, err);
    vor_digest_update(writer->digest, bytes, size);
    writer->size += size;
    return VOR_OK;
}

static int sink_write(void *ctx, const void *bytes, size_t size)
{
    return vor_blob_append(ctx, bytes, size, NULL) == VOR_OK ? 0 : -1;
}

struct vor_sink vor_blob_sink(struct vor_blob_writer *writer)
{
    return (struct vor_sink){.ctx = writer, .write = sink_write};
}

vor_status vor_blob_failure(const struct vor_blob_writer *writer, struct vor_error *err)
{
    if (err != NULL && writer->failure.status != VOR_OK)
        *err = writer->failure;
    return writer->failure.status;
}

uint64_t vor_blob_size(const struct vor_blob_writer *writer)
{
    return writer->size;
}

void vor_blob_sha256(const struct vor_blob_writer *writer, char out[VOR_DIGEST_SIZE])
{
    vor_digest_hex(writer->digest, out);
}

int vor_blob_fd(const struct vor_blob_writer *writer)
{
    return writer->fd;
}

vor_status vor_blob_commit(struct vor_blob_writer *writer, const struct vor_uuid *id,
                           enum vor_blob_kind kind, struct vor_error *err)
{
    struct vor_blobs *blobs = writer->blobs;
    vor_status status = vor_blob_failure(writer, err);
    char name[NAME_SIZE];

    blob_name(name, id, kind);
    if (status == VOR_OK && fsync(writer->fd) != 0)
        status = vor_fail_errno(err, errno, "making a blob durable");
    if (status == VOR_OK && renameat(blobs->tmp, writer->name, blobs->keep, name) != 0)
        status = vor_fail_errno(err, errno, "naming a blob");
    if (status != VOR_OK) {
        vor_blob_discard(writer);
        return status;
    }
    if (fsync(blobs->keep) != 0) {
        status = vor_fail_errno(err, errno, "making a blob's name durable");
        (void)unlinkat(blobs->keep, name, 0);
    }
    writer->name[0] = '\0';
    vor_blob_discard(writer);
    return status;
}

void vor_blob_discard(struct vor_blob_writer *writer)
{
    if (writer == NULL)
        return;
    if (writer->fd >= 0) {
        if (writer->name[0] != '\0')
            (void)unlinkat(writer->blobs->tmp, writer->name, 0);
        close(writer->fd);
    }
    vor_digest_destroy(writer->digest);
    free(writer);
}

vor_status vor_blob_get(struct vor_blobs *blobs, const struct vor_uuid *id, enum vor_blob_kind kind,
                        int *fd, uint64_t *size, int *found, struct vor_error *err)
{
    char name[NAME_SIZE];
    struct stat info;
    int file;

    *fd = -1;
    *size = 0;
    *found = 0;
    blob_name(name, id, kind);
    file = openat(blobs->keep, name, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return errno == ENOENT ? VOR_OK : vor_fail_errno(err, errno, name);
    if (fstat(file, &info) != 0) {
        vor_status status = vor_fail_errno(err, errno, name);

        close(file);
        return status;
    }
    *fd = file;
    *size = (uint64_t)info.st_size;
    *found = 1;
    return VOR_OK;
}

vor_status vor_blob_drop(struct vor_blobs *blobs, const struct vor_uuid *id,
                         enum vor_blob_kind kind, struct vor_error *err)
{
    char name[NAME_SIZE];

    blob_name(name, id, kind);
    if (unlinkat(blobs->keep, name, 0) != 0 && errno != ENOENT)
        return vor_fail_errno(err, errno, name);
    return VOR_OK;
}

struct sweep {
    struct vor_blobs *blobs;
    int (*keep)(void *ctx, const struct vor_uuid *id, enum vor_blob_kind kind);
    void *ctx;
    size_t dropped;
};

static void sweep_one(void *ctx, const char *name)
{
    struct sweep *sweep = ctx;
    enum vor_blob_kind kind;
    struct vor_uuid id;

    if (parse_name(&id, &kind, name) && sweep->keep(sweep->ctx, &id, kind))
        return;
    if (unlinkat(sweep->blobs->keep, name, 0) == 0)
        sweep->dropped++;
}

vor_status vor_blobs_sweep(struct vor_blobs *blobs,
                           int (*keep)(void *ctx, const struct vor_uuid *id,
                                       enum vor_blob_kind kind),
                           void *ctx, size_t *dropped, struct vor_error *err)
{
    struct sweep sweep = {.blobs = blobs, .keep = keep, .ctx = ctx};
    vor_status status = each_name(blobs->keep, sweep_one, &sweep, err);

    *dropped = sweep.dropped;
    return status;
}
