#include "core/seeds/uniformity.h"

#include "core/base/linalg.h"

/* Spacings that a seed may have moved since lists were made for other positions, before it is a
 * jumper. At half of it 64 / at it 45 / at double 46 thousand searches on igea, 234 / 198 / 231 on
 * autzen. */
#define FAR (2 * VOR_POINT_LISTS_FAR)

/* Positions whose uniformity is asked for. */
struct even {
    const struct vor_seeds *seeds;
    struct vor_point_lists_view view;
    float *nearest;
    const struct vor_run *run;
    struct vor_knn *knn; /* of the positions, where there is a metric and lists do not serve */
};

/* Distance from seed i to its nearest neighbour by wider and wider searches; negative when even the
 * widest is not certain. */
static double nearest_wide(const struct even *even, size_t i, struct vor_scratch *scratch)
{
    const struct vor_seeds *seeds = even->seeds;
    const struct vor_point_lists_view *view = &even->view;
    uint32_t index[VOR_SEEDS_MORE_MAX];
    float distance2[VOR_SEEDS_MORE_MAX];
    size_t width = 2 * (seeds->point_lists.listed + 1);

    for (;; width *= 2) {
        double found = INFINITY, sure;

        width = width < VOR_SEEDS_MORE_MAX ? width : VOR_SEEDS_MORE_MAX;
        width = width < seeds->n ? width : seeds->n;
        sure =
            vor_point_lists_wide(&seeds->point_lists, view, i, (unsigned)width, index, distance2);
        scratch->queries++;
        for (size_t j = 0; j < width; j++)
            if (index[j] != i)
                found = fmin(found,
                             vor_distance2f(&view->xyz[3 * i], &view->xyz[3 * (size_t)index[j]]));
        for (unsigned j = 0; j < view->jumpers; j++)
            if (view->jumper[j] != i)
                found = fmin(found, vor_distance2f(&view->xyz[3 * i],
                                                   &view->xyz[3 * (size_t)view->jumper[j]]));
        found = sqrt(found);
        if (found <= sure)
            return found;
        if (width == VOR_SEEDS_MORE_MAX)
            return -1;
    }
}

/* Distances from the lists; negative where a seed beyond the list could be nearer. */
static void list_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct even *even = ctx;

    even->nearest[i] = (float)vor_point_lists_nearest(&even->seeds->point_lists, &even->view, i);
}

static void wide_row(void *ctx, size_t i, unsigned worker)
{
    const struct even *even = ctx;
    struct vor_scratch *scratch = &even->seeds->scratch[worker];

    if (even->nearest[i] < 0)
        even->nearest[i] = (float)nearest_wide(even, i, scratch);
}

static size_t count_open(const struct even *even)
{
    size_t open = 0;

    for (size_t i = 0; i < even->seeds->n; i++)
        open += even->nearest[i] < 0;
    return open;
}

/* Distances by a new index of the positions. */
static vor_status search_all(const struct even *even, struct vor_error *err)
{
    const struct vor_run *run = even->run;
    struct vor_knn *knn;
    vor_status status = vor_knn_build(&knn, even->view.xyz, even->seeds->n, run->memory, err);

    if (status != VOR_OK)
        return status;
    status = vor_nearest_distances(even->nearest, even->view.xyz, even->seeds->n, knn, run, err);
    even->seeds->scratch[0].queries += even->seeds->n;
    vor_knn_free(knn);
    return status;
}

/* Distances by the lists. Where these leave few seeds open, a search for each of them; where they
 * leave many, or the searches leave some, an index of all, which is cheaper than so many searches:
 * from one seed in 8 or in 32 on, no count changes on igea and autzen. */
static vor_status measure(struct even *even, struct vor_error *err)
{
    const struct vor_seeds *seeds = even->seeds;
    vor_status status = vor_run_rows(even->run, seeds->n, VOR_SEEDS_BLOCK, list_row, even, err);

    if (status != VOR_OK || count_open(even) == 0)
        return status;
    if (count_open(even) <= seeds->n / VOR_SEEDS_LISTED) {
        status = vor_run_rows(even->run, seeds->n, VOR_SEEDS_BLOCK, wide_row, even, err);
        if (status != VOR_OK || count_open(even) == 0)
            return status;
    }
    return search_all(even, err);
}

/* Smallest distance, in the metric, from seed i to those of a list; that may hold i itself. */
static double nearest_of(const struct even *even, size_t i, const uint32_t *index, size_t count)
{
    const float *xyz = even->view.xyz, *a = &xyz[3 * i];
    double best = INFINITY;

    for (size_t j = 0; j < count; j++) {
        const float *b = &xyz[3 * (size_t)index[j]];
        double d[3] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                       (double)b[2] - (double)a[2]};

        if (index[j] != i)
            best = fmin(best, vor_stretched_length2(&even->seeds->stretched, i, index[j], d));
    }
    return sqrt(best);
}

/* Distance in the metric to the nearest neighbour. Where the list leaves it open, a
 * wide search answers; beyond that, nothing is near in any metric allowed. */
