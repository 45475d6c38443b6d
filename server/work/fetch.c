#include "server/work/fetch.h"

#include "server/base/clock.h"
#include "server/work/crew.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { THREADS = 4, WAITING_MAX = 256 };
static const double outcome_seconds = 5;

struct waiting {
    struct waiting *next;
    struct vor_asker asker;
};

/* One blob. It is on the list while it is fetched, and for some seconds after it could not be. */
struct fetch {
    struct fetch *next;
    struct vor_fetcher *fetcher;
    struct vor_uuid id;
    char name[VOR_BLOB_NAME_MAX + 1];
    struct vor_task task;
    struct waiting *waiting;
    enum vor_fetched outcome;
    struct vor_error error;
    double since;
};

struct vor_fetcher {
    struct vor_blobs *blobs;
    struct vor_crew *crew;
    pthread_mutex_t mutex;
    struct fetch *list;
};

vor_status vor_fetcher_create(struct vor_fetcher **out, struct vor_blobs *blobs,
                              struct vor_error *err)
{
    struct vor_fetcher *fetcher = calloc(1, sizeof *fetcher);

    if (fetcher == NULL || vor_crew_create(&fetcher->crew, THREADS, WAITING_MAX, err) != VOR_OK) {
        free(fetcher);
        return vor_fail(err, VOR_E_NOMEM, "fetching stored files");
    }
    vor_crew_share(fetcher->crew, THREADS - 1, WAITING_MAX / 4);
    fetcher->blobs = blobs;
    pthread_mutex_init(&fetcher->mutex, NULL);
    *out = fetcher;
    return VOR_OK;
}

void vor_fetcher_destroy(struct vor_fetcher *fetcher)
{
    if (fetcher == NULL)
        return;
    vor_crew_destroy(fetcher->crew); /* does what waits, so that all have been woken */
    while (fetcher->list != NULL) {
        struct fetch *next = fetcher->list->next;

        free(fetcher->list);
        fetcher->list = next;
    }
    pthread_mutex_destroy(&fetcher->mutex);
    free(fetcher);
}

/* Takes a fetch off the list; the mutex is held. */
static void unlink_fetch(struct vor_fetcher *fetcher, const struct fetch *fetch)
{
    struct fetch **at = &fetcher->list;

    while (*at != fetch)
        at = &(*at)->next;
    *at = fetch->next;
}

static void run(void *ctx)
{
    struct fetch *fetch = ctx;
    struct vor_fetcher *fetcher = fetch->fetcher;
    struct waiting *waiting;
    struct vor_error error;
    uint64_t size;
    int fd = -1, found = 0, is_near;
    vor_status status =
        vor_crew_closing(fetcher->crew)
            ? vor_fail(&error, VOR_E_IO, "the daemon is stopping")
            : vor_blob_get(fetcher->blobs, &fetch->id, fetch->name, &fd, &size, &found, &error);

    if (fd >= 0)
        close(fd);
    pthread_mutex_lock(&fetcher->mutex);
    is_near = status == VOR_OK && found;
    fetch->outcome = status != VOR_OK ? VOR_FETCH_FAILED : VOR_FETCH_NONE;
    if (status != VOR_OK)
        fetch->error = error;
    fetch->since = vor_clock_seconds();
    waiting = fetch->waiting;
    fetch->waiting = NULL;
    if (is_near)
        unlink_fetch(fetcher, fetch);
    pthread_mutex_unlock(&fetcher->mutex);
    if (is_near)
        free(fetch);
    while (waiting != NULL) {
        struct waiting *next = waiting->next;

        waiting->asker.wake(waiting->asker.ctx);
        free(waiting);
        waiting = next;
    }
}

/* The fetch of a blob, NULL for none; removes those whose outcome is old. The mutex is held. */
static struct fetch *find(struct vor_fetcher *fetcher, const struct vor_uuid *id, const char *name)
{
    double now = vor_clock_seconds();
    struct fetch *found = NULL;

    for (struct fetch **at = &fetcher->list; *at != NULL;) {
        struct fetch *fetch = *at;

        if (fetch->outcome != VOR_FETCH_WAIT && now - fetch->since > outcome_seconds) {
            *at = fetch->next;
            free(fetch);
            continue;
        }
        if (strcmp(fetch->id.text, id->text) == 0 && strcmp(fetch->name, name) == 0)
            found = fetch;
        at = &fetch->next;
    }
    return found;
}

/* Begins a fetch; the mutex is held. NULL when it cannot be begun, as err says. */
static struct fetch *begin(struct vor_fetcher *fetcher, const struct vor_uuid *id, const char *name,
                           const struct vor_asker *asker, struct vor_error *err)
{
    struct fetch *fetch = calloc(1, sizeof *fetch);

    if (fetch == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "fetching a stored file");
        return NULL;
    }
    fetch->fetcher = fetcher;
    fetch->id = *id;
    memcpy(fetch->name, name, strlen(name) + 1);
    fetch->outcome = VOR_FETCH_WAIT;
    fetch->task = (struct vor_task){.run = run, .ctx = fetch, .caller = asker->caller, .weight = 1};
    if (vor_crew_take(fetcher->crew, &fetch->task, NULL) != VOR_DONE) {
        free(fetch);
        (void)vor_fail(err, VOR_E_IO, "too many stored files are being fetched; try again later");
        return NULL;
    }
    fetch->next = fetcher->list;
    fetcher->list = fetch;
    return fetch;
}

enum vor_fetched vor_fetch(struct vor_fetcher *fetcher, const struct vor_uuid *id, const char *name,
                           const struct vor_asker *asker, struct vor_error *err)
{
    enum vor_fetched outcome = VOR_FETCH_FAILED;
    struct waiting *waiting;
    struct fetch *fetch;

    if (vor_blob_is_near(fetcher->blobs, id, name))
        return VOR_FETCH_NEAR;
    waiting = calloc(1, sizeof *waiting);
    if (waiting == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "fetching a stored file");
        return VOR_FETCH_FAILED;
    }
    waiting->asker = *asker;
    pthread_mutex_lock(&fetcher->mutex);
    fetch = find(fetcher, id, name);
    if (fetch == NULL)
        fetch = begin(fetcher, id, name, asker, err);
    if (fetch != NULL)
        outcome = fetch->outcome;
    if (outcome == VOR_FETCH_WAIT) {
        waiting->next = fetch->waiting;
        fetch->waiting = waiting;
    } else if (fetch != NULL) {
        *err = fetch->error;
    }
    pthread_mutex_unlock(&fetcher->mutex);
    if (outcome != VOR_FETCH_WAIT)
        free(waiting);
    return outcome;
}
