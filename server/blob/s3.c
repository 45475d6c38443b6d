#include "server/blob/s3.h"

#include "server/base/disk.h"
#include "server/blob/dir.h"
#include "server/blob/s3_drops.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define KEEP "keep/"
#define LOST "lost/"

struct bucket {
    struct vor_blob_directory copies; /* first: functions of vor_blob_dir take it for their own */
    struct vor_s3 *s3;
    struct vor_s3_drops *drops;
    uint64_t copies_max;      /* bytes */
    pthread_mutex_t trimming; /* one thread at a time removes copies */
};

static const char *key_of(char out[VOR_S3_KEY_MAX + 1], const char *folder,
                          const struct vor_uuid *id, const char *name)
{
    char file[VOR_BLOB_FILE_SIZE];

    vor_blob_file(file, id, name);
    (void)snprintf(out, VOR_S3_KEY_MAX + 1, "%s%s", folder, file);
    return out;
}

/* --- opening ---------------------------------------------------------------------------------- */

static void close_blobs(struct vor_blobs *blobs)
{
    struct bucket *bucket = (struct bucket *)blobs;

    vor_s3_drops_destroy(bucket->drops);
    vor_s3_close(bucket->s3);
    vor_blob_directory_close(&bucket->copies);
    pthread_mutex_destroy(&bucket->trimming);
    free(bucket);
}

static void drop_copy(void *ctx, const struct vor_uuid *id, const char *name)
{
    (void)vor_blob_dir.drop(ctx, id, name, NULL);
}

static void ignore(void *ctx, const struct vor_s3_object *object)
{
    (void)ctx;
    (void)object;
}

/* The copies of an earlier process may be older than what stands in S3. */
static vor_status open_parts(struct bucket *bucket, const char *place,
                             const struct vor_blob_cache *cache, long *holder,
                             struct vor_error *err)
{
    struct vor_uuid none = {.text = "00000000-0000-0000-0000-000000000000"};
    char key[VOR_S3_KEY_MAX + 1], folder[4096];
    vor_status status = vor_s3_open(&bucket->s3, place, err);

    (void)snprintf(folder, sizeof folder, "%s/cache", cache->data);
    if (status == VOR_OK)
        status = vor_blob_directory_open(&bucket->copies, folder, holder, err);
    if (status == VOR_OK)
        status = vor_blob_dir.list(&bucket->copies.base, drop_copy, bucket, err);
    /* Nothing is listed, but the bucket and the keys are tried. */
    if (status == VOR_OK)
        status = vor_s3_list(bucket->s3, key_of(key, KEEP, &none, "none"), ignore, NULL, err);
    return status == VOR_OK ? vor_s3_drops_create(&bucket->drops, bucket->s3, err) : status;
}

static vor_status open_blobs(struct vor_blobs **out, const char *place,
                             const struct vor_blob_cache *cache, long *holder,
                             struct vor_error *err)
{
    struct bucket *bucket = calloc(1, sizeof *bucket);
    vor_status status;

