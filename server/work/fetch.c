#include "server/work/fetch.h"

#include "server/base/clock.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { THREADS = 4, WAITING_MAX = 256 };
static const double outcome_seconds = 5;

struct vor_flow {
    pthread_mutex_t mutex;
    unsigned holds;
    int fd;                   /* -1 before the first bytes */
    uint64_t from, have;      /* of the blob: bytes between them are in fd */
    enum vor_fetched outcome; /* VOR_FETCH_WAIT while they come, VOR_FETCH_NEAR of all */
    struct vor_askers *waiting;
};

/* One blob. It is on the list while it is fetched, and for some seconds after it could not be. */
struct fetch {
    struct fetch *next;
    struct vor_fetcher *fetcher;
    struct vor_uuid id;
    char name[VOR_BLOB_NAME_MAX + 1];
    struct vor_blob_part part;
    struct vor_task task;
    struct vor_askers *waiting; /* for the end */
    struct vor_flow *flow;
    enum vor_fetched outcome;
    struct vor_error error;
    double since;
};

struct vor_fetcher {
    struct vor_blobs *blobs;
    struct vor_thread_pool *pool;
    pthread_mutex_t mutex;
    struct fetch *list;
};

/* --- flows ------------------------------------------------------------------------------------ */

void vor_flow_drop(struct vor_flow *flow)
{
    unsigned left = 1;

    if (flow != NULL) {
        pthread_mutex_lock(&flow->mutex);
        left = --flow->holds;
        pthread_mutex_unlock(&flow->mutex);
    }
    if (left > 0)
        return;
    if (flow->fd >= 0)
        close(flow->fd);
    pthread_mutex_destroy(&flow->mutex);
    free(flow);
}

static void on_came(void *ctx, int fd, uint64_t have)
{
    struct vor_flow *flow = ctx;
    struct vor_askers *woken;

    pthread_mutex_lock(&flow->mutex);
    if (flow->fd < 0)
        flow->fd = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    if (flow->fd >= 0)
        flow->have = have;
    woken = vor_waiting_take(&flow->waiting);
    pthread_mutex_unlock(&flow->mutex);
    vor_waiting_wake(woken);
}

long vor_flow_read(struct vor_flow *flow, uint64_t at, void *out, size_t size,
                   const struct vor_asker *asker, int *whole)
{
    uint64_t left;
    long got;

    pthread_mutex_lock(&flow->mutex);
    left = flow->have > at ? flow->have - at : 0;
    *whole = flow->outcome == VOR_FETCH_NEAR;
    if (left > 0)
        got = pread(flow->fd, out, size < left ? size : (size_t)left, (off_t)(at - flow->from));
    else
        got = flow->outcome == VOR_FETCH_FAILED ? -1 : 0;
    if (got == 0 && !*whole && !vor_waiting_add(&flow->waiting, asker))
        got = -1;
    pthread_mutex_unlock(&flow->mutex);
    return got;
}

/* --- fetches ---------------------------------------------------------------------------------- */

static void free_fetch(struct fetch *fetch)
{
    vor_flow_drop(fetch->flow);
    free(fetch);
}

vor_status vor_fetcher_create(struct vor_fetcher **out, struct vor_blobs *blobs,
                              struct vor_error *err)
{
    struct vor_fetcher *fetcher = calloc(1, sizeof *fetcher);

    if (fetcher == NULL ||
        vor_thread_pool_create(&fetcher->pool, THREADS, WAITING_MAX, err) != VOR_OK) {
        free(fetcher);
        return vor_fail(err, VOR_E_NOMEM, "fetching stored files");
    }
    vor_thread_pool_share(fetcher->pool, THREADS - 1, WAITING_MAX / 4);
    fetcher->blobs = blobs;
    pthread_mutex_init(&fetcher->mutex, NULL);
    *out = fetcher;
    return VOR_OK;
}

void vor_fetcher_destroy(struct vor_fetcher *fetcher)
{
    if (fetcher == NULL)
        return;
    vor_thread_pool_destroy(fetcher->pool); /* does what waits, so that all have been woken */
    while (fetcher->list != NULL) {
        struct fetch *next = fetcher->list->next;

        free_fetch(fetcher->list);
        fetcher->list = next;
    }
    pthread_mutex_destroy(&fetcher->mutex);
    free(fetcher);
}

/* Takes one off the list; the mutex is held. */
static void end_fetch(struct fetch *fetch)
{
    struct fetch **at = &fetch->fetcher->list;

    while (*at != fetch)
        at = &(*at)->next;
    *at = fetch->next;
    free_fetch(fetch);
}

static void run(void *ctx)
{
    struct fetch *fetch = ctx;
    struct vor_fetcher *fetcher = fetch->fetcher;
    const struct vor_blob_watch watch = {on_came, fetch->flow, fetch->part};
    struct vor_askers *waiting, *flowing;
    struct vor_error error;
    int found = 0, has_come, is_near;
    vor_status status =
        vor_thread_pool_is_closing(fetcher->pool)
            ? vor_fail(&error, VOR_E_IO, "the daemon is stopping")
            : vor_blob_bring(fetcher->blobs, &fetch->id, fetch->name, &watch, &found, &error);

    has_come = status == VOR_OK && found;
    pthread_mutex_lock(&fetcher->mutex); /* those that wait for the flow find the outcome set */
    pthread_mutex_lock(&fetch->flow->mutex);
    is_near = has_come && (fetch->part.to == UINT64_MAX || fetch->flow->fd < 0);
    fetch->flow->outcome = has_come ? VOR_FETCH_NEAR : VOR_FETCH_FAILED;
    flowing = vor_waiting_take(&fetch->flow->waiting);
    pthread_mutex_unlock(&fetch->flow->mutex);
    fetch->outcome = status != VOR_OK ? VOR_FETCH_FAILED
                     : has_come       ? VOR_FETCH_FLOWS
                                      : VOR_FETCH_NONE;
    if (status != VOR_OK)
        fetch->error = error;
    fetch->since = vor_clock_seconds();
    waiting = vor_waiting_take(&fetch->waiting);
    if (is_near)
        end_fetch(fetch);
    pthread_mutex_unlock(&fetcher->mutex);
    vor_waiting_wake(flowing);
    vor_waiting_wake(waiting);
}

