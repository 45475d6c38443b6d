#include "core/method/even.h"

#include "core/base/linalg.h"

enum { OPEN_SHARE = 16 };

struct even {
    const struct vor_seeds *seeds;
    const float *xyz;
    float *nearest;
    double max_move;
};

/* Nearest of `count` candidates to seed i, at their new places. */
static double nearest_of(const struct even *even, size_t i, const uint32_t *index, unsigned count)
{
    double best = INFINITY;

    for (unsigned j = 0; j < count; j++)
        if (index[j] != i)
            best = fmin(best, vor_distance2f(&even->xyz[3 * i], &even->xyz[3 * (size_t)index[j]]));
    return sqrt(best);
}

/* Whether a seed at or beyond `reach` of the old place of i may now be nearer than `found`: it came
 * at most max_move nearer, and i itself moved. */
static int may_be_nearer(const struct even *even, size_t i, double reach, double found)
{
    double moved = sqrt(vor_distance2f(&even->xyz[3 * i], &even->seeds->xyz[3 * i]));

    return reach - moved - even->max_move < found;
}

/* Negative where even the widest search leaves it open. */
static double nearest_wide(const struct even *even, size_t i)
{
    const struct vor_seeds *seeds = even->seeds;
    uint32_t index[VOR_SEEDS_MORE_MAX];
    float distance2[VOR_SEEDS_MORE_MAX];
    unsigned width = 2 * (seeds->listed + 1);
    double found;

    for (;; width *= 2) {
        if (width > VOR_SEEDS_MORE_MAX)
            width = VOR_SEEDS_MORE_MAX;
        if (width > seeds->n)
            width = (unsigned)seeds->n;
        vor_knn_search(seeds->knn, &seeds->xyz[3 * i], 1, width, index, distance2);
        found = nearest_of(even, i, index, width);
        if (width == seeds->n || !may_be_nearer(even, i, sqrt((double)distance2[width - 1]), found))
            return found;
        if (width == VOR_SEEDS_MORE_MAX)
            return -1;
    }
}

/* From the lists; negative where a seed from beyond the list could be nearer. */
static void list_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct even *even = ctx;
    const struct vor_seeds *seeds = even->seeds;
    unsigned listed = seeds->listed;

    (void)worker;
    for (size_t i = begin; i < end; i++) {
        double found = nearest_of(even, i, &seeds->list[i * listed], listed);
        int open = listed + 1 < seeds->n &&
                   may_be_nearer(even, i, (double)seeds->distance[i * listed + listed - 1], found);

        even->nearest[i] = (float)(open ? -1 : found);
    }
}

static void wide_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct even *even = ctx;

    (void)worker;
    for (size_t i = begin; i < end; i++)
        if (even->nearest[i] < 0)
            even->nearest[i] = (float)nearest_wide(even, i);
}

static size_t count_open(const struct even *even)
{
    size_t open = 0;

    for (size_t i = 0; i < even->seeds->n; i++)
        open += even->nearest[i] < 0;
    return open;
}

/* The seeds that the lists leave open: one by one where they are few, else, or where that does not
 * close all of them, by an index of the new positions. */
static vor_status close_open(const struct even *even, struct vor_error *err)
{
    const struct vor_seeds *seeds = even->seeds;
    const struct vor_run *run = seeds->run;
    struct even work = *even;
    struct vor_knn *knn;
    vor_status status;

    if (count_open(even) <= seeds->n / OPEN_SHARE) {
        status = vor_run_for(run, seeds->n, VOR_SEEDS_BLOCK, wide_block, &work, err);
        if (status != VOR_OK || count_open(even) == 0)
            return status;
    }
    status = vor_knn_build(&knn, even->xyz, seeds->n, run->memory, err);
    if (status != VOR_OK)
        return status;
    status = vor_nearest_distances(even->nearest, even->xyz, seeds->n, knn, run, err);
    vor_knn_free(knn);
    return status;
}

vor_status vor_even_measure(struct vor_uniformity *out, float *nearest,
                            const struct vor_seeds *seeds, const float *xyz, double max_move,
                            struct vor_error *err)
{
    struct even even = {seeds, xyz, nearest, max_move};
    vor_status status = VOR_OK;

    if (seeds->n == 1) {
        nearest[0] = 0;
    } else {
        status = vor_run_for(seeds->run, seeds->n, VOR_SEEDS_BLOCK, list_block, &even, err);
        if (status == VOR_OK)
            status = close_open(&even, err);
    }
    if (status == VOR_OK)
        vor_uniformity_from(out, nearest, seeds->n);
    return status;
}
