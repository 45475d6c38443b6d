#include "core/knn/input_lists.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/knn/listed.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* Most entries of a list. */
enum { WIDE_MAX = 1024 };

/* Added to the neighbours of a list that no search has seen. */
enum { UNSEEN = 1 << 15 };

/* Factor by which a distance in float32 may be off, and more: it has six roundings of 6e-8. */
#define ROUNDING 1.00001f

/* Entries of a list that answers k neighbours: half as many again, the margin for moves. With a
 * quarter / half / as many again: searches on igea 57 / 45 / 38 thousand, on autzen 217 / 198 / 174
 * thousand, and 6 bytes a neighbour and seed become 5 / 6 / 8. Two more for rounding. */
static unsigned width(const struct vor_input_lists *lists, unsigned k)
{
    unsigned wide = (lists->still ? k : k + k / 2) + 2;

    return wide < lists->m ? wide : (unsigned)lists->m;
}

/* Forgets every list, and finds how far the next ones are likely to extend: the median at a few
 * places. Where it is wrong, only time is lost. */
static void forget(struct vor_input_lists *lists)
{
    uint32_t index[VOR_KNN_NEAR_MAX];
    float distance2[VOR_KNN_NEAR_MAX], far2[VOR_KNN_NEAR_MAX];

    for (size_t i = 0; i < lists->n; i++)
        lists->reach[i] = -1;
    lists->tried = lists->m < VOR_KNN_NEAR_MAX ? (unsigned)lists->m : VOR_KNN_NEAR_MAX;
    for (size_t i = 0; i < VOR_KNN_NEAR_MAX; i++) {
        vor_knn_search(lists->knn, &lists->reference[3 * (i * lists->m / VOR_KNN_NEAR_MAX)], 1,
                       lists->tried, index, distance2);
        far2[i] = distance2[lists->tried - 1];
    }
    vor_sort_floats(far2, VOR_KNN_NEAR_MAX);
    lists->far2 = far2[VOR_KNN_NEAR_MAX / 2];
}

vor_status vor_input_lists_init(struct vor_input_lists *out, size_t n,
                                const struct vor_input_lists_of *of, struct vor_memory *memory,
                                struct vor_error *err)
{
    struct vor_input_lists lists = {.memory = memory,
                                    .knn = of->knn,
                                    .reference = of->reference,
                                    .n = n,
                                    .m = of->m,
                                    .most = of->most,
                                    .still = of->still};

    lists.wide = width(&lists, of->most);
    lists.k = vor_calloc(memory, n, sizeof *lists.k);
    lists.has = vor_calloc(memory, n, sizeof *lists.has);
    lists.list = vor_malloc(memory, n, lists.wide * sizeof *lists.list);
    lists.anchor = vor_malloc(memory, n, 3 * sizeof *lists.anchor);
    lists.reach = vor_malloc(memory, n, sizeof *lists.reach);
    if (lists.k == NULL || lists.has == NULL || lists.list == NULL || lists.anchor == NULL ||
        lists.reach == NULL) {
        vor_input_lists_free(&lists);
        return vor_fail(err, VOR_E_NOMEM, "lists of %u neighbours for %zu points", lists.wide, n);
    }
    forget(&lists);
    *out = lists;
    return VOR_OK;
}

void vor_input_lists_onto(struct vor_input_lists *lists, const struct vor_knn *knn,
                          const float *reference, size_t m)
{
    assert(m >= lists->wide);
    lists->knn = knn;
    lists->reference = reference;
    lists->m = m;
    forget(lists);
}

void vor_input_lists_free(struct vor_input_lists *lists)
{
    VOR_FREE_ALL(lists->memory, lists->reach, lists->anchor, lists->list, lists->has, lists->k);
    memset(lists, 0, sizeof *lists);
}

static float squared(const float a[3], const float b[3])
{
    float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];

    return x * x + y * y + z * z;
}

