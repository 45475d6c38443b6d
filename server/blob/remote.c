#include "server/base/disk.h"
#include "server/blob/dir.h"
#include "server/blob/drops.h"
#include "server/blob/pieces.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define KEEP "keep/"
#define PIECES "piece/" /* of those in KEEP */

struct remote {
    struct vor_blob_directory copies; /* first: functions of vor_blob_dir take it for their own */
    struct vor_objects *objects;
    struct vor_drops *drops;
    uint64_t copies_max;      /* bytes */
    pthread_mutex_t trimming; /* one thread at a time removes copies */
};

static const char *key_of(char out[VOR_OBJECT_KEY_MAX + 1], const char *folder, const char *file)
{
    (void)snprintf(out, VOR_OBJECT_KEY_MAX + 1, "%s%s", folder, file);
    return out;
}

/* --- opening ---------------------------------------------------------------------------------- */

static void close_blobs(struct vor_blobs *blobs)
{
    struct remote *remote = (struct remote *)blobs;

    vor_drops_destroy(remote->drops);
    if (remote->objects != NULL)
        remote->objects->kind->close(remote->objects);
    vor_blob_directory_close(&remote->copies);
    pthread_mutex_destroy(&remote->trimming);
    free(remote);
}

static void drop_copy(void *ctx, const char *file)
{
    (void)vor_blob_dir.drop(ctx, file, NULL);
}

static vor_status open_kind(const struct vor_objects_kind *kind, struct vor_blobs **out,
                            const char *place, const struct vor_blob_cache *cache, long *holder,
                            struct vor_error *err)
{
    struct remote *remote = calloc(1, sizeof *remote);
    vor_status status;
    char folder[4096];

