#include "server/blob/blob.h"

#include "server/base/disk.h"
#include "server/blob/dir.h"
#include "server/blob/pieces.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Bytes whose length nobody told have room kept for so many at a time. */
enum { PROMISE_STEP = 1 << 20 };

enum { DIR, S3, POSTGRES, DRIVERS };

static const struct vor_blob_driver *const drivers[] = {
    [DIR] = &vor_blob_dir, [S3] = &vor_blob_s3, [POSTGRES] = &vor_blob_postgres};

static const char *name_of(const char *prefix, const char *input, char out[VOR_BLOB_NAME_MAX + 1])
{
    int is_cloud = strcmp(input, "cloud") == 0;
    int length = snprintf(out, VOR_BLOB_NAME_MAX + 1, "%s%s%s", prefix, is_cloud ? "" : "-",
                          is_cloud ? "" : input);

    assert(length <= VOR_BLOB_NAME_MAX);
    return out;
}

const char *vor_blob_of_input(const char *input, char out[VOR_BLOB_NAME_MAX + 1])
{
    return name_of("input", input, out);
}

const char *vor_blob_of_upload(const char *input, char out[VOR_BLOB_NAME_MAX + 1])
{
    return name_of("upload", input, out);
}

int vor_blob_is_upload(const char *name)
{
    return strcmp(name, "upload") == 0 || strncmp(name, "upload-", 7) == 0;
}

const char *vor_blob_of_output(const char *output, uint32_t attempt,
                               char out[VOR_BLOB_NAME_MAX + 1])
{
    int length = attempt > 1 ? snprintf(out, VOR_BLOB_NAME_MAX + 1, "%s-try-%u", output, attempt)
                             : snprintf(out, VOR_BLOB_NAME_MAX + 1, "%s", output);

    assert(length <= VOR_BLOB_NAME_MAX);
    return out;
}

static const char *file_of(const struct vor_uuid *id, const char *name,
                           char out[VOR_BLOB_FILE_SIZE])
{
    (void)snprintf(out, VOR_BLOB_FILE_SIZE, "%s.%s", id->text, name);
    return out;
}

const char *vor_blob_of_converted(const char *output, const char *format,
                                  char out[VOR_BLOB_NAME_MAX + 1])
{
    int length = snprintf(out, VOR_BLOB_NAME_MAX + 1, "%s-as-%s", output, format);

    assert(length <= VOR_BLOB_NAME_MAX);
    return out;
}

/* --- opening ---------------------------------------------------------------------------------- */

static vor_status refuse(const char *where, struct vor_error *err)
{
    char forms[160] = "";
    size_t at = 0;

    for (unsigned i = 0; i < DRIVERS && at < sizeof forms; i++)
        at += (size_t)snprintf(forms + at, sizeof forms - at, "%s%s:%s", i > 0 ? " or " : "",
                               drivers[i]->scheme, drivers[i]->place);
    /* What follows the scheme may hold a password. */
    return vor_fail_param(err, VOR_E_IO, "blobs", "blobs is \"%.*s%s\", want %s",
                          (int)strcspn(where, ":"), where,
                          strchr(where, ':') == NULL      ? ""
                          : strchr(where, ':')[1] == '\0' ? ":"
                                                          : ":...",
                          forms);
}

vor_status vor_blobs_open(struct vor_blobs **out, const char *where,
                          const struct vor_blob_cache *cache, long *holder, struct vor_error *err)
{
    const char *place = where;
    unsigned i = POSTGRES;
    vor_status status;

    *holder = 0;
    if (strncmp(where, "postgresql://", 13) != 0) /* the other form of its URIs */
        for (i = 0; i < DRIVERS; i++)
            if ((place = vor_storage_place(where, drivers[i]->scheme)) != NULL)
                break;
    if (i == DRIVERS)
        return refuse(where, err);
    status = drivers[i]->open(out, place, cache, holder, err);
    if (status != VOR_OK)
        return status;
    (*out)->driver = drivers[i];
    (*out)->reserve = VOR_BLOBS_RESERVE;
    atomic_init(&(*out)->is_broken, 0);
    atomic_init(&(*out)->promised, 0);
    atomic_init(&(*out)->refused, 0);
    return VOR_OK;
}

