/* The door to two structures: arguments are checked here, for both. */
#include "core/knn/knn.h"

#include "core/base/linalg.h"
#include "core/base/morton.h"
#include "core/knn/knn_boxes.h"
#include "core/knn/knn_flann.h"
#include "core/knn/knn_join.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* Largest coordinate, also of a query: squared distances stay finite. A domain has 1, and more only
 * where a point is remote. */
#define COORDINATE_MAX 1e15f

/* Points of one task. */
enum { BLOCK = 1 << 15 };

struct vor_knn {
    struct vor_memory *memory;
    size_t n;
    struct vor_flann *flann; /* one of the two is not NULL */
    struct vor_boxes *boxes;
    float *sorted;   /* the points in boxes, and ... */
    uint32_t *order; /* ... which they are; NULL: the caller's, in order */
};

/* The first of coordinates begin .. end - 1 that is not finite or too large; end when none is. */
static size_t first_bad(const float *xyz, size_t begin, size_t end)
{
    while (begin < end && fabsf(xyz[begin]) <= COORDINATE_MAX)
        begin++;
    return begin;
}

static vor_status check(const float *xyz, size_t n, size_t bad, struct vor_error *err)
{
    if (bad < 3 * n)
        return vor_fail(err, VOR_E_NONFINITE,
                        "coordinate %c of point %zu is %g, want -1e15 to 1e15", "xyz"[bad % 3],
                        bad / 3, (double)xyz[bad]);
    return VOR_OK;
}

static vor_status start(struct vor_knn **out, size_t n, struct vor_memory *memory,
                        struct vor_error *err)
{
    struct vor_knn *knn;

    if (n == 0 || n > INT32_MAX)
        return vor_fail(err, VOR_E_EMPTY, "the cloud has %zu points, want 1 to %d", n, INT32_MAX);
    knn = vor_calloc(memory, 1, sizeof *knn);
    if (knn == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    knn->memory = memory;
    knn->n = n;
    *out = knn;
    return VOR_OK;
}

static vor_status finish(struct vor_knn **out, struct vor_knn *knn, vor_status status)
{
    if (status == VOR_OK)
        *out = knn;
    else
        vor_knn_free(knn);
    return status;
}

vor_status vor_knn_build(struct vor_knn **out, const float *xyz, size_t n,
                         struct vor_memory *memory, struct vor_error *err)
{
    struct vor_knn *knn = NULL;
    vor_status status = start(&knn, n, memory, err);

    if (status != VOR_OK)
        return status;
    status = check(xyz, n, first_bad(xyz, 0, 3 * n), err);
    VOR_THEN(status, vor_flann_build(&knn->flann, xyz, n, memory, err));
    return finish(out, knn, status);
}

struct search_bad {
    const float *xyz;
    atomic_size_t first;
};

static void check_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct search_bad *search = ctx;
    size_t bad = first_bad(search->xyz, 3 * begin, 3 * end), first = atomic_load(&search->first);

    while (bad < 3 * end && bad < first)
        if (atomic_compare_exchange_weak(&search->first, &first, bad))
            break;
}

vor_status vor_knn_build_sorted(struct vor_knn **out, const float *xyz, size_t n,
                                const struct vor_run *run, struct vor_error *err)
{
    struct search_bad search = {.xyz = xyz};
    struct vor_knn *knn = NULL;
    vor_status status = start(&knn, n, run->memory, err);

    if (status != VOR_OK)
        return status;
    atomic_init(&search.first, 3 * n);
    status = vor_run_for(run, n, BLOCK, check_block, &search, err);
    VOR_THEN(status, check(xyz, n, atomic_load(&search.first), err));
    VOR_THEN(status, vor_boxes_build(&knn->boxes, xyz, n, run, err));
    return finish(out, knn, status);
}