    if (remote == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the files elsewhere");
    remote->copies.lock = remote->copies.parent = remote->copies.keep = remote->copies.tmp = -1;
    remote->copies_max = cache->bytes;
    pthread_mutex_init(&remote->trimming, NULL);
    status = kind->open(&remote->objects, place, err);
    (void)snprintf(folder, sizeof folder, "%s/cache", cache->data);
    VOR_THEN(status, vor_blob_directory_open(&remote->copies, folder, holder, err));
    /* The copies of an earlier process may be older than the objects. */
    VOR_THEN(status, vor_blob_dir.list(&remote->copies.base, drop_copy, remote, err));
    VOR_THEN(status, kind->probe(remote->objects, err));
    VOR_THEN(status, vor_drops_create(&remote->drops, remote->objects, err));
    if (status != VOR_OK) {
        close_blobs((struct vor_blobs *)remote);
        return status;
    }
    *out = (struct vor_blobs *)remote;
    return VOR_OK;
}

static vor_status open_s3(struct vor_blobs **out, const char *place,
                          const struct vor_blob_cache *cache, long *holder, struct vor_error *err)
{
    return open_kind(&vor_s3_objects, out, place, cache, holder, err);
}

static vor_status open_postgres(struct vor_blobs **out, const char *place,
                                const struct vor_blob_cache *cache, long *holder,
                                struct vor_error *err)
{
    return open_kind(&vor_postgres_objects, out, place, cache, holder, err);
}

static struct vor_objects *objects_of(struct vor_blobs *blobs)
{
    return ((struct remote *)blobs)->objects;
}

/* --- copies ----------------------------------------------------------------------------------- */

struct copy {
    char name[VOR_BLOB_FILE_SIZE];
    uint64_t size;
    struct timespec since;
};

struct copies {
    struct remote *remote;
    struct copy *copy;
    size_t count, capacity;
};

/* One that there is no memory for is not looked at: some may do. */
static void note_copy(void *ctx, const char *file)
{
    struct copies *copies = ctx;
    struct copy *copy;
    struct stat info;

    if (fstatat(copies->remote->copies.keep, file, &info, 0) != 0)
        return;
    if (copies->count == copies->capacity) {
        size_t capacity = copies->capacity > 0 ? 2 * copies->capacity : 64;

        copy = realloc(copies->copy, capacity * sizeof *copy);
        if (copy == NULL)
            return;
        copies->copy = copy;
        copies->capacity = capacity;
    }
    copy = &copies->copy[copies->count++];
    (void)snprintf(copy->name, sizeof copy->name, "%s", file);
    copy->size = (uint64_t)info.st_size;
    copy->since = info.st_mtim;
}

static int oldest_first(const void *a, const void *b)
{
    const struct copy *x = a, *y = b;

    if (x->since.tv_sec != y->since.tv_sec)
        return x->since.tv_sec < y->since.tv_sec ? -1 : 1;
    if (x->since.tv_nsec != y->since.tv_nsec)
        return x->since.tv_nsec < y->since.tv_nsec ? -1 : 1;
    return strcmp(x->name, y->name);
}

/* Removes the oldest copies once there are more than there may be, down to three quarters, but
 * never that one, which somebody is about to read. Who reads one goes on reading it. */
static void trim_copies(struct remote *remote, const char *file)
{
    struct vor_blobs *blobs = &remote->copies.base;
    struct copies copies = {.remote = remote};

    if (blobs->bytes <= remote->copies_max || pthread_mutex_trylock(&remote->trimming) != 0)
        return;
    (void)vor_blob_dir.list(blobs, note_copy, &copies, NULL);
    if (copies.count > 0)
        qsort(copies.copy, copies.count, sizeof *copies.copy, oldest_first);
    for (size_t i = 0; i < copies.count && blobs->bytes > remote->copies_max / 4 * 3; i++)
        if (strcmp(copies.copy[i].name, file) != 0 &&
            unlinkat(remote->copies.keep, copies.copy[i].name, 0) == 0)
            blobs->bytes -= copies.copy[i].size;
    free(copies.copy);
    pthread_mutex_unlock(&remote->trimming);
}

/* Gives a writer's file the name of a copy; that need not survive a crash. */
static vor_status name_copy(struct vor_blob_writer *writer, const char *file, struct vor_error *err)
{
    vor_status status;

    writer->is_lazy = 1;
    status = vor_blob_dir.commit(writer, file, err);
    if (status == VOR_OK)
        trim_copies((struct remote *)writer->blobs, file);
    return status;
}

static int take_text(void *text, uint64_t at, const void *bytes, size_t size)
{
    if (at == 0)
        vor_text_clear(text);
    vor_text_add(text, bytes, size);
    return !((struct vor_text *)text)->failed;
}

/* Gets ready to check the bytes of a blob, if it has the digests for that, which are in `list`. */
static vor_status read_digests(struct remote *remote, const char *file, struct vor_arrival *arrival,
                               struct vor_text *list, struct vor_error *err)
{
    const struct vor_blob_part *part = &arrival->watch->part;
    const struct vor_object_reader reader = {0, UINT64_MAX, take_text, list};
    char key[VOR_OBJECT_KEY_MAX + 1];
    uint64_t size;
    int found = 0;
    vor_status status = remote->objects->kind->get(remote->objects, key_of(key, PIECES, file),
                                                   &reader, &size, &found, err);

