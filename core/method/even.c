#include "core/method/even.h"

#include "core/base/linalg.h"

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

/* Whether a seed at or beyond `reach` of the old place of i may now be nearer than `found`: it came at
 * most max_move nearer, and i itself moved. */
static int may_be_nearer(const struct even *even, size_t i, double reach, double found)
{
    double moved = sqrt(vor_distance2f(&even->xyz[3 * i], &even->seeds->xyz[3 * i]));

    return reach - moved - even->max_move < found;
}

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
        if (width == seeds->n || width == VOR_SEEDS_MORE_MAX ||
            !may_be_nearer(even, i, sqrt((double)distance2[width - 1]), found))
            return found;
    }
}

static void even_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct even *even = ctx;
    const struct vor_seeds *seeds = even->seeds;
    unsigned listed = seeds->listed;

    (void)worker;
    for (size_t i = begin; i < end; i++) {
        double found = nearest_of(even, i, &seeds->list[i * listed], listed);

        if (listed + 1 < seeds->n &&
            may_be_nearer(even, i, (double)seeds->distance[i * listed + listed - 1], found))
            found = nearest_wide(even, i);
        even->nearest[i] = (float)found;
    }
}

enum vor_answer vor_even_measure(struct vor_uniformity *out, float *nearest,
                                 const struct vor_seeds *seeds, const float *xyz, double max_move)
{
    struct even even = {seeds, xyz, nearest, max_move};
    enum vor_answer answer = VOR_CONTINUE;

    if (seeds->n == 1)
        nearest[0] = 0;
    else
        answer = vor_parallel_for(seeds->run->pool, seeds->run->watch, seeds->n, VOR_SEEDS_BLOCK,
                                  even_block, &even);
    if (answer == VOR_CONTINUE)
        vor_uniformity_from(out, nearest, seeds->n);
    return answer;
}
