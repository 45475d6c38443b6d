#include "core/seeds/leash.h"

#include "core/base/linalg.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct measured {
    struct vor_seeds *seeds;
    float (*at)[4];
    float *way; /* n: from the former place; a spacing where there is none */
};

static int ascending(const void *a, const void *b)
{
    uint64_t x, y;

    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return (x > y) - (x < y);
}

/* Finds the former places of seeds. `who` has track << 32 | index of each earlier point, sorted. */
static void find_places(struct measured *measured, const uint64_t *who)
{
    struct vor_seeds *seeds = measured->seeds;
    const struct vor_previous *previous = &seeds->whole->previous;
    double spacing = sqrt(seeds->area / (VOR_HEXAGON_HEIGHT * (double)seeds->n));

    for (size_t i = 0; i < seeds->n; i++) {
        size_t low = 0, high = previous->n;

        while (low < high) {
            size_t middle = low + (high - low) / 2;

            if (who[middle] >> 32 < seeds->track[i])
                low = middle + 1;
            else
                high = middle;
        }
        measured->way[i] = (float)spacing;
        measured->at[i][3] = INFINITY;
        if (low == previous->n || who[low] >> 32 != seeds->track[i])
            continue;
        memcpy(measured->at[i], &previous->xyz[3 * (who[low] & UINT32_MAX)], 3 * sizeof(float));
        measured->way[i] = sqrtf(vor_distance2f(measured->at[i], &seeds->xyz[3 * i]));
        measured->at[i][3] = 0;
    }
}

static void reach_row(void *ctx, size_t i, unsigned worker)
{
    const struct measured *measured = ctx;
    struct vor_seeds *seeds = measured->seeds;
    const struct vor_crowd *crowd = &seeds->scratch[worker].crowd;
    double way = (double)measured->way[i], less = VOR_SEEDS_COHERENT / seeds->coherence;

    vor_seeds_crowd(seeds, &seeds->scratch[worker], i);
    for (unsigned j = 0; j < crowd->count; j++)
        way += (double)measured->way[crowd->index[j]];
    measured->at[i][3] += (float)(less * less * way / (1 + crowd->count));
}

vor_status vor_leash_make(struct vor_leash *out, struct vor_seeds *seeds, struct vor_error *err)
{
    const struct vor_previous *previous = &seeds->whole->previous;
    struct vor_memory *memory = seeds->run.memory;
    struct measured measured = {seeds, NULL, NULL};
    uint64_t *who = NULL;
    vor_status status;

    *out = (struct vor_leash){.at = NULL};
    if (seeds->track == NULL || !(seeds->coherence > 0))
        return VOR_OK;
    status = VOR_MAKE_ALL(memory, err, seeds->n, VOR_ZEROED(out->at, seeds->n, 1),
                          VOR_ARRAY(measured.way, seeds->n, 1), VOR_ARRAY(who, previous->n, 1));
    VOR_THEN(status, vor_seeds_index(seeds, &seeds->run, err));
    if (status == VOR_OK) {
        measured.at = out->at;
        out->size = seeds->n * sizeof *out->at;
        for (size_t j = 0; j < previous->n; j++)
            who[j] = (uint64_t)previous->track[j] << 32 | j;
        qsort(who, previous->n, sizeof *who, ascending);
        find_places(&measured, who);
        status = vor_run_rows(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, reach_row, &measured, err);
    }
    VOR_FREE_ALL(memory, who, measured.way);
    return status;
}

void vor_leash_hold(const struct vor_leash *leash, size_t i, double x[3])
{
    const float *at;
    double d[3], far2;

    if (leash->at == NULL)
        return;
    at = leash->at[i];
    for (int c = 0; c < 3; c++)
        d[c] = x[c] - (double)at[c];
    far2 = vor_dot(d, d);
    if (!(far2 > (double)at[3] * (double)at[3]))
        return;
    for (int c = 0; c < 3; c++)
        x[c] = (double)at[c] + (double)at[3] / sqrt(far2) * d[c];
}

void vor_leash_free(struct vor_leash *leash, struct vor_memory *memory)
{
    vor_free(memory, leash->at);
}
