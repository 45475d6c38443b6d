#include "server/blob/objects.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/metrics.h"

#include <errno.h>
#include <time.h>

void vor_objects_init(struct vor_objects *objects, const struct vor_objects_kind *kind)
{
    objects->kind = kind;
    pthread_mutex_init(&objects->mutex, NULL);
}

void vor_objects_destroy(struct vor_objects *objects)
{
    pthread_mutex_destroy(&objects->mutex);
}

vor_status vor_objects_state(struct vor_objects *objects, double *age, struct vor_error *err)
{
    vor_status status;

    pthread_mutex_lock(&objects->mutex);
    status = objects->state.status;
    if (status != VOR_OK && err != NULL)
        *err = objects->state;
    if (age != NULL)
        *age = vor_clock_seconds() - objects->answered;
    pthread_mutex_unlock(&objects->mutex);
    return status;
}

void vor_objects_note(struct vor_objects *objects, const struct vor_error *failure, int is_probe)
{
    pthread_mutex_lock(&objects->mutex);
    if (failure->status == VOR_OK || is_probe || vor_error_storage_away(failure))
        objects->state = *failure;
    if (failure->status == VOR_OK)
        objects->answered = vor_clock_seconds();
    pthread_mutex_unlock(&objects->mutex);
    if (failure->status != VOR_OK && !is_probe)
        vor_metric_add(VOR_METRIC_BLOB_ERRORS, 1,
                       VOR_LABELS(vor_error_storage_away(failure)      ? "away"
                                  : vor_error_storage_refused(failure) ? "refused"
                                                                       : "other"));
}

int vor_objects_are_wanted(struct vor_objects *objects, const struct vor_blob_patience *patience,
                           double sent)
{
    static const double closing_seconds = 2;

    if (atomic_load(&objects->is_closing) && vor_clock_seconds() - sent > closing_seconds)
        return 0;
    return patience == NULL || patience->is_wanted == NULL || patience->is_wanted(patience->ctx);
}

/* A half to the whole of a pause that doubles. */
int vor_objects_again(struct vor_objects *objects, int attempt, double began)
{
    enum { TRIES = 6, FIRST_PAUSE_MS = 100 };
    static const double tries_seconds = 60, away_seconds = 10;
    uint8_t part = 0;
    int64_t ms = (int64_t)FIRST_PAUSE_MS << attempt;
    struct timespec pause;
    const double most =
        vor_objects_state(objects, NULL, NULL) == VOR_OK ? tries_seconds : away_seconds;

    if (attempt + 1 == TRIES || atomic_load(&objects->is_closing) ||
        vor_clock_seconds() - began > most)
        return 0;
    vor_metric_add(VOR_METRIC_BLOB_RETRIES, 1, NULL);
    (void)(vor_random_fill(&part, sizeof part, NULL) == VOR_OK);
    ms -= ms / 2 * part / 255;
    pause = (struct timespec){.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000};
    while (nanosleep(&pause, &pause) != 0 && errno == EINTR)
        continue;
    return 1;
}