static void count_small(void *ctx, VOR_UNUSED const char *name, size_t size)
{
    *(_Atomic uint64_t *)ctx += size;
}

vor_status vor_blobs_keep_small(struct vor_blobs *blobs, const struct vor_small_files *small,
                                struct vor_error *err)
{
    _Atomic uint64_t bytes = 0;
    vor_status status;

    if (small == NULL)
        return VOR_OK;
    if (blobs->driver->spill != NULL) {
        blobs->small = small;
        return small->list(small->ctx, count_small, &blobs->bytes, err);
    }
    status = small->list(small->ctx, count_small, &bytes, err);
    if (status == VOR_OK && bytes > 0)
        return vor_fail_param(
            err, VOR_E_IO, "blobs",
            "the job database has %.1f MB of files of --blobs dir: move them with "
            "voronoid migrate, or start with dir: until their jobs have expired",
            (double)bytes / 1e6);
    return status;
}

void vor_blobs_close(struct vor_blobs *blobs)
{
    if (blobs != NULL)
        blobs->driver->close(blobs);
}

vor_status vor_blobs_space(struct vor_blobs *blobs, uint64_t *available, uint64_t *total,
                           struct vor_error *err)
{
    return blobs->driver->space(blobs, available, total, err);
}

uint64_t vor_blobs_bytes(const struct vor_blobs *blobs)
{
    return atomic_load(&blobs->bytes);
}

const char *vor_blobs_scheme(const struct vor_blobs *blobs)
{
    return blobs->driver->scheme;
}

void vor_blobs_set_reserve(struct vor_blobs *blobs, uint64_t bytes)
{
    blobs->reserve = bytes;
}

static int fits(const struct vor_blobs *blobs, uint64_t bytes, uint64_t others, uint64_t available)
{
    uint64_t taken = blobs->reserve + others;

    return available >= taken && available - taken >= bytes;
}

/* Whether `bytes` fit beside what `others` were promised. */
static vor_status check_room(struct vor_blobs *blobs, uint64_t bytes, uint64_t others,
                             struct vor_error *err)
{
    uint64_t available = 0, total = 0;
    vor_status status = vor_blobs_space(blobs, &available, &total, err);

    if (status != VOR_OK || fits(blobs, bytes, others, available))
        return status;
    atomic_store(&blobs->refused, bytes > 0 ? bytes : 1);
    (void)vor_fail(err, VOR_E_IO,
                   "the disk has no room for %.1f MB: %.1f MB are free, but %.1f MB must stay "
                   "free, and %.1f MB are reserved for other files",
                   (double)bytes / 1e6, (double)available / 1e6, (double)blobs->reserve / 1e6,
                   (double)others / 1e6);
    if (err != NULL)
        err->got = ENOSPC;
    return VOR_E_IO;
}

vor_status vor_blobs_room(struct vor_blobs *blobs, uint64_t bytes, struct vor_error *err)
{
    return check_room(blobs, bytes, atomic_load(&blobs->promised), err);
}

int vor_blobs_lack_room(struct vor_blobs *blobs)
{
    uint64_t bytes = atomic_exchange(&blobs->refused, 0), available = 0, total = 0;

    return bytes > 0 && vor_blobs_space(blobs, &available, &total, NULL) == VOR_OK &&
           !fits(blobs, bytes, atomic_load(&blobs->promised), available);
}

vor_status vor_blobs_check(struct vor_blobs *blobs, struct vor_error *err)
{
    if (atomic_load(&blobs->is_broken))
        return vor_fail(err, VOR_E_IO, "the disk of --blobs failed");
    return VOR_OK;
}