    arrival->digest = status == VOR_OK && found ? vor_pieces_of(list, part) : NULL;
    if (arrival->digest == NULL)
        return status;
    arrival->at = part->from;
    arrival->end = part->to < part->size ? part->to : part->size;
    arrival->piece = malloc(VOR_BLOB_PIECE);
    return arrival->piece != NULL ? VOR_OK : vor_fail(err, VOR_E_NOMEM, "a part of a file");
}

/* Reads the bytes of an object that are wanted into a file. */
static vor_status receive(struct remote *remote, const char *file, struct vor_arrival *arrival,
                          uint64_t *size, int *found, struct vor_error *err)
{
    struct vor_object_reader reader = {0, UINT64_MAX, vor_arrival_take, arrival};
    struct vor_text list;
    vor_status status = VOR_OK;

    vor_text_init(&list, 0);
    if (arrival->watch != NULL && arrival->watch->part.size > VOR_BLOB_PIECE)
        status = read_digests(remote, file, arrival, &list, err);
    if (vor_arrival_is_part(arrival)) {
        reader.from = arrival->at;
        reader.to = arrival->end;
    }
    (void)key_of(arrival->name, KEEP, file);
    VOR_THEN(status,
             remote->objects->kind->get(remote->objects, arrival->name, &reader, size, found, err));
    if (arrival->failure.status != VOR_OK ||
        (status == VOR_OK && *found && vor_arrival_end(arrival) != VOR_OK)) {
        status = arrival->failure.status;
        if (err != NULL)
            *err = arrival->failure;
    }
    free(arrival->piece);
    vor_text_free(&list);
    return status;
}

/* Reads an object into a file, which becomes a copy, and *fd then reads it from its beginning; but
 * not where a part was wanted, and came. */
static vor_status fetch(struct remote *remote, const char *file, const struct vor_blob_watch *watch,
                        int *fd, int *found, struct vor_error *err)
{
    struct vor_arrival arrival = {.watch = watch};
    struct vor_blob_writer *writer = NULL;
    vor_status status = vor_blob_directory_create(&remote->copies.base, &writer, err);

    if (status != VOR_OK)
        return status;
    writer->blobs = &remote->copies.base;
    arrival.fd = writer->fd;
    status = receive(remote, file, &arrival, &writer->size, found, err);
    if (status == VOR_OK && *found && !vor_arrival_is_part(&arrival)) {
        *fd = fcntl(writer->fd, F_DUPFD_CLOEXEC, 0);
        status = *fd >= 0 && lseek(*fd, 0, SEEK_SET) == 0
                     ? name_copy(writer, file, err)
                     : vor_fail_errno(err, errno, "a temporary file");
    }
    if (status != VOR_OK && *fd >= 0) {
        close(*fd);
        *fd = -1;
    }
    vor_blob_directory_discard(writer);
    return status;
}

/* --- the functions of the driver -------------------------------------------------------------- */

/* Puts bytes as an object, as long as somebody waits for that. */
static vor_status put(struct remote *remote, const char *key, const struct vor_object_bytes *bytes,
                      struct vor_error *err)
{
    const struct vor_blob_patience *patience = bytes->patience;
    vor_status status;

    do
        status = remote->objects->kind->put(remote->objects, key, bytes, err);
    while (status != VOR_OK && vor_error_storage_absent(err) && patience->may_wait != NULL &&
           patience->may_wait(patience->ctx, err));
    return status;
}

static vor_status put_pieces(struct remote *remote, const char *key, const struct vor_text *list,
                             const struct vor_blob_patience *patience, struct vor_error *err)
{
    char sha256[VOR_DIGEST_SIZE];
    struct vor_object_bytes bytes = {-1, list->size, sha256, patience};
    struct vor_arrival file = {.fd = -1};
    struct vor_blob_writer *writer = NULL;
    vor_status status = vor_blob_directory_create(&remote->copies.base, &writer, err);

    if (status != VOR_OK)
        return status;
    writer->blobs = &remote->copies.base;
    bytes.fd = file.fd = writer->fd;
    vor_digest_text(list->data, list->size, sha256);
    if (vor_arrival_take(&file, 0, list->data, list->size))
        status = put(remote, key, &bytes, err);
    else
        *err = file.failure;
    vor_blob_directory_discard(writer);
    return file.failure.status != VOR_OK ? file.failure.status : status;
}

/* The digests of its pieces follow it, and go before it: none are left without it, and without them
 * it is read whole. */
static vor_status commit(struct vor_blob_writer *writer, const char *file, struct vor_error *err)
{
    struct remote *remote = (struct remote *)writer->blobs;
    char key[VOR_OBJECT_KEY_MAX + 1], sha256[VOR_DIGEST_SIZE];
    const struct vor_object_bytes bytes = {writer->fd, writer->size, sha256, &writer->patience};
    const int has_pieces = writer->size > VOR_BLOB_PIECE && vor_pieces_are_for(file);
    struct vor_text list;
    vor_status status = VOR_OK;

    if (writer->is_whole)
        memcpy(sha256, writer->sha256, sizeof sha256);
    else
        vor_digest_hex(&writer->digest, sha256);
    vor_text_init(&list, 0);
    if (has_pieces)
        status = vor_pieces_write(&list, writer->fd, writer->size, sha256, err);
    vor_drop_not(remote->drops, key_of(key, KEEP, file));
    VOR_THEN(status, put(remote, key, &bytes, err));
    if (status == VOR_OK && has_pieces)
        status = put_pieces(remote, key_of(key, PIECES, file), &list, &writer->patience, err);
    vor_text_free(&list);
    return status == VOR_OK ? name_copy(writer, file, err) : status;
}

static vor_status get(struct vor_blobs *blobs, const char *file, int *fd, uint64_t *size,
                      int *found, struct vor_error *err)
{
    struct remote *remote = (struct remote *)blobs;
    char key[VOR_OBJECT_KEY_MAX + 1];
    struct stat info;
    vor_status status = vor_blob_dir.get(blobs, file, fd, size, found, err);

    if (status != VOR_OK || *found)
        return status;
    if (fd == NULL)
        return remote->objects->kind->get(remote->objects, key_of(key, KEEP, file), NULL, size,
                                          found, err);
    status = fetch(remote, file, NULL, fd, found, err);
    if (status == VOR_OK && *found && fstat(*fd, &info) != 0) {
        status = vor_fail_errno(err, errno, "a temporary file");
        close(*fd);
        *fd = -1;
    } else if (status == VOR_OK && *found) {
        *size = (uint64_t)info.st_size;
    }
    return status;
}

static vor_status bring(struct vor_blobs *blobs, const char *file,
                        const struct vor_blob_watch *watch, int *found, struct vor_error *err)
{
    int fd = -1;
    vor_status status = fetch((struct remote *)blobs, file, watch, &fd, found, err);

    if (fd >= 0)
        close(fd);
    return status;
}

static int is_near(struct vor_blobs *blobs, const char *file)
{
    uint64_t size;
    int found = 0;

    return vor_blob_dir.get(blobs, file, NULL, &size, &found, NULL) != VOR_OK || found;
}

static vor_status reopen(struct vor_blobs *blobs, const char *file, struct vor_blob_writer **out,
                         int *found, struct vor_error *err)
{
    uint64_t size;
    vor_status status = VOR_OK;

    /* Others that are read meanwhile may take the copy's place. */
    for (int tries = 0; status == VOR_OK && *out == NULL && tries < 3; tries++) {
        int fd = -1, is_there = 0;

        *found = 0;
        status = get(blobs, file, &fd, &size, &is_there, err);
        if (fd >= 0)
            close(fd);
        if (status != VOR_OK || !is_there)
            return status;
        status = vor_blob_dir.reopen(blobs, file, out, found, err);
    }
    return status;
}

static vor_status link_to(struct vor_blobs *blobs, const char *file,
                          const struct vor_blob_reading *reading, struct vor_text *out,
                          struct vor_error *err)
{
    char key[VOR_OBJECT_KEY_MAX + 1];