    if (bucket == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the files in S3");
    bucket->copies.lock = bucket->copies.parent = bucket->copies.keep = bucket->copies.tmp = -1;
    bucket->copies_max = cache->bytes;
    pthread_mutex_init(&bucket->trimming, NULL);
    status = open_parts(bucket, place, cache, holder, err);
    if (status != VOR_OK) {
        close_blobs((struct vor_blobs *)bucket);
        return status;
    }
    *out = (struct vor_blobs *)bucket;
    return VOR_OK;
}

/* --- copies ----------------------------------------------------------------------------------- */

struct copy {
    char file[VOR_BLOB_FILE_SIZE];
    struct timespec written;
    uint64_t size;
};

struct copies {
    struct bucket *bucket;
    struct copy *item;
    size_t count, capacity;
};

static void note_copy(void *ctx, const struct vor_uuid *id, const char *name)
{
    struct copies *copies = ctx;
    struct stat info;
    struct copy *copy;

    if (copies->count == copies->capacity) {
        size_t capacity = 2 * copies->capacity + 64;
        struct copy *more = realloc(copies->item, capacity * sizeof *more);

        if (more == NULL)
            return; /* the others are removed */
        copies->item = more;
        copies->capacity = capacity;
    }
    copy = &copies->item[copies->count];
    vor_blob_file(copy->file, id, name);
    if (fstatat(copies->bucket->copies.keep, copy->file, &info, 0) != 0)
        return;
    copy->written = info.st_mtim;
    copy->size = (uint64_t)info.st_size;
    copies->count++;
}

static int by_age(const void *a, const void *b)
{
    const struct copy *x = a, *y = b;

    if (x->written.tv_sec != y->written.tv_sec)
        return x->written.tv_sec < y->written.tv_sec ? -1 : 1;
    return (x->written.tv_nsec > y->written.tv_nsec) - (x->written.tv_nsec < y->written.tv_nsec);
}

/* Removes the oldest copies once there are more than there may be, down to three quarters, but
 * never that one, which somebody is about to read. Who reads one goes on reading it. */
static void trim_copies(struct bucket *bucket, const char *file)
{
    struct vor_blobs *blobs = &bucket->copies.base;
    struct copies copies = {.bucket = bucket};

    if (blobs->bytes <= bucket->copies_max || pthread_mutex_trylock(&bucket->trimming) != 0)
        return;
    if (vor_blob_dir.list(blobs, note_copy, &copies, NULL) == VOR_OK && copies.count > 0)
        qsort(copies.item, copies.count, sizeof *copies.item, by_age);
    for (size_t i = 0; i < copies.count && blobs->bytes > bucket->copies_max / 4 * 3; i++)
        if (strcmp(copies.item[i].file, file) != 0 &&
            unlinkat(bucket->copies.keep, copies.item[i].file, 0) == 0)
            blobs->bytes -= copies.item[i].size;
    free(copies.item);
    pthread_mutex_unlock(&bucket->trimming);
}

/* Gives a writer's file the name of a copy; that need not survive a crash. */
static vor_status name_copy(struct vor_blob_writer *writer, const struct vor_uuid *id,
                            const char *name, struct vor_error *err)
{
    char file[VOR_BLOB_FILE_SIZE];
    vor_status status;

    writer->is_lazy = 1;
    status = vor_blob_dir.commit(writer, id, name, err);
    vor_blob_file(file, id, name);
    if (status == VOR_OK)
        trim_copies((struct bucket *)writer->blobs, file);
    return status;
}

/* Reads an object into a file, which *fd then reads. */
static vor_status fetch(struct bucket *bucket, const struct vor_uuid *id, const char *name, int *fd,
                        uint64_t *size, int *found, struct vor_error *err)
{
    char key[VOR_S3_KEY_MAX + 1];
    struct vor_blob_writer *writer = NULL;
    vor_status status = vor_blob_dir.create(&bucket->copies.base, &writer, err);

    if (status != VOR_OK)
        return status;
    writer->blobs = &bucket->copies.base;
    status =
        vor_s3_get(bucket->s3, key_of(key, KEEP, id, name), writer->fd, &writer->size, found, err);
    if (status == VOR_OK && *found) {
        *size = writer->size;
        *fd = fcntl(writer->fd, F_DUPFD_CLOEXEC, 0);
        status = *fd >= 0 ? name_copy(writer, id, name, err)
                          : vor_fail_errno(err, errno, "a temporary file");
    }
    if (status != VOR_OK && *fd >= 0) {
        close(*fd);
        *fd = -1;
    }
    vor_blob_dir.discard(writer);
    return status;
}

/* --- the functions of the driver -------------------------------------------------------------- */

static vor_status commit(struct vor_blob_writer *writer, const struct vor_uuid *id,
                         const char *name, struct vor_error *err)
{
    struct bucket *bucket = (struct bucket *)writer->blobs;
    char key[VOR_S3_KEY_MAX + 1], sha256[VOR_DIGEST_SIZE];
    vor_status status;

    if (writer->digest != NULL)
        vor_digest_hex(writer->digest, sha256);
    else
        memcpy(sha256, writer->sha256, sizeof sha256);
    vor_s3_keep(bucket->drops, key_of(key, KEEP, id, name));
    status = vor_s3_put(bucket->s3, key, writer->fd, writer->size, sha256, err);
    return status == VOR_OK ? name_copy(writer, id, name, err) : status;
}

static vor_status get(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name, int *fd,
                      uint64_t *size, int *found, struct vor_error *err)
{
    struct bucket *bucket = (struct bucket *)blobs;
    char key[VOR_S3_KEY_MAX + 1];
    vor_status status = vor_blob_dir.get(blobs, id, name, fd, size, found, err);

    if (status != VOR_OK || *found)
        return status;
    return fd != NULL ? fetch(bucket, id, name, fd, size, found, err)
                      : vor_s3_get(bucket->s3, key_of(key, KEEP, id, name), -1, size, found, err);
}

static int is_near(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name)
{
    uint64_t size;
    int found = 0;

    return vor_blob_dir.get(blobs, id, name, NULL, &size, &found, NULL) != VOR_OK || found;
}

static vor_status reopen(struct vor_blobs *blobs, const struct vor_blob_source *from,
                         struct vor_blob_writer **out, int *found, struct vor_error *err)
{
    uint64_t size;
    vor_status status = VOR_OK;

