#include "server/jobs/preview.h"

#include "server/base/clock.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct vor_preview {
    atomic_uint lookers;
    _Atomic double elsewhere; /* somebody looks by another daemon, until then */
    pthread_mutex_t mutex;    /* what follows */
    struct vor_preview_info info;
    uint32_t attempt; /* of what was unpacked */
    double origin[3];
    float *xyz; /* info.points x 3, room for all that may be; NULL: never looked at */
};

struct vor_preview *vor_preview_create(void)
{
    struct vor_preview *preview = calloc(1, sizeof *preview);

    if (preview == NULL)
        return NULL;
    atomic_init(&preview->lookers, 0);
    pthread_mutex_init(&preview->mutex, NULL);
    return preview;
}

void vor_preview_destroy(struct vor_preview *preview)
{
    if (preview == NULL)
        return;
    pthread_mutex_destroy(&preview->mutex);
    free(preview->xyz);
    free(preview);
}

void vor_preview_look(struct vor_preview *preview)
{
    atomic_fetch_add(&preview->lookers, 1);
}

void vor_preview_look_away(struct vor_preview *preview)
{
    atomic_fetch_sub(&preview->lookers, 1);
}

void vor_preview_look_elsewhere(struct vor_preview *preview, double until)
{
    atomic_store(&preview->elsewhere, until);
}

int vor_preview_is_looked_at_here(const struct vor_preview *preview)
{
    return atomic_load_explicit(&preview->lookers, memory_order_relaxed) > 0;
}

int vor_preview_is_looked_at_elsewhere(const struct vor_preview *preview, double seconds)
{
    double until = atomic_load_explicit(&preview->elsewhere, memory_order_relaxed);

    return until > 0 && until > vor_clock_seconds() + seconds;
}

int vor_preview_is_looked_at(const struct vor_preview *preview)
{
    return vor_preview_is_looked_at_here(preview) || vor_preview_is_looked_at_elsewhere(preview, 0);
}

/* The mutex is held. */
static int has_room(struct vor_preview *preview)
{
    if (preview->xyz == NULL)
        preview->xyz = malloc((size_t)VOR_PREVIEW_POINTS_MAX * 3 * sizeof *preview->xyz);
    return preview->xyz != NULL;
}

void vor_preview_put(struct vor_preview *preview, const struct vor_shown *shown)
{
    size_t count = vor_shown_count(shown->moving.n, VOR_PREVIEW_POINTS_MAX);

    pthread_mutex_lock(&preview->mutex);
    if (has_room(preview) && count > 0) {
        for (size_t i = 0; i < count; i++)
            vor_shown_point(&shown->moving, i, count, &preview->xyz[3 * i]);
        memcpy(preview->origin, shown->origin, sizeof preview->origin);
        preview->info = (struct vor_preview_info){preview->info.version + 1, count,
                                                  shown->iteration, shown->polish};
    }
    pthread_mutex_unlock(&preview->mutex);
}

void vor_preview_describe(struct vor_preview *preview, struct vor_preview_info *out)
{
    pthread_mutex_lock(&preview->mutex);
    *out = preview->info;
    pthread_mutex_unlock(&preview->mutex);
}

/* What stands before the points. */
struct head {
    double origin[3];
    uint32_t iteration, polish;
};

uint8_t *vor_preview_pack(struct vor_preview *preview, size_t *size, uint64_t *version)
{
    struct head head;
    uint8_t *bytes = NULL;

    pthread_mutex_lock(&preview->mutex);
    head = (struct head){.iteration = preview->info.iteration, .polish = preview->info.polish};
    memcpy(head.origin, preview->origin, sizeof head.origin);
    *version = preview->info.version;
    *size = sizeof head + preview->info.points * 3 * sizeof *preview->xyz;
    if (preview->info.points > 0)
        bytes = malloc(*size);
    if (bytes != NULL) {
        memcpy(bytes, &head, sizeof head);
        memcpy(bytes + sizeof head, preview->xyz, *size - sizeof head);
    }
    pthread_mutex_unlock(&preview->mutex);
    return bytes;
}

void vor_preview_unpack(struct vor_preview *preview, uint32_t attempt, uint64_t version,
                        const uint8_t *bytes, size_t size)
{
    const size_t point = 3 * sizeof *preview->xyz;
    size_t count = size > sizeof(struct head) ? (size - sizeof(struct head)) / point : 0;
    struct head head;

    if (count == 0 || count > VOR_PREVIEW_POINTS_MAX || size != sizeof head + count * point)
        return;
    memcpy(&head, bytes, sizeof head);
    pthread_mutex_lock(&preview->mutex);
    if (has_room(preview)) {
        memcpy(preview->xyz, bytes + sizeof head, count * point);
        memcpy(preview->origin, head.origin, sizeof head.origin);
        preview->attempt = attempt;
        preview->info = (struct vor_preview_info){version, count, head.iteration, head.polish};
    }
    pthread_mutex_unlock(&preview->mutex);
}

uint64_t vor_preview_unpacked(struct vor_preview *preview, uint32_t attempt)
{
    uint64_t version;

    pthread_mutex_lock(&preview->mutex);
    version = preview->attempt == attempt ? preview->info.version : 0;
    pthread_mutex_unlock(&preview->mutex);
    return version;
}

/* The mutex is held. */
static vor_status copy_locked(const struct vor_preview *preview, size_t most, struct vor_cloud *out,
                              struct vor_error *err)
{
    struct vor_moving moving = {.xyz = preview->xyz, .n = preview->info.points, .unit = 1};
    size_t count = vor_shown_count(moving.n, most);
    vor_status status;

    if (preview->info.version == 0)
        return vor_fail(err, VOR_E_EMPTY, "there is no preview yet");
    status = vor_cloud_resize(out, count, err);
    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < count; i++)
        vor_shown_point(&moving, i, count, &out->xyz[3 * i]);
    memcpy(out->origin, preview->origin, sizeof out->origin);
    for (int c = 0; c < 3; c++) /* else float32 holds them as they came */
        if (out->origin[c] != 0)
            out->position_type = VOR_FLOAT64;
    return VOR_OK;
}

vor_status vor_preview_cloud(struct vor_preview *preview, size_t most, struct vor_cloud *out,
                             struct vor_preview_info *info, struct vor_error *err)
{
    vor_status status;

    pthread_mutex_lock(&preview->mutex);
    status = copy_locked(preview, most, out, err);
    *info = preview->info;
    pthread_mutex_unlock(&preview->mutex);
    return status;
}