    return objects_of(blobs)->kind->link(objects_of(blobs), blobs->public_url,
                                         key_of(key, KEEP, file), reading, out, err);
}

static vor_status drop(struct vor_blobs *blobs, const char *file, struct vor_error *err)
{
    char key[VOR_OBJECT_KEY_MAX + 1], before[VOR_OBJECT_KEY_MAX + 1] = "";
    vor_status status;

    if (vor_pieces_are_for(file))
        (void)key_of(before, PIECES, file);
    status = vor_drop(((struct remote *)blobs)->drops, key_of(key, KEEP, file), before, err);
    return status == VOR_OK ? vor_blob_dir.drop(blobs, file, err) : status;
}

static vor_status list(struct vor_blobs *blobs, void (*each)(void *ctx, const char *file),
                       void *ctx, struct vor_error *err)
{
    return objects_of(blobs)->kind->list(objects_of(blobs), KEEP, each, ctx, err);
}

static vor_status reach(struct vor_blobs *blobs, struct vor_error *err)
{
    return vor_objects_state(objects_of(blobs), NULL, err);
}

static void hurry(struct vor_blobs *blobs)
{
    atomic_store(&objects_of(blobs)->is_closing, 1);
}

/* What both do alike. */
#define REMOTE                                                                                     \
    .close = close_blobs, .space = vor_blob_directory_space, .create = vor_blob_directory_create,  \
    .reopen = reopen, .commit = commit, .discard = vor_blob_directory_discard, .get = get,         \
    .bring = bring, .is_near = is_near, .reach = reach, .hurry = hurry, .drop = drop, .list = list

const struct vor_blob_driver vor_blob_s3 = {.scheme = "s3",
                                            .place = "https://HOST/BUCKET/PREFIX",
                                            .open = open_s3,
                                            .link = link_to,
                                            REMOTE};

const struct vor_blob_driver vor_blob_postgres = {
    .scheme = "postgres", .place = "URI", .open = open_postgres, REMOTE};