static void swap(uint32_t *list, float *distance2, unsigned a, unsigned b)
{
    uint32_t index = list[a];
    float d2 = distance2[a];

    list[a] = list[b];
    list[b] = index;
    distance2[a] = distance2[b];
    distance2[b] = d2;
}

/* Moves the k nearest of the list's entries to its front by exchanging the farthest of the front
 * with the nearest of the rest; a query that moved a little needs none or one or two exchanges.
 * Returns their number; *last is the distance of the farthest of the front. */
static unsigned select(const struct vor_input_lists *lists, size_t i, unsigned k, const float x[3],
                       float *last)
{
    uint32_t *list = &lists->list[i * lists->wide];
    float distance2[VOR_LISTED_ROOM(WIDE_MAX)], most;
    unsigned exchanged = 0, wide = lists->has[i], out, in;

    vor_listed_distances(distance2, lists->reference, list, wide, x);
    for (;; exchanged++) {
        most = vor_listed_largest(distance2, k);
        if (k == wide)
            break;
        in = k + vor_listed_first(&distance2[k], wide - k);
        if (most <= distance2[in])
            break;
        for (out = 0; distance2[out] < most;)
            out++;
        swap(list, distance2, out, in);
    }
    *last = sqrtf(most);
    swap(list, distance2, 0, vor_listed_first(distance2, k));
    return exchanged;
}

/* Notes that a new list has been made for k neighbours, of which the last is that far. */
static void note(struct vor_input_lists *lists, size_t i, const float x[3], unsigned k, float last2)
{
    unsigned wide = width(lists, k & ~(unsigned)UNSEEN);

    memcpy(&lists->anchor[3 * i], x, 3 * sizeof *x);
    lists->reach[i] = wide < lists->m ? sqrtf(last2) : INFINITY;
    lists->k[i] = (uint16_t)k;
    lists->has[i] = (uint16_t)wide;
}

void vor_input_lists_nearest(const struct vor_input_lists *lists, const float x[3], unsigned k,
                             uint32_t *index, float *distance2)
{
    struct vor_knn_near near = {x, 1, k, NULL, vor_knn_near_guess(lists->far2, lists->tried, k)};

    vor_knn_search_near(lists->knn, &near, index, distance2);
}

void vor_input_lists_make(struct vor_input_lists *lists, size_t first, size_t count,
                          const float *xyz, unsigned k)
{
    uint32_t index[VOR_KNN_NEAR_MAX * VOR_INPUT_LISTS_TOGETHER];
    float distance2[VOR_KNN_NEAR_MAX * VOR_INPUT_LISTS_TOGETHER];
    unsigned wide = width(lists, k);
    struct vor_knn_near near = {.k = wide,
                                .guess = vor_knn_near_guess(lists->far2, lists->tried, wide)};

    for (size_t from = first; wide <= VOR_INPUT_LISTS_TOGETHER && from < first + count;
         from += near.count) {
        near.queries = &xyz[3 * from];
        near.count =
            first + count - from < VOR_KNN_NEAR_MAX ? first + count - from : VOR_KNN_NEAR_MAX;
        vor_knn_search_near(lists->knn, &near, index, distance2);
        for (size_t i = 0; i < near.count; i++) {
            memcpy(&lists->list[(from + i) * lists->wide], &index[i * wide], wide * sizeof *index);
            note(lists, from + i, &xyz[3 * (from + i)], k | UNSEEN, distance2[(i + 1) * wide - 1]);
        }
    }
}