vor_status vor_knn_build_along(struct vor_knn **out, const float *xyz, size_t n,
                               const struct vor_run *run, struct vor_error *err)
{
    struct vor_morton_input in = {.xyz = xyz, .n = n, .scale = 1};
    struct vor_knn *knn = NULL;
    vor_status status = start(&knn, n, run->memory, err);

    if (status != VOR_OK || knn == NULL)
        return status;
    status = VOR_MAKE_ALL(run->memory, err, n, VOR_ARRAY(knn->order, n, 1),
                          VOR_ARRAY(knn->sorted, n, 3));
    VOR_THEN(status, check(xyz, n, first_bad(xyz, 0, 3 * n), err));
    VOR_THEN(status, vor_morton_sort(knn->sorted, knn->order, &in, run, err));
    VOR_THEN(status, vor_boxes_build(&knn->boxes, knn->sorted, n, run, err));
    return finish(out, knn, status);
}

const uint32_t *vor_knn_order(const struct vor_knn *knn)
{
    return knn->order;
}

void vor_knn_free(struct vor_knn *knn)
{
    if (knn == NULL)
        return;
    VOR_FREE_ALL(knn->memory, knn->order, knn->sorted);
    vor_boxes_free(knn->boxes);
    vor_flann_free(knn->flann);
    vor_free(knn->memory, knn);
}

void vor_knn_search(const struct vor_knn *knn, const float *queries, size_t count, unsigned k,
                    uint32_t *index, float *distance2)
{
    struct vor_knn_last last = {.k = 0};

    assert(k >= 1 && k <= knn->n && count <= INT32_MAX / k);
    for (size_t i = 0; i < 3 * count; i++)
        assert(fabsf(queries[i]) <= COORDINATE_MAX);
    if (knn->boxes == NULL && count > 0)
        vor_flann_search(knn->flann, queries, count, k, index, distance2);
    for (size_t i = 0; knn->boxes != NULL && i < count; i++)
        vor_knn_search_next(knn, &last, &queries[3 * i], k, &index[i * k], &distance2[i * k]);
}

/* Puts the names of points in the place of their numbers in the tree. */
static void name(const struct vor_knn *knn, uint32_t *index, size_t count)
{
    for (size_t i = 0; knn->order != NULL && i < count; i++)
        index[i] = knn->order[index[i]];
}

/* Searches for one query that is known to have k points no farther than `within`: what lies beyond
 * is not looked at, which saves a tenth of the time, of one nearest point a quarter. */
static void search_within(const struct vor_knn *knn, const float query[3], unsigned k, float within,
                          uint32_t *index, float *distance2)
{
    if (knn->boxes == NULL) {
        vor_knn_search(knn, query, 1, k, index, distance2);
        return;
    }
    assert(k >= 1 && k <= knn->n && within >= 0);
    for (int c = 0; c < 3; c++)
        assert(fabsf(query[c]) <= COORDINATE_MAX);
    vor_boxes_search(knn->boxes, query, k, within, index, distance2);
    name(knn, index, k);
}

void vor_knn_search_near(const struct vor_knn *knn, struct vor_knn_near *near, uint32_t *index,
                         float *distance2)
{
    if (knn->boxes == NULL) {
        vor_knn_search(knn, near->queries, near->count, near->k, index, distance2);
        return;
    }
    assert(near->k >= 1 && near->k <= knn->n);
    assert(near->count >= 1 && near->count <= VOR_KNN_NEAR_MAX);
    for (size_t i = 0; i < 3 * near->count; i++)
        assert(fabsf(near->queries[i]) <= COORDINATE_MAX);
    vor_boxes_search_near(knn->boxes, near, index, distance2);
    name(knn, index, near->count * near->k);
}

void vor_knn_search_next(const struct vor_knn *knn, struct vor_knn_last *last, const float query[3],
                         unsigned k, uint32_t *index, float *distance2)
{
    float within = INFINITY;

    if (k <= last->k)
        within = last->far + sqrtf((float)vor_distance2f(last->at, query));
    search_within(knn, query, k, within, index, distance2);
    memcpy(last->at, query, sizeof last->at);
    last->far = sqrtf(distance2[k - 1]);
    last->k = k;
}

vor_status vor_knn_join(uint32_t *root, size_t *parts, const struct vor_knn *knn, double distance,
                        const struct vor_run *run, struct vor_error *err)
{
    assert(knn->boxes != NULL);
    return vor_boxes_join(root, parts, knn->boxes, distance, run, err);
}
