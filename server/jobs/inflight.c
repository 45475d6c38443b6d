#include "server/jobs/inflight.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* There are no more of them than connections, so a list will do. */
struct held {
    struct vor_job_key key;
    struct held *next;
};

struct vor_inflight {
    pthread_mutex_t mutex;
    struct held *first;
};

struct vor_inflight *vor_inflight_create(void)
{
    struct vor_inflight *inflight = calloc(1, sizeof *inflight);

    if (inflight != NULL)
        pthread_mutex_init(&inflight->mutex, NULL);
    return inflight;
}

void vor_inflight_destroy(struct vor_inflight *inflight)
{
    if (inflight == NULL)
        return;
    while (inflight->first != NULL) {
        struct held *held = inflight->first;

        inflight->first = held->next;
        free(held);
    }
    pthread_mutex_destroy(&inflight->mutex);
    free(inflight);
}

/* The place of a key in the list, or that of NULL at its end; the mutex is held. */
static struct held **place_of(struct vor_inflight *inflight, const struct vor_job_key *key)
{
    struct held **at = &inflight->first;

    while (*at != NULL && (strcmp((*at)->key.text, key->text) != 0 ||
                           strcmp((*at)->key.principal, key->principal) != 0))
        at = &(*at)->next;
    return at;
}

enum vor_job_outcome vor_inflight_begin(struct vor_inflight *inflight,
                                        const struct vor_job_key *key)
{
    enum vor_job_outcome outcome = VOR_CONFLICT;
    struct held *held = malloc(sizeof *held);
    struct held **at;

    if (held == NULL)
        return VOR_FAILED;
    *held = (struct held){.key = *key};
    pthread_mutex_lock(&inflight->mutex);
    at = place_of(inflight, key);
    if (*at == NULL) {
        *at = held;
        held = NULL;
        outcome = VOR_DONE;
    }
    pthread_mutex_unlock(&inflight->mutex);
    free(held);
    return outcome;
}

void vor_inflight_end(struct vor_inflight *inflight, const struct vor_job_key *key)
{
    struct held **at, *held;

    pthread_mutex_lock(&inflight->mutex);
    at = place_of(inflight, key);
    held = *at;
    assert(held != NULL);
    *at = held->next;
    pthread_mutex_unlock(&inflight->mutex);
    free(held);
}