static void stretched_row(void *ctx, size_t i, unsigned worker)
{
    const struct even *even = ctx;
    const struct vor_seeds *seeds = even->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    struct vor_crowd *crowd = &scratch->crowd;
    double longest = vor_stretched_longest_of_all(&seeds->stretched);
    unsigned width = seeds->n < VOR_SEEDS_MORE_MAX ? (unsigned)seeds->n : VOR_SEEDS_MORE_MAX;
    uint32_t index[VOR_SEEDS_MORE_MAX];
    float distance2[VOR_SEEDS_MORE_MAX];
    double found;

    vor_point_lists_candidates(crowd, &seeds->point_lists, &even->view, i);
    found = nearest_of(even, i, crowd->index, crowd->count);
    if (!(found * longest <= crowd->sure)) {
        (void)vor_point_lists_wide(&seeds->point_lists, &even->view, i, width, index, distance2);
        scratch->queries++;
        found = fmin(found, nearest_of(even, i, index, width));
    }
    even->nearest[i] = (float)found;
}

/* The same by an index of the positions. */
static void searched_row(void *ctx, size_t i, unsigned worker)
{
    const struct even *even = ctx;
    const struct vor_seeds *seeds = even->seeds;
    unsigned width = seeds->n < VOR_SEEDS_MORE_MAX ? (unsigned)seeds->n : VOR_SEEDS_MORE_MAX;
    uint32_t index[VOR_SEEDS_MORE_MAX];
    float distance2[VOR_SEEDS_MORE_MAX];

    vor_knn_search(even->knn, &even->view.xyz[3 * i], 1, width, index, distance2);
    seeds->scratch[worker].queries++;
    even->nearest[i] = (float)nearest_of(even, i, index, width);
}

/* Distances in the metric. */
static vor_status measure_stretched(struct even *even, int looked, struct vor_error *err)
{
    const struct vor_run *run = even->run;
    size_t n = even->seeds->n;
    vor_status status;

    if (looked)
        return vor_run_rows(run, n, VOR_SEEDS_BLOCK, stretched_row, even, err);
    status = vor_knn_build(&even->knn, even->view.xyz, n, run->memory, err);
    if (status != VOR_OK)
        return status;
    status = vor_run_rows(run, n, VOR_SEEDS_BLOCK, searched_row, even, err);
    vor_knn_free(even->knn);
    return status;
}

vor_status vor_seeds_uniformity(struct vor_uniformity *out, float *nearest,
                                const struct vor_seeds *seeds, const float *xyz,
                                const struct vor_run *run, struct vor_error *err)
{
    struct even even = {.seeds = seeds, .nearest = nearest, .run = run};
    vor_status status = VOR_OK;

    even.view.xyz = xyz;
    if (seeds->n == 1)
        nearest[0] = 0;
    else if (vor_stretched_are(&seeds->stretched))
        status = measure_stretched(
            &even,
            vor_point_lists_look(&even.view, &seeds->point_lists, xyz,
                                 FAR * vor_stretched_longest_of_all(&seeds->stretched)),
            err);
    else if (vor_point_lists_look(&even.view, &seeds->point_lists, xyz, FAR))
        status = measure(&even, err);
    else
        status = search_all(&even, err);
    if (status != VOR_OK)
        return status;
    if (seeds->wanted.value != NULL)
        vor_wanted_uniformity(out, &seeds->wanted, nearest, xyz);
    else
        vor_uniformity_from(out, nearest, seeds->n);
    return VOR_OK;
}

vor_status vor_seeds_uniformity_now(struct vor_uniformity *out, float *nearest,
                                    struct vor_seeds *seeds, struct vor_error *err)
{
    vor_status status = vor_seeds_index(seeds, &seeds->run, err);

    if (status != VOR_OK)
        return status;
    return vor_seeds_uniformity(out, nearest, seeds, seeds->xyz, &seeds->run, err);
}

vor_status vor_seeds_distances(float *nearest, const struct vor_seeds *seeds, struct vor_error *err)
{
    struct even even = {.seeds = seeds, .nearest = nearest, .run = &seeds->run};

    even.view.xyz = seeds->xyz;
    if (seeds->n > 1)
        return search_all(&even, err);
    nearest[0] = 0;
    return VOR_OK;
}

/* Seeds around seed i and their metric, as of the last index. */
static unsigned near_seed(void *ctx, size_t i, unsigned worker, float *offset, double metric[6])
{
    struct vor_seeds *seeds = ctx;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    const struct vor_crowd *crowd = &scratch->crowd;
    unsigned k = 0;

    vor_seeds_crowd(seeds, scratch, i);
    for (; k < crowd->count && k < VOR_CELLS_NEAR; k++)
        for (size_t c = 0; c < 3; c++)
            offset[3 * k + c] = seeds->xyz[3 * (size_t)crowd->index[k] + c] - seeds->xyz[3 * i + c];
    for (int c = 0; c < 6 && vor_stretched_are(&seeds->stretched); c++)
        metric[c] = (double)seeds->stretched.near[i].tensor[c];
    return k;
}

static void list_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct vor_seeds *seeds = ctx;
    uint32_t who[VOR_SEEDS_BLOCK];

    for (size_t i = begin; i < end; i++)
        who[i - begin] = (uint32_t)i;
    vor_seeds_crowd_ahead(seeds, &seeds->scratch[worker], who, end - begin);
}

vor_status vor_seeds_cells(struct vor_cells *out, struct vor_seeds *seeds, struct vor_error *err)
{
    vor_status status = vor_run_for(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, list_block, seeds, err);

    VOR_THEN(status, vor_cells_of(out, seeds->n, near_seed, seeds, &seeds->run, err));
    return status;
}