    /* Others that are read meanwhile may take the copy's place. */
    for (int tries = 0; status == VOR_OK && *out == NULL && tries < 3; tries++) {
        int fd = -1, is_there = 0;

        *found = 0;
        status = get(blobs, &from->id, from->name, &fd, &size, &is_there, err);
        if (fd >= 0)
            close(fd);
        if (status != VOR_OK || !is_there)
            return status;
        status = vor_blob_dir.reopen(blobs, from, out, found, err);
    }
    return status;
}

static vor_status drop(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name,
                       struct vor_error *err)
{
    char key[VOR_S3_KEY_MAX + 1];
    vor_status status =
        vor_s3_drop(((struct bucket *)blobs)->drops, key_of(key, KEEP, id, name), err);

    return status == VOR_OK ? vor_blob_dir.drop(blobs, id, name, err) : status;
}

static vor_status set_aside(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name,
                            struct vor_error *err)
{
    char from[VOR_S3_KEY_MAX + 1], to[VOR_S3_KEY_MAX + 1];
    vor_status status = vor_s3_copy(((struct bucket *)blobs)->s3, key_of(from, KEEP, id, name),
                                    key_of(to, LOST, id, name), err);

    return status == VOR_OK ? drop(blobs, id, name, err) : status;
}

/* What was set aside, newest last. */
struct lost {
    struct lost *next;
    int64_t modified_ms;
    uint64_t size;
    char key[VOR_S3_KEY_MAX + 1];
};

struct losses {
    struct lost *oldest;
    uint64_t bytes;
    int is_short; /* of memory */
};

static void note_lost(void *ctx, const struct vor_s3_object *object)
{
    struct losses *losses = ctx;
    struct lost *lost = malloc(sizeof *lost), **at = &losses->oldest;

    if (lost == NULL) {
        losses->is_short = 1;
        return;
    }
    while (*at != NULL && (*at)->modified_ms <= object->modified_ms)
        at = &(*at)->next;
    *lost = (struct lost){.next = *at, .modified_ms = object->modified_ms, .size = object->size};
    (void)snprintf(lost->key, sizeof lost->key, LOST "%s", object->key);
    *at = lost;
    losses->bytes += object->size;
}

static vor_status trim_lost(struct vor_blobs *blobs, const struct vor_lost_bounds *bounds,
                            struct vor_error *err)
{
    struct vor_s3 *s3 = ((struct bucket *)blobs)->s3;
    struct losses losses = {0};
    vor_status status = vor_s3_list(s3, LOST, note_lost, &losses, err);

    for (struct lost *lost = losses.oldest, *next; lost != NULL; lost = next) {
        if (status == VOR_OK &&
            (lost->modified_ms < bounds->oldest_ms || losses.bytes > bounds->bytes)) {
            status = vor_s3_delete(s3, lost->key, err);
            losses.bytes -= lost->size;
        }
        next = lost->next;
        free(lost);
    }
    return status == VOR_OK && losses.is_short
               ? vor_fail(err, VOR_E_NOMEM, "the list of lost files")
               : status;
}

struct listing {
    void (*each)(void *ctx, const struct vor_uuid *id, const char *name);
    void *ctx;
};

static void list_one(void *ctx, const struct vor_s3_object *object)
{
    const struct listing *listing = ctx;
    struct vor_uuid id;
    const char *name = vor_blob_of_file(&id, object->key);

    if (name != NULL)
        listing->each(listing->ctx, &id, name);
}

static vor_status list(struct vor_blobs *blobs,
                       void (*each)(void *ctx, const struct vor_uuid *id, const char *name),
                       void *ctx, struct vor_error *err)
{
    struct listing listing = {.each = each, .ctx = ctx};

    return vor_s3_list(((struct bucket *)blobs)->s3, KEEP, list_one, &listing, err);
}

static vor_status space(struct vor_blobs *blobs, uint64_t *available, uint64_t *total,
                        struct vor_error *err)
{
    return vor_blob_dir.space(blobs, available, total, err);
}

static vor_status create(struct vor_blobs *blobs, struct vor_blob_writer **out,
                         struct vor_error *err)
{
    return vor_blob_dir.create(blobs, out, err);
}

static void discard(struct vor_blob_writer *writer)
{
    vor_blob_dir.discard(writer);
}

const struct vor_blob_driver vor_blob_s3 = {
    .scheme = "s3",
    .place = "https://HOST/BUCKET/PREFIX",
    .open = open_blobs,
    .close = close_blobs,
    .space = space,
    .create = create,
    .reopen = reopen,
    .commit = commit,
    .discard = discard,
    .get = get,
    .is_near = is_near,
    .drop = drop,
    .set_aside = set_aside,
    .trim_lost = trim_lost,
    .list = list,
};
