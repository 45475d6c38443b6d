#include "core/knn/near.h"

#include <math.h>
#include <string.h>

enum { WIDE_MAX = 1024 };

#define ROUNDING 1.00001f /* what float distances may be off, and more */

vor_status vor_near_init(struct vor_near *out, size_t n, unsigned k, const struct vor_knn *knn,
                         const float *reference, size_t m, struct vor_memory *memory,
                         struct vor_error *err)
{
    struct vor_near near = {.memory = memory,
                            .knn = knn,
                            .reference = reference,
                            .n = n,
                            .k = k,
                            .wide = k + k / 2 + 2};

    if (near.wide > m)
        near.wide = (unsigned)m;
    near.list = vor_malloc(memory, n, near.wide * sizeof *near.list);
    near.anchor = vor_malloc(memory, n, 3 * sizeof *near.anchor);
    near.reach = vor_malloc(memory, n, sizeof *near.reach);
    if (near.list == NULL || near.anchor == NULL || near.reach == NULL) {
        vor_near_free(&near);
        return vor_fail(err, VOR_E_NOMEM, "lists of %u neighbours for %zu points", near.wide, n);
    }
    for (size_t i = 0; i < n; i++)
        near.reach[i] = -1;
    *out = near;
    return VOR_OK;
}

void vor_near_free(struct vor_near *near)
{
    if (near->memory == NULL)
        return;
    vor_free(near->memory, near->reach);
    vor_free(near->memory, near->anchor);
    vor_free(near->memory, near->list);
    memset(near, 0, sizeof *near);
}

static float squared(const float a[3], const float b[3])
{
    float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];

    return x * x + y * y + z * z;
}

/* The k best of the list, sorted by insertion: the list nearly is. Returns the last one's distance.
 */
static float select(const struct vor_near *near, const uint32_t *list, const float x[3],
                    uint32_t *index)
{
    float distance2[WIDE_MAX], worst = INFINITY;
    unsigned count = 0;

    memset(distance2, 0, near->k * sizeof *distance2); /* the analysers want it said */
    for (unsigned j = 0; j < near->wide; j++) {
        float d = squared(&near->reference[3 * (size_t)list[j]], x);
        unsigned at = count < near->k ? count++ : near->k - 1;

        if (!(d < worst))
            continue;
        for (; at > 0 && d < distance2[at - 1]; at--) {
            distance2[at] = distance2[at - 1];
            index[at] = index[at - 1];
        }
        distance2[at] = d;
        index[at] = list[j];
        if (count == near->k)
            worst = distance2[count - 1];
    }
    return sqrtf(worst);
}

static void make_list(struct vor_near *near, size_t i, const float x[3], uint32_t *index)
{
    uint32_t *list = &near->list[i * near->wide];
    float distance2[WIDE_MAX];

    vor_knn_search(near->knn, x, 1, near->wide, list, distance2);
    memcpy(&near->anchor[3 * i], x, 3 * sizeof *x);
    near->reach[i] = sqrtf(distance2[near->wide - 1]);
    memcpy(index, list, near->k * sizeof *index);
}

int vor_near_search(struct vor_near *near, size_t i, const float x[3], uint32_t *index)
{
    if (near->reach[i] >= 0) {
        float moved = sqrtf(squared(&near->anchor[3 * i], x));

        if (moved < near->reach[i]) {
            float last = select(near, &near->list[i * near->wide], x, index);

            /* A point beyond the list is at least reach - moved away. */
            if ((last + moved) * ROUNDING <= near->reach[i])
                return 0;
        }
    }
    make_list(near, i, x, index);
    return 1;
}
