#include "core/knn/input_lists.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { WIDE_MAX = 1024 };

#define ROUNDING 1.00001f /* what float distances may be off, and more */

/* How many a list of k has. */
static unsigned width(const struct vor_near *near, unsigned k)
{
    unsigned wide = k + k / 2 + 2;

    return wide < near->m ? wide : (unsigned)near->m;
}

static void forget(struct vor_near *near)
{
    for (size_t i = 0; i < near->n; i++)
        near->reach[i] = -1;
}

vor_status vor_near_init(struct vor_near *out, size_t n, unsigned most, const struct vor_knn *knn,
                         const float *reference, size_t m, struct vor_memory *memory,
                         struct vor_error *err)
{
    struct vor_near near = {
        .memory = memory, .knn = knn, .reference = reference, .n = n, .m = m, .most = most};

    near.wide = width(&near, most);
    near.k = vor_calloc(memory, n, sizeof *near.k);
    near.list = vor_malloc(memory, n, near.wide * sizeof *near.list);
    near.anchor = vor_malloc(memory, n, 3 * sizeof *near.anchor);
    near.reach = vor_malloc(memory, n, sizeof *near.reach);
    if (near.k == NULL || near.list == NULL || near.anchor == NULL || near.reach == NULL) {
        vor_near_free(&near);
        return vor_fail(err, VOR_E_NOMEM, "lists of %u neighbours for %zu points", near.wide, n);
    }
    forget(&near);
    *out = near;
    return VOR_OK;
}

void vor_near_onto(struct vor_near *near, const struct vor_knn *knn, const float *reference,
                   size_t m)
{
    assert(m >= near->wide);
    near->knn = knn;
    near->reference = reference;
    near->m = m;
    forget(near);
}

void vor_near_free(struct vor_near *near)
{
    if (near->memory == NULL)
        return;
    vor_free(near->memory, near->reach);
    vor_free(near->memory, near->anchor);
    vor_free(near->memory, near->list);
    vor_free(near->memory, near->k);
    memset(near, 0, sizeof *near);
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

static unsigned farthest(const float *distance2, unsigned begin, unsigned end)
{
    unsigned at = begin;

    for (unsigned j = begin + 1; j < end; j++)
        at = distance2[j] > distance2[at] ? j : at;
    return at;
}

static unsigned nearest(const float *distance2, unsigned begin, unsigned end)
{
    unsigned at = begin;

    for (unsigned j = begin + 1; j < end; j++)
        at = distance2[j] < distance2[at] ? j : at;
    return at;
}

/* Brings the k nearest of the list to its front by exchanging the farthest of the front with the
 * nearest of the rest: a query that moved a little needs none or one or two of these. Returns how
 * many, and the distance of the farthest in *last. */
static unsigned select(const struct vor_near *near, uint32_t *list, unsigned k, const float x[3],
                       float *last)
{
    float distance2[WIDE_MAX];
    unsigned exchanged = 0, wide = width(near, k), out, in;

    memset(distance2, 0, wide * sizeof *distance2); /* the analysers want it said */
    for (unsigned j = 0; j < wide; j++)
        distance2[j] = squared(&near->reference[3 * (size_t)list[j]], x);
    for (;; exchanged++) {
        out = farthest(distance2, 0, k);
        if (k == wide)
            break;
        in = nearest(distance2, k, wide);
        if (distance2[out] <= distance2[in])
            break;
        swap(list, distance2, out, in);
    }
    *last = sqrtf(distance2[out]);
    swap(list, distance2, 0, nearest(distance2, 0, k));
    return exchanged;
}

static void make_list(struct vor_near *near, size_t i, const float x[3], unsigned k)
{
    float distance2[WIDE_MAX];
    unsigned wide = width(near, k);

    vor_knn_search(near->knn, x, 1, wide, &near->list[i * near->wide], distance2);
    memcpy(&near->anchor[3 * i], x, 3 * sizeof *x);
    near->reach[i] = wide < near->m ? sqrtf(distance2[wide - 1]) : INFINITY;
    near->k[i] = (uint16_t)k;
}

enum vor_near_found vor_near_search(struct vor_near *near, size_t i, const float x[3], unsigned k,
                                    const uint32_t **index)
{
    uint32_t *list = &near->list[i * near->wide];

    assert(k >= 1 && k <= near->most);
    *index = list;
    if (near->reach[i] >= 0 && near->k[i] == k) {
        float moved = sqrtf(squared(&near->anchor[3 * i], x));

        if (moved < near->reach[i]) {
            float last;
            unsigned exchanged = select(near, list, k, x, &last);

            /* A point beyond the list is at least reach - moved away. */
            if ((last + moved) * ROUNDING <= near->reach[i])
                return exchanged > 0 ? VOR_NEAR_OTHER : VOR_NEAR_SAME;
        }
    }
    make_list(near, i, x, k);
    return VOR_NEAR_ANEW;
}

unsigned vor_near_around(const struct vor_near *near, size_t i, const float x[3], unsigned k,
                         uint32_t *index)
{
    const uint32_t *list = &near->list[i * near->wide];
    unsigned wide = width(near, near->k[i]), count = 0;
    float distance2[WIDE_MAX], sure;

    assert(k >= 1 && k <= WIDE_MAX);
    memset(distance2, 0, k * sizeof *distance2); /* the analysers want it said */
    if (near->reach[i] < 0)
        return 0;
    sure = near->reach[i] - sqrtf(squared(&near->anchor[3 * i], x));
    for (unsigned j = 0; j < wide; j++) {
        float d2 = squared(&near->reference[3 * (size_t)list[j]], x);
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
