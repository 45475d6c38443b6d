/* A table of what was found of which file. A file is known by its place, size and date: blobs are
 * never changed, but put in place of others.
 *
 * One pass, measured from the page cache on one core of a machine at work: 1,230 MB/s with the
 * processor's instructions for SHA-256, 212 MB/s without: 10 or 57 ms before the first byte for
 * 1,000,000 points in 12 MB of PLY. */
#include "server/work/verify.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/work/fetch.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Files remembered, and threads that read. */
enum { KNOWN_MAX = 1024, THREADS = 2 };

/* What was found holds so long: a bit that flips meanwhile is found by the next pass. */
static const double sound_seconds = 600, damaged_seconds = 5;

struct known {
    dev_t device;
    ino_t file;
    struct timespec written;
    uint64_t size;
    char sha256[VOR_DIGEST_SIZE];
    enum vor_verdict
        verdict;  /* VOR_VERDICT_WAIT while it is read; FAILED: none, the place is free */
    double since; /* of the verdict, or when it was last asked for */
    struct vor_askers *waiting;
};

struct pass {
    struct vor_verify *verify;
    struct known *known;
    struct vor_task task;
    int fd;
};

struct vor_verify {
    struct vor_thread_pool *pool;
    struct vor_fetcher *fetcher;
    pthread_mutex_t mutex; /* everything below */
    struct known known[KNOWN_MAX];
};

vor_status vor_verify_create(struct vor_verify **out, struct vor_blobs *blobs,
                             struct vor_error *err)
{
    struct vor_verify *verify = calloc(1, sizeof *verify);

    if (verify == NULL ||
        vor_thread_pool_create(&verify->pool, THREADS, KNOWN_MAX, err) != VOR_OK ||
        vor_fetcher_create(&verify->fetcher, blobs, err) != VOR_OK) {
        if (verify != NULL)
            vor_thread_pool_destroy(verify->pool);
        free(verify);
        return vor_fail(err, VOR_E_NOMEM, "checking stored files");
    }
    vor_thread_pool_share(verify->pool, THREADS - 1, KNOWN_MAX / 4);
    pthread_mutex_init(&verify->mutex, NULL);
    for (int i = 0; i < KNOWN_MAX; i++)
        verify->known[i].verdict = VOR_VERDICT_FAILED;
    *out = verify;
    return VOR_OK;
}

void vor_verify_destroy(struct vor_verify *verify)
{
    if (verify == NULL)
        return;
    vor_fetcher_destroy(verify->fetcher);
    vor_thread_pool_destroy(verify->pool); /* does what waits, so that all have been woken */
    pthread_mutex_destroy(&verify->mutex);
    free(verify);
}

struct vor_fetcher *vor_verify_fetcher(const struct vor_verify *verify)
{
    return verify->fetcher;
}

static enum vor_verdict check(int fd, uint64_t size, const char *sha256)
{
    char found[VOR_DIGEST_SIZE];

    if (vor_digest_file(fd, 0, size, found) && strcmp(found, sha256) == 0)
        return VOR_VERDICT_SOUND;
    vor_log(VOR_LOG_ERROR, "stored bytes are damaged", VOR_TEXT("sha256", sha256),
            VOR_COUNT("bytes", size));
    return VOR_VERDICT_DAMAGED;
}

static void run_pass(void *ctx)
{
    struct pass *pass = ctx;
    struct vor_verify *verify = pass->verify;
    struct known *known = pass->known; /* nobody else touches one that is being read */
    enum vor_verdict verdict = VOR_VERDICT_FAILED;
    struct vor_askers *waiting;

    if (!vor_thread_pool_is_closing(verify->pool))
        verdict = check(pass->fd, known->size, known->sha256);
    close(pass->fd);
    pthread_mutex_lock(&verify->mutex);
    known->verdict = verdict;
    known->since = vor_clock_seconds();
    waiting = vor_waiting_take(&known->waiting);
    pthread_mutex_unlock(&verify->mutex);
    vor_waiting_wake(waiting);
    free(pass);
}

static int is_fresh(const struct known *known)
{
    double age = vor_clock_seconds() - known->since;

    return known->verdict == VOR_VERDICT_WAIT ||
           (known->verdict == VOR_VERDICT_SOUND && age < sound_seconds) ||
           (known->verdict == VOR_VERDICT_DAMAGED && age < damaged_seconds);
}

/* The entry of a file, or one for it: a free one, else that of the oldest verdict; NULL when every
 * one is being read. The mutex is held. */
static struct known *find(struct vor_verify *verify, const struct known *wanted)
{
    struct known *place = NULL;

    for (int i = 0; i < KNOWN_MAX; i++) {
        struct known *known = &verify->known[i];

        if (known->verdict != VOR_VERDICT_FAILED && known->device == wanted->device &&
            known->file == wanted->file && known->size == wanted->size &&
            known->written.tv_sec == wanted->written.tv_sec &&
            known->written.tv_nsec == wanted->written.tv_nsec &&
            strcmp(known->sha256, wanted->sha256) == 0)
            return known;
        if (known->verdict == VOR_VERDICT_WAIT)
            continue;
        if (place == NULL || known->since < place->since)
            place = known;
    }
    if (place != NULL)
        *place = *wanted;
    return place;
}

/* Has an entry read; the mutex is held. */
static int start(struct vor_verify *verify, struct known *known, int fd,
                 const struct vor_asker *asker)
{
    struct pass *pass = calloc(1, sizeof *pass);

    if (pass == NULL)
        return 0;
    *pass = (struct pass){.verify = verify, .known = known, .fd = dup(fd)};
    pass->task = (struct vor_task){
        .run = run_pass, .ctx = pass, .caller = asker->caller, .weight = known->size};
    if (pass->fd >= 0 && vor_thread_pool_submit(verify->pool, &pass->task, NULL) == VOR_DONE) {
        known->verdict = VOR_VERDICT_WAIT;
        return 1;
    }
    if (pass->fd >= 0)
        close(pass->fd);
    free(pass);
    return 0;
}

enum vor_verdict vor_verify_ask(struct vor_verify *verify, int fd, uint64_t size,
                                const char *sha256, const struct vor_asker *asker)
{
    struct known wanted = {.size = size, .verdict = VOR_VERDICT_FAILED};
    enum vor_verdict verdict = VOR_VERDICT_FAILED;
    struct known *known;
    struct stat info;

    if (!vor_digest_is_one(sha256))
        return VOR_VERDICT_SOUND;
    if (fstat(fd, &info) != 0)
        return VOR_VERDICT_FAILED;
    if (info.st_nlink == 0 && size <= VOR_SMALL_FILE_MAX) /* in memory, and another one each time */
        return check(fd, size, sha256);
    wanted.device = info.st_dev;
    wanted.file = info.st_ino;
    wanted.written = info.st_mtim;
    memcpy(wanted.sha256, sha256, VOR_DIGEST_SIZE);
    pthread_mutex_lock(&verify->mutex);
    known = find(verify, &wanted);
    if (known != NULL && is_fresh(known) && known->verdict != VOR_VERDICT_WAIT)
        verdict = known->verdict;
    else if (known != NULL && (is_fresh(known) || start(verify, known, fd, asker)) &&
             vor_waiting_add(&known->waiting, asker))
        verdict = VOR_VERDICT_WAIT;
    pthread_mutex_unlock(&verify->mutex);
    return verdict;
}
