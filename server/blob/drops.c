#include "server/blob/drops.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/machine.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Between two looks at what is away, and how old the last answer may be of what is not. */
static const double look_seconds = 1, quiet_seconds = 10;

struct drop {
    struct drop *next;
    char key[VOR_OBJECT_KEY_MAX + 1], before[VOR_OBJECT_KEY_MAX + 1]; /* "": none before it */
};

struct vor_drops {
    struct vor_objects *objects;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    struct drop *first, **end;
    const struct drop *current; /* being deleted */
    int is_closing;
};

/* Deletes one; the mutex is held before and after. */
static void delete_first(struct vor_drops *drops)
{
    struct drop *drop = drops->first;
    struct vor_error err;
    vor_status status = VOR_OK;

    drops->first = drop->next;
    if (drops->first == NULL)
        drops->end = &drops->first;
    drops->current = drop;
    pthread_mutex_unlock(&drops->mutex);
    if (drop->before[0] != '\0')
        status = drops->objects->kind->remove(drops->objects, drop->before, &err);
    VOR_THEN(status, drops->objects->kind->remove(drops->objects, drop->key, &err));
    if (status != VOR_OK)
        vor_log(VOR_LOG_WARN, "file not deleted", VOR_TEXT("key", drop->key),
                VOR_TEXT("error", err.message));
    pthread_mutex_lock(&drops->mutex);
    drops->current = NULL;
    free(drop);
    while (status != VOR_OK && drops->is_closing && drops->first != NULL) {
        drop = drops->first;
        drops->first = drop->next;
        free(drop);
    }
    pthread_cond_broadcast(&drops->changed);
}

/* Asks whether they are there where nobody else has for a while, or they were not; the mutex is
 * held before and after. */
static void probe(struct vor_drops *drops)
{
    double age;

    pthread_mutex_unlock(&drops->mutex);
    if (vor_objects_state(drops->objects, &age, NULL) != VOR_OK || age > quiet_seconds)
        (void)(drops->objects->kind->probe(drops->objects, NULL) ==
               VOR_OK); /* vor_objects_state tells */
    pthread_mutex_lock(&drops->mutex);
}

static void *delete_all(void *ctx)
{
    struct vor_drops *drops = ctx;

    pthread_mutex_lock(&drops->mutex);
    while (drops->first != NULL || !drops->is_closing)
        if (drops->first != NULL)
            delete_first(drops);
        else if (vor_clock_wait(&drops->changed, &drops->mutex, vor_clock_seconds() + look_seconds))
            probe(drops);
    pthread_mutex_unlock(&drops->mutex);
    return NULL;
}

vor_status vor_drops_create(struct vor_drops **out, struct vor_objects *objects,
                            struct vor_error *err)
{
    struct vor_drops *drops = calloc(1, sizeof *drops);

    if (drops != NULL) {
        drops->objects = objects;
        drops->end = &drops->first;
        pthread_mutex_init(&drops->mutex, NULL);
        vor_clock_condition(&drops->changed);
    }
    if (drops == NULL || vor_machine_thread(&drops->thread, "vor-drops", delete_all, drops) != 0) {
        free(drops);
        return vor_fail(err, VOR_E_NOMEM, "a thread that deletes files");
    }
    *out = drops;
    return VOR_OK;
}

void vor_drops_destroy(struct vor_drops *drops)
{
    if (drops == NULL)
        return;
    pthread_mutex_lock(&drops->mutex);
    drops->is_closing = 1;
    pthread_cond_broadcast(&drops->changed);
    pthread_mutex_unlock(&drops->mutex);
    pthread_join(drops->thread, NULL);
    pthread_cond_destroy(&drops->changed);
    pthread_mutex_destroy(&drops->mutex);
    free(drops);
}

vor_status vor_drop(struct vor_drops *drops, const char *key, const char *before,
                    struct vor_error *err)
{
    struct drop *drop = calloc(1, sizeof *drop);

    if (drop == NULL)
        return vor_fail(err, VOR_E_NOMEM, "deleting a file");
    (void)snprintf(drop->key, sizeof drop->key, "%s", key);
    (void)snprintf(drop->before, sizeof drop->before, "%s", before);
    pthread_mutex_lock(&drops->mutex);
    *drops->end = drop;
    drops->end = &drop->next;
    pthread_cond_broadcast(&drops->changed);
    pthread_mutex_unlock(&drops->mutex);
    return VOR_OK;
}

void vor_drop_not(struct vor_drops *drops, const char *key)
{
    pthread_mutex_lock(&drops->mutex);
    for (struct drop **at = &drops->first; *at != NULL;) {
        struct drop *drop = *at;

        if (strcmp(drop->key, key) != 0) {
            at = &drop->next;
            continue;
        }
        *at = drop->next;
        if (drops->end == &drop->next)
            drops->end = at;
        free(drop);
    }
    while (drops->current != NULL && strcmp(drops->current->key, key) == 0)
        pthread_cond_wait(&drops->changed, &drops->mutex);
    pthread_mutex_unlock(&drops->mutex);
}