/* Those bytes, up to the borders of pieces. */
static struct vor_blob_part whole_pieces(const struct vor_blob_part *part)
{
    struct vor_blob_part out = {.to = UINT64_MAX};

    if (part == NULL)
        return out;
    out = *part;
    out.from -= out.from % VOR_BLOB_PIECE;
    out.to += (VOR_BLOB_PIECE - out.to % VOR_BLOB_PIECE) % VOR_BLOB_PIECE;
    if (out.from == 0 && out.to >= out.size)
        out.to = UINT64_MAX;
    return out;
}

/* The fetch of bytes of a blob, NULL for none; removes those whose outcome is old. The mutex is
 * held. */
static struct fetch *find(struct vor_fetcher *fetcher, const struct vor_uuid *id, const char *name,
                          const struct vor_blob_part *part)
{
    double now = vor_clock_seconds();
    struct fetch *found = NULL;

    for (struct fetch **at = &fetcher->list; *at != NULL;) {
        struct fetch *fetch = *at;

        if (fetch->outcome != VOR_FETCH_WAIT && now - fetch->since > outcome_seconds) {
            *at = fetch->next;
            free_fetch(fetch);
            continue;
        }
        if (strcmp(fetch->id.text, id->text) == 0 && strcmp(fetch->name, name) == 0 &&
            fetch->part.from == part->from && fetch->part.to == part->to)
            found = fetch;
        at = &fetch->next;
    }
    return found;
}

/* Begins a fetch; the mutex is held. NULL when it cannot be begun, as err says. */
static struct fetch *begin(struct vor_fetcher *fetcher, const struct vor_uuid *id, const char *name,
                           const struct vor_blob_part *part, const struct vor_asker *asker,
                           struct vor_error *err)
{
    struct fetch *fetch = calloc(1, sizeof *fetch);

    if (fetch == NULL || (fetch->flow = calloc(1, sizeof *fetch->flow)) == NULL) {
        free(fetch);
        (void)vor_fail(err, VOR_E_NOMEM, "fetching a stored file");
        return NULL;
    }
    pthread_mutex_init(&fetch->flow->mutex, NULL);
    fetch->flow->holds = 1;
    fetch->flow->fd = -1;
    fetch->flow->from = part->from;
    fetch->flow->outcome = VOR_FETCH_WAIT;
    fetch->fetcher = fetcher;
    fetch->part = *part;
    fetch->id = *id;
    memcpy(fetch->name, name, strlen(name) + 1);
    fetch->outcome = VOR_FETCH_WAIT;
    fetch->task = (struct vor_task){.run = run, .ctx = fetch, .caller = asker->caller, .weight = 1};
    if (vor_thread_pool_submit(fetcher->pool, &fetch->task, NULL) != VOR_DONE) {
        free_fetch(fetch);
        (void)vor_fail(err, VOR_E_IO, "too many stored files are being fetched; try again later");
        return NULL;
    }
    fetch->next = fetcher->list;
    fetcher->list = fetch;
    return fetch;
}

/* The flow, if its first bytes are here; else the one who would read it waits for them. */
static enum vor_fetched take_flow(struct vor_flow **out, struct vor_flow *flow,
                                  const struct vor_asker *asker)
{
    enum vor_fetched outcome = VOR_FETCH_FLOWS;

    pthread_mutex_lock(&flow->mutex);
    if (flow->fd >= 0 || flow->outcome != VOR_FETCH_WAIT) {
        flow->holds++;
        *out = flow;
    } else {
        outcome = vor_waiting_add(&flow->waiting, asker) ? VOR_FETCH_WAIT : VOR_FETCH_FAILED;
    }
    pthread_mutex_unlock(&flow->mutex);
    return outcome;
}

enum vor_fetched vor_fetch(struct vor_fetcher *fetcher, const struct vor_uuid *id, const char *name,
                           const struct vor_blob_part *part, const struct vor_asker *asker,
                           struct vor_flow **flow, struct vor_error *err)
{
    const struct vor_blob_part pieces = whole_pieces(part);
    enum vor_fetched outcome = VOR_FETCH_FAILED;
    struct fetch *fetch;

    if (vor_blob_is_near(fetcher->blobs, id, name))
        return VOR_FETCH_NEAR;
    pthread_mutex_lock(&fetcher->mutex);
    fetch = find(fetcher, id, name, &pieces);
    if (fetch == NULL)
        fetch = begin(fetcher, id, name, &pieces, asker, err);
    if (fetch != NULL && fetch->outcome != VOR_FETCH_WAIT && fetch->outcome != VOR_FETCH_FLOWS) {
        outcome = fetch->outcome;
        *err = fetch->error;
    } else if (fetch != NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "fetching a stored file");
        if (part != NULL)
            outcome = take_flow(flow, fetch->flow, asker);
        else if (vor_waiting_add(&fetch->waiting, asker))
            outcome = VOR_FETCH_WAIT;
        if (fetch->outcome == VOR_FETCH_FLOWS) /* its file goes with the flow */
            end_fetch(fetch);
    }
    pthread_mutex_unlock(&fetcher->mutex);
    return outcome;
}
