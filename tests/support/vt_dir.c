#define _XOPEN_SOURCE 700 /* nftw */

#include "tests/support/vt_dir.h"

#include "proto/codec.h"
#include "server/base/clock.h"
#include "tests/support/vt.h"

#include <dirent.h>
#include <errno.h>
#include <ftw.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* Directories that this process, or the one that it was forked from, has made. */
static struct made {
    struct made *next;
    pid_t owner;
    char path[256];
} * made;

static int remove_one(const char *path, const struct stat *info, int type, struct FTW *at)
{
    (void)info;
    (void)type;
    (void)at;
    return remove(path);
}

static void remove_made(void)
{
    for (const struct made *dir = made; dir != NULL && dir->owner == getpid(); dir = dir->next)
        (void)nftw(dir->path, remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

const char *vt_dir_make(void)
{
    struct made *dir = malloc(sizeof *dir);
    const char *base = getenv("TMPDIR");

    ck_assert_ptr_nonnull(dir);
    (void)snprintf(dir->path, sizeof dir->path, "%s/voronoid-test-XXXXXX",
                   base != NULL ? base : "/tmp");
    ck_assert_ptr_nonnull(mkdtemp(dir->path));
    if (made == NULL || made->owner != getpid())
        ck_assert_int_eq(atexit(remove_made), 0);
    dir->owner = getpid();
    dir->next = made;
    made = dir;
    return dir->path;
}

int vt_dir_count(const char *path, const char *name)
{
    char full[512];
    struct dirent *entry;
    int count = 0;
    DIR *dir;

    (void)snprintf(full, sizeof full, "%s/%s", path, name);
    dir = opendir(full);
    if (dir == NULL)
        return -1;
    while ((entry = readdir(dir)) != NULL)
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(dir);
    return count;
}

/* "postgres:" and the server of VT_POSTGRES, with a database that is the directory's. */
static void write_postgres(char *out, size_t size, const char *path)
{
    const char *server = getenv("VT_POSTGRES"), *name = strrchr(path, '/') + 1;
    char command[768];

    ck_assert_msg(server != NULL, "VT_POSTGRES has to name a server");
    (void)snprintf(command, sizeof command,
                   "psql -qX '%s dbname=postgres' -c 'CREATE DATABASE \"%s\"' 2>/dev/null", server,
                   name);
    (void)!system(command); /* fails where it is there */
    (void)snprintf(out, size, "postgres:%s dbname=%s", server, name);
}

struct vor_blobs *vt_dir_blobs(const char *path)
{
    const struct vor_blob_cache cache = {.data = path};
    const char *scheme = getenv("VT_BLOBS");
    struct vor_blobs *blobs = NULL;
    char where[512];
    long holder;

    if (scheme != NULL && strcmp(scheme, "postgres") == 0)
        write_postgres(where, sizeof where, path);
    else
        (void)snprintf(where, sizeof where, "dir:%s/blobs", path);
    vt_assert_ok(vor_blobs_open(&blobs, where, &cache, &holder, &vt_err));
    return blobs;
}

struct vor_blobs *vt_dir_small_blobs(const char *path)
{
    static struct vor_store *store; /* that of the blobs before these, which are closed */
    struct vor_blobs *blobs = vt_dir_blobs(path);

    vor_store_close(store);
    store = vt_dir_store_of(vor_store_driver_at(0), path);
    vt_assert_ok(vor_blobs_keep_small(blobs, vor_store_small_files(store), &vt_err));
    return blobs;
}

static void ignore(void *ctx VOR_UNUSED)
{
}

struct vor_store *vt_dir_store_of(const struct vor_store_driver *driver, const char *path)
{
    const char *listen = driver->is_file ? NULL : getenv("VT_LISTEN");
    struct vor_store *store = NULL;
    char where[512];
    long holder;

    if (driver->is_file)
        (void)snprintf(where, sizeof where, "%s:%s/jobs.%s", driver->scheme, path, driver->scheme);
    else
        write_postgres(where, sizeof where, path);
    vt_assert_ok(vor_store_open(&store, where, listen != NULL, &holder, &vt_err));
    if (listen != NULL) {
        (void)snprintf(where, sizeof where, "%s dbname=%s", listen, strrchr(path, '/') + 1);
        vt_assert_ok(vor_store_listen(store, where, ignore, NULL, &vt_err));
    }
    return store;
}

struct vor_store *vt_dir_store(const char *path)
{
    const char *scheme = getenv("VT_STORE");
    const struct vor_store_driver *driver = vor_store_driver_at(0);

    for (unsigned i = 1; scheme != NULL && driver != NULL && strcmp(driver->scheme, scheme) != 0;
         i++)
        driver = vor_store_driver_at(i);
    ck_assert_msg(driver != NULL, "there is no store %s", scheme);
    return vt_dir_store_of(driver, path);
}

struct vor_blob_writer *vt_upload(struct vor_blobs *blobs, const void *bytes, size_t size)
{
    struct vor_blob_writer *writer = NULL;

    vt_assert_ok(vor_blob_create(blobs, &writer, &vt_err));
    vt_assert_ok(vor_blob_append(writer, bytes, size, &vt_err));
    return writer;
}

struct vor_blob_writer *vt_upload_cloud(struct vor_blobs *blobs, const struct vor_cloud *cloud)
{
    struct vor_blob_writer *writer = NULL;
    struct vor_write_options options = {.quantization_bits = 0};
    struct vor_sink sink;

    vt_assert_ok(vor_blob_create(blobs, &writer, &vt_err));
    sink = vor_blob_sink(writer);
    vt_assert_ok(vor_format(VOR_FORMAT_PLY)->write(&sink, cloud, &options, &vt_err));
    return writer;
}

void vt_blob_put(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name,
                 const char *text)
{
    vt_assert_ok(vor_blob_commit(vt_upload(blobs, text, strlen(text)), id, name, &vt_err));
}

const char *vt_blob_text(struct vor_blobs *blobs, const struct vor_uuid *id, const char *name)
{
    static char text[256];
    uint64_t size;
    int fd, found;

    text[0] = '\0';
    vt_assert_ok(vor_blob_get(blobs, id, name, &fd, &size, &found, &vt_err));
    if (!found) {
        ck_assert_int_eq(fd, -1);
        return text;
    }
    ck_assert_uint_lt(size, sizeof text);
    ck_assert_int_eq(read(fd, text, sizeof text), (ssize_t)size);
    text[size] = '\0';
    close(fd);
    return text;
}

struct vor_job_view vt_row(unsigned points)
{
    struct vor_job_view row = {
        .attempt = 1, .inputs = 1, .input = {{.points = 100, .bytes = 1234}}};

    vt_assert_ok(vor_uuid_make(&row.id, &vt_err));
    vor_spec_init(&row.spec);
    vt_assert_ok(vor_spec_set_number(&row.spec, "points", points, &vt_err));
    vt_assert_ok(vor_spec_set(&row.spec, "format", "ply", &vt_err));
    strcpy(row.process, "resample");
    strcpy(row.input[0].sha256, "00");
    row.input[0].seconds = 0.25;
    row.created = vor_clock_wall_ms();
    row.updated = row.created;
    row.queue_position = -1;
    row.eta_seconds = -1;
    row.problem.byte_offset = -1;
    return row;
}

struct vor_job_view vt_stored(struct vor_store *store, const struct vor_uuid *id)
{
    struct vor_job_view row;
    int found;

    vt_assert_ok(vor_store_get(store, id, NULL, &row, &found, &vt_err));
    ck_assert(found);
    return row;
}

uint32_t vt_claim(struct vor_store *store, const struct vor_uuid *id)
{
    const struct vor_claim claim = {VT_OWNER, vor_clock_wall_ms(), UINT64_MAX, 1, vor_build_own()};
    struct vor_job_view row;
    int found;

    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    if (found && id != NULL)
        ck_assert_str_eq(row.id.text, id->text);
    return found ? row.attempt : 0;
}

int vt_append(struct vor_store *store, struct vor_job_view row, int progress,
              const struct vor_lease *lease, uint32_t last)
{
    const struct vor_event_piece piece = {last, (const uint8_t *)"abcdefgh" + last, 1};
    int changed;

    row.progress = progress;
    vt_assert_ok(vor_store_append_events(store, &row, lease, &piece, &changed, &vt_err));
    return changed;
}

static int add_piece(void *ctx, const struct vor_event_piece *piece)
{
    char *out = ctx;

    out += strlen(out);
    out += sprintf(out, "%u:", piece->last);
    for (size_t i = 0; i < piece->size; i++)
        out += sprintf(out, "%c", piece->data[i] != 0 ? piece->data[i] : '0');
    (void)sprintf(out, " ");
    return 1;
}

void vt_events(struct vor_store *store, const struct vor_uuid *id, uint32_t attempt, uint32_t after,
               char *out)
{
    const struct vor_event_query query = {attempt, after, add_piece, out};

    out[0] = '\0';
    vt_assert_ok(vor_store_events(store, id, &query, &vt_err));
}

void vt_killed(void (*act)(void *ctx), void *ctx)
{
    pid_t child = fork();
    int status = 0;

    ck_assert_int_ge(child, 0);
    if (child == 0) {
        act(ctx);
        _exit(9); /* it should have killed itself */
    }
    while (waitpid(child, &status, 0) < 0)
        ck_assert_int_eq(errno, EINTR);
    ck_assert_msg(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL,
                  "the child ended with status %#x instead of SIGKILL", (unsigned)status);
}