enum vor_input_lists_found vor_input_lists_search(struct vor_input_lists *lists, size_t i,
                                                  const float x[3], unsigned k,
                                                  const uint32_t **index)
{
    uint32_t *list = &lists->list[i * lists->wide];
    float distance2[WIDE_MAX], within = INFINITY;
    unsigned wide = width(lists, k);
    struct vor_knn_near near = {x, 1, wide, NULL, 0};

    assert(k >= 1 && k <= lists->most);
    *index = list;
    if (lists->reach[i] >= 0 && lists->k[i] == (k | UNSEEN) &&
        !(squared(&lists->anchor[3 * i], x) > 0)) {
        lists->k[i] = (uint16_t)k;
        return VOR_INPUT_LISTS_ANEW;
    }
    if (lists->reach[i] >= 0 && lists->k[i] == k) {
        float moved = sqrtf(squared(&lists->anchor[3 * i], x));

        if (moved < lists->reach[i]) {
            float last;
            unsigned exchanged = select(lists, i, vor_input_lists_count(lists, i), x, &last);

            /* A point that is not in the list is at least reach - moved away. */
            if ((last + moved) * ROUNDING <= lists->reach[i])
                return exchanged > 0 ? VOR_INPUT_LISTS_OTHER : VOR_INPUT_LISTS_SAME;
        }
    }
    /* The points of the list that is given up are still as many, so far from here at most. */
    if (lists->reach[i] >= 0 && wide <= lists->has[i])
        within = lists->reach[i] + sqrtf(squared(&lists->anchor[3 * i], x));
    near.within = within < INFINITY ? &within : NULL;
    near.guess = vor_knn_near_guess(lists->far2, lists->tried, wide);
    vor_knn_search_near(lists->knn, &near, list, distance2);
    note(lists, i, x, k, distance2[wide - 1]);
    return VOR_INPUT_LISTS_ANEW;
}

void vor_input_lists_narrow(struct vor_input_lists *lists, size_t i, const float x[3],
                            const uint32_t *index, unsigned count, float reach)
{
    unsigned wide = width(lists, lists->k[i]), has = count < wide ? count : wide;
    uint32_t *list = &lists->list[i * lists->wide];

    assert(count >= 1 && lists->reach[i] >= 0);
    memcpy(list, index, has * sizeof *list);
    memcpy(&lists->anchor[3 * i], x, 3 * sizeof *x);
    lists->has[i] = (uint16_t)has;
    lists->reach[i] = reach;
    if (has < count)
        lists->reach[i] = sqrtf(squared(&lists->reference[3 * (size_t)index[has - 1]], x));
}

unsigned vor_input_lists_around(const struct vor_input_lists *lists, size_t i, const float x[3],
                                unsigned k, uint32_t *index)
{
    const uint32_t *list = &lists->list[i * lists->wide];
    unsigned wide = lists->has[i], count = 0;
    float distance2[WIDE_MAX], all2[VOR_LISTED_ROOM(WIDE_MAX)], sure;

    assert(k >= 1 && k <= WIDE_MAX);
    memset(distance2, 0, k * sizeof *distance2); /* clang-analyzer cannot see that count <= k */
    if (lists->reach[i] < 0)
        return 0;
    sure = lists->reach[i] - sqrtf(squared(&lists->anchor[3 * i], x));
    vor_listed_distances(all2, lists->reference, list, wide, x);
    for (unsigned j = 0; j < wide; j++) {
        float d2 = all2[j];
        unsigned at;

        if (sqrtf(d2) * ROUNDING > sure || (count == k && d2 >= distance2[k - 1]))
            continue;
        count += count < k;
        for (at = count - 1; at > 0 && d2 < distance2[at - 1]; at--) {
            distance2[at] = distance2[at - 1];
            index[at] = index[at - 1];
        }
        distance2[at] = d2;
        index[at] = list[j];
    }
    return count;
}

uint32_t vor_input_lists_at(const struct vor_input_lists *lists, size_t i, const double x[3])
{
    const float at[3] = {(float)x[0], (float)x[1], (float)x[2]};
    const uint32_t *list = &lists->list[i * lists->wide];
    float distance2;
    uint32_t point;

    for (unsigned j = 0; lists->reach[i] >= 0 && j < lists->has[i]; j++)
        if (vor_distance2f(&lists->reference[3 * (size_t)list[j]], at) == 0)
            return list[j];
    vor_knn_search(lists->knn, at, 1, 1, &point, &distance2);
    return point;
}
