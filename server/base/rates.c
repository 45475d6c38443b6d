#include "server/base/rates.h"

#include "server/base/principal.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Seconds' worth of tokens that a bucket holds. */
static const double burst_seconds = 2;

struct bucket {
    char name[VOR_KEY_NAME_MAX + 1];
    double tokens, holds, rate, at; /* tokens as of `at` */
    struct bucket *next;
};

struct vor_rates {
    pthread_mutex_t mutex;
    struct bucket *first;
};

struct vor_rates *vor_rates_create(void)
{
    struct vor_rates *rates = calloc(1, sizeof *rates);

    if (rates != NULL)
        (void)pthread_mutex_init(&rates->mutex, NULL);
    return rates;
}

void vor_rates_destroy(struct vor_rates *rates)
{
    if (rates == NULL)
        return;
    while (rates->first != NULL) {
        struct bucket *bucket = rates->first;

        rates->first = bucket->next;
        free(bucket);
    }
    (void)pthread_mutex_destroy(&rates->mutex);
    free(rates);
}

/* The bucket of a name, or NULL; forgets full ones on the way. The mutex is held. */
static struct bucket *find(struct vor_rates *rates, const char *name, double now)
{
    struct bucket **at = &rates->first, *found = NULL;

    while (*at != NULL) {
        struct bucket *bucket = *at;

        bucket->tokens =
            fmin(bucket->holds, bucket->tokens + fmax(0, now - bucket->at) * bucket->rate);
        bucket->at = now;
        if (strcmp(bucket->name, name) == 0) {
            found = bucket;
        } else if (bucket->tokens >= bucket->holds) {
            *at = bucket->next;
            free(bucket);
            continue;
        }
        at = &bucket->next;
    }
    return found;
}

double vor_rates_burst(double rate)
{
    return fmax(1, burst_seconds * rate);
}

double vor_rates_left(struct vor_rates *rates, const char *name, double rate, double now)
{
    double left = vor_rates_burst(rate);
    const struct bucket *bucket;

    (void)pthread_mutex_lock(&rates->mutex);
    bucket = find(rates, name, now);
    if (bucket != NULL)
        left = fmin(left, bucket->tokens);
    (void)pthread_mutex_unlock(&rates->mutex);
    return left;
}

double vor_rates_take(struct vor_rates *rates, const char *name, double rate, double now)
{
    struct bucket *bucket;
    double wait = 0;

    (void)pthread_mutex_lock(&rates->mutex);
    bucket = find(rates, name, now);
    if (bucket == NULL) {
        bucket = calloc(1, sizeof *bucket);
        if (bucket != NULL) {
            (void)snprintf(bucket->name, sizeof bucket->name, "%s", name);
            bucket->tokens = INFINITY; /* as many as it holds */
            bucket->at = now;
            bucket->next = rates->first;
            rates->first = bucket;
        }
    }
    if (bucket != NULL) {
        bucket->rate = rate;
        bucket->holds = vor_rates_burst(rate);
        bucket->tokens = fmin(bucket->tokens, bucket->holds);
        if (bucket->tokens >= 1)
            bucket->tokens -= 1;
        else
            wait = (1 - bucket->tokens) / rate;
    }
    (void)pthread_mutex_unlock(&rates->mutex);
    return wait;
}