vor_status vor_blobs_reach(struct vor_blobs *blobs, struct vor_error *err)
{
    return blobs->driver->reach != NULL ? blobs->driver->reach(blobs, err) : VOR_OK;
}

void vor_blobs_hurry(struct vor_blobs *blobs)
{
    if (blobs->driver->hurry != NULL)
        blobs->driver->hurry(blobs);
}

/* --- writing ---------------------------------------------------------------------------------- */

vor_status vor_blob_create(struct vor_blobs *blobs, struct vor_blob_writer **out,
                           struct vor_error *err)
{
    struct vor_blob_writer *writer = NULL;
    vor_status status = blobs->driver->create(blobs, &writer, err);

    if (status != VOR_OK)
        return status;
    writer->blobs = blobs;
    vor_digest_begin(&writer->digest);
    *out = writer;
    return VOR_OK;
}

vor_status vor_blob_reopen(struct vor_blobs *blobs, const struct vor_blob_source *from,
                           struct vor_blob_writer **out, int *found, struct vor_error *err)
{
    char file[VOR_BLOB_FILE_SIZE];
    vor_status status;

    *out = NULL;
    *found = 0;
    status = blobs->driver->reopen(blobs, file_of(&from->id, from->name, file), out, found, err);
    if (status != VOR_OK || !*found)
        return status;
    (*out)->blobs = blobs;
    (*out)->is_whole = 1;
    memcpy((*out)->sha256, from->sha256, sizeof from->sha256);
    return VOR_OK;
}

static vor_status promise(struct vor_blob_writer *writer, uint64_t bytes, struct vor_error *err)
{
    uint64_t others = atomic_fetch_add(&writer->blobs->promised, bytes);
    vor_status status = check_room(writer->blobs, bytes, others, err);

    if (status == VOR_OK)
        writer->promised += bytes;
    else
        (void)atomic_fetch_sub(&writer->blobs->promised, bytes);
    return status;
}

/* Bytes have come, or will not any more. */
static void redeem(struct vor_blob_writer *writer, uint64_t bytes)
{
    if (bytes > writer->promised)
        bytes = writer->promised;
    if (bytes == 0) /* as of a borrowed file */
        return;
    writer->promised -= bytes;
    (void)atomic_fetch_sub(&writer->blobs->promised, bytes);
}

vor_status vor_blob_promise(struct vor_blob_writer *writer, uint64_t bytes, struct vor_error *err)
{
    writer->is_promised = 1;
    return promise(writer, bytes, err);
}

void vor_blob_be_lazy(struct vor_blob_writer *writer)
{
    writer->is_lazy = 1;
}

void vor_blob_be_patient(struct vor_blob_writer *writer, const struct vor_blob_patience *patience)
{
    writer->patience = *patience;
}

vor_status vor_blob_expect(struct vor_blob_writer *writer, uint64_t bytes, struct vor_error *err)
{
    return writer->is_in_memory && writer->size + bytes > VOR_SMALL_FILE_MAX
               ? writer->blobs->driver->spill(writer, err)
               : VOR_OK;
}

vor_status vor_blob_append(struct vor_blob_writer *writer, const void *bytes, size_t size,
                           struct vor_error *err)
{
    const char *at = bytes;
    size_t left = size;

    assert(!writer->is_whole);
    /* By a step, as asking costs a system call; near the end of the disk by just what came. */
    if (writer->is_promised && size > writer->promised && writer->failure.status == VOR_OK &&
        (size >= PROMISE_STEP || promise(writer, PROMISE_STEP, NULL) != VOR_OK) &&
        promise(writer, size, &writer->failure) != VOR_OK)
        assert(writer->failure.status != VOR_OK);
    if (vor_blob_expect(writer, size, &writer->failure) != VOR_OK)
        assert(writer->failure.status != VOR_OK);
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
    vor_digest_update(&writer->digest, bytes, size);
    writer->size += size;
    redeem(writer, size);
    return VOR_OK;
}

vor_status vor_blob_append_file(struct vor_blob_writer *writer, int fd, uint64_t from,
                                uint64_t size, struct vor_error *err)
{
    char bytes[1 << 16];
    vor_status status = VOR_OK;

    for (uint64_t at = 0, now; status == VOR_OK && at < size; at += now) {
        now = size - at < sizeof bytes ? size - at : sizeof bytes;
        status = vor_piece_read(fd, from + at, bytes, (size_t)now, err);
        VOR_THEN(status, vor_blob_append(writer, bytes, (size_t)now, err));
    }
    return status;
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
    if (writer->is_whole)
        memcpy(out, writer->sha256, VOR_DIGEST_SIZE);
    else
        vor_digest_hex(&writer->digest, out);
}

int vor_blob_fd(const struct vor_blob_writer *writer)
{
    return writer->fd;
}

struct vor_blob_writer *vor_blob_borrow(int fd)
{
    struct vor_blob_writer *writer = calloc(1, sizeof *writer);

    if (writer == NULL)
        return NULL;
    writer->fd = fd;
    vor_digest_begin(&writer->digest);
    return writer;
}

vor_status vor_blob_adopt(struct vor_blob_writer *writer, uint64_t size,
                          const char sha256[VOR_DIGEST_SIZE], struct vor_error *err)
{
    struct stat info;

    if (fstat(writer->fd, &info) != 0)
        return vor_fail_errno(err, errno, "a temporary file");
    if (info.st_size < 0 || (uint64_t)info.st_size != size)
        return vor_fail(err, VOR_E_INTERNAL, "a result has %lld bytes instead of %llu",
                        (long long)info.st_size, (unsigned long long)size);
    writer->is_whole = 1;
    writer->size = size;
    memcpy(writer->sha256, sha256, VOR_DIGEST_SIZE);
    return VOR_OK;
}

vor_status vor_blob_commit(struct vor_blob_writer *writer, const struct vor_uuid *id,
                           const char *name, struct vor_error *err)
{
    char file[VOR_BLOB_FILE_SIZE];
    struct vor_error failure = {.status = VOR_OK};
    vor_status status = vor_blob_failure(writer, &failure);
    size_t length = strlen(name);

    assert(length >= 1 && length <= VOR_BLOB_NAME_MAX &&
           strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789-_") == length);
    VOR_THEN(status, writer->blobs->driver->commit(writer, file_of(id, name, file), &failure));
    if (status == VOR_E_IO && failure.got == EIO)
        atomic_store(&writer->blobs->is_broken, 1);
    if (status != VOR_OK && err != NULL)
        *err = failure;
    vor_blob_discard(writer);
    return status;
}

void vor_blob_discard(struct vor_blob_writer *writer)
{
    if (writer == NULL)
        return;
    if (writer->blobs == NULL) {
        free(writer); /* a borrowed file */
        return;
    }
    redeem(writer, writer->promised);
    writer->blobs->driver->discard(writer);
}

/* --- reading and removing --------------------------------------------------------------------- */

vor_status vor_blob_get(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name,
                        int *fd, uint64_t *size, int *found, struct vor_error *err)
{
    char file[VOR_BLOB_FILE_SIZE];

    if (fd != NULL)
        *fd = -1;
    *size = 0;
    *found = 0;
    return blobs->driver->get(blobs, file_of(id, name, file), fd, size, found, err);
}

vor_status vor_blob_bring(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name,
                          const struct vor_blob_watch *watch, int *found, struct vor_error *err)
{
    char file[VOR_BLOB_FILE_SIZE];
    uint64_t size;

    if (blobs->driver->bring == NULL)
        return vor_blob_get(blobs, id, name, NULL, &size, found, err);
    *found = 0;
    return blobs->driver->bring(blobs, file_of(id, name, file), watch, found, err);
}

int vor_blob_is_near(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name)
{
    char file[VOR_BLOB_FILE_SIZE];

    return blobs->driver->is_near == NULL || blobs->driver->is_near(blobs, file_of(id, name, file));
}

void vor_blobs_set_public_url(struct vor_blobs *blobs, const char *url)
{
    blobs->public_url = url;
}

vor_status vor_blob_link(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name,
                         const struct vor_blob_reading *reading, struct vor_text *out,
                         struct vor_error *err)
{
    char file[VOR_BLOB_FILE_SIZE];

    if (blobs->driver->link == NULL || blobs->public_url == NULL || blobs->public_url[0] == '\0')
        return VOR_OK;
    return blobs->driver->link(blobs, file_of(id, name, file), reading, out, err);
}

vor_status vor_blob_drop(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name,
                         struct vor_error *err)
{
    char file[VOR_BLOB_FILE_SIZE];

    return blobs->driver->drop(blobs, file_of(id, name, file), err);
}

static const struct vor_uuid nobody = {"00000000-0000-0000-0000-000000000000"};

struct listing {
    struct vor_blob_list *out;
    int is_short; /* of memory */
};

static void list_one(void *ctx, const char *file)
{
    struct listing *listing = ctx;
    struct vor_blob_list *out = listing->out;
    struct vor_uuid id;
    const char *name = vor_blob_of_file(&id, file);

    if (name == NULL || strcmp(id.text, nobody.text) == 0)
        return;
    if (out->count == out->capacity) {
        size_t capacity = 2 * out->capacity + 256;
        struct vor_blob_entry *more = realloc(out->entry, capacity * sizeof *more);

        listing->is_short |= more == NULL;
        if (more == NULL)
            return;
        out->entry = more;
        out->capacity = capacity;
    }
    out->entry[out->count].id = id;
    (void)snprintf(out->entry[out->count++].name, sizeof out->entry->name, "%s", name);
}

vor_status vor_blobs_list(struct vor_blobs *blobs, struct vor_blob_list *out, struct vor_error *err)
{
    struct listing listing = {.out = out};
    vor_status status = blobs->driver->list(blobs, list_one, &listing, err);

    return status == VOR_OK && listing.is_short ? vor_fail(err, VOR_E_NOMEM, "the list of files")
                                                : status;
}

static vor_status note_store(struct vor_blobs *blobs, const char *etag, struct vor_error *err)
{
    struct vor_blob_writer *writer = NULL;
    vor_status status = vor_blob_create(blobs, &writer, err);

    if (status != VOR_OK || writer == NULL)
        return status;
    status = vor_blob_append(writer, etag, VOR_ETAG_SIZE - 1, err);
    if (status == VOR_OK)
        return vor_blob_commit(writer, &nobody, "store", err);
    vor_blob_discard(writer);
    return status;
}

vor_status vor_blobs_claim(struct vor_blobs *blobs, const char *store, int is_joined,
                           struct vor_error *err)
{
    char etag[VOR_ETAG_SIZE] = "", noted[VOR_ETAG_SIZE] = "";
    uint64_t size;
    int fd = -1, found = 0;
    vor_status status = vor_blob_get(blobs, &nobody, "store", &fd, &size, &found, err);

    vor_digest_etag(store, strlen(store), etag);
    if (status == VOR_OK && found && pread(fd, noted, sizeof noted - 1, 0) < 0)
        status = vor_fail_errno(err, errno, "the file that notes the owner of these files");
    if (fd >= 0)
        close(fd);
    if (status != VOR_OK || (found && strcmp(noted, etag) == 0))
        return status;
    if (found || (is_joined && blobs->driver == &vor_blob_dir))
        return vor_fail(err, VOR_E_IO,
                        found ? "the files in --blobs belong to another database of jobs: choose "
                                "another folder or prefix"
                              : "other daemons use this --store, but have their files elsewhere: "
                                "--blobs must be the folder that they all share");
    return store[0] != '\0' ? note_store(blobs, etag, err) : VOR_OK;
}
