#include "core/mesh/twosided.h"

#include "core/base/union.h"

#include <string.h>

/* The root of the group of triangle t, and whether t faces the other way than that. */
static uint32_t root_of(struct vor_twosided *sides, uint32_t t, unsigned *contrary)
{
    return vor_union_root_odd(sides->parent, sides->contrary, t, contrary);
}

/* A group of triangles beside a triangle. */
struct beside {
    uint32_t root;
    unsigned contrary; /* whether the triangle faces the other way than the root */
};

/* Finds the group beside triangle t over its edge from a to b. Returns 0 where there is none. Of a
 * triangle that is not added, t is VOR_COMPLEX_GONE. */
static int look(struct beside *out, struct vor_twosided *sides, const struct vor_complex *complex,
                uint32_t t, uint32_t a, uint32_t b)
{
    uint32_t u = vor_complex_across(complex, t, a, b);

    if (u == t)
        return 0;
    out->root = root_of(sides, u, &out->contrary);
    out->contrary ^= (unsigned)vor_complex_runs(&complex->triangle[3 * (size_t)u], a, b);
    return 1;
}

int vor_twosided_takes(struct vor_twosided *sides, const struct vor_complex *complex,
                       const uint32_t corner[3])
{
    struct beside its[3];
    unsigned count = 0;

    for (int e = 0; e < 3; e++) {
        if (!look(&its[count], sides, complex, VOR_COMPLEX_GONE, corner[e], corner[(e + 1) % 3]))
            continue;
        for (unsigned k = 0; k < count; k++)
            if (its[k].root == its[count].root && its[k].contrary != its[count].contrary &&
                !sides->one[its[k].root])
                return 0;
        count++;
    }
    return 1;
}

int vor_twosided_joined(struct vor_twosided *sides, uint32_t t, uint32_t u)
{
    unsigned contrary;

    return root_of(sides, t, &contrary) == root_of(sides, u, &contrary);
}

/* Makes triangle t a group of its own. */
static void begin(struct vor_twosided *sides, uint32_t t)
{
    sides->parent[t] = t;
    sides->contrary[t] = sides->one[t] = 0;
}

/* Joins the group of triangle t to those beside it. */
static void join(struct vor_twosided *sides, const struct vor_complex *complex, uint32_t t)
{
    const uint32_t *corner = &complex->triangle[3 * (size_t)t];

    for (int e = 0; e < 3; e++) {
        struct beside its;
        unsigned turned;
        uint32_t own;

        if (!look(&its, sides, complex, t, corner[e], corner[(e + 1) % 3]))
            continue;
        own = root_of(sides, t, &turned);
        if (own == its.root) {
            sides->one[own] |= turned != its.contrary;
            continue;
        }
        sides->parent[own] = its.root;
        sides->contrary[own] = (unsigned char)(turned ^ its.contrary);
        sides->one[its.root] |= sides->one[own];
    }
}

void vor_twosided_add(struct vor_twosided *sides, const struct vor_complex *complex, uint32_t t)
{
    begin(sides, t);
    join(sides, complex, t);
}

vor_status vor_twosided_make(struct vor_twosided *out, const struct vor_complex *complex,
                             size_t more, struct vor_error *err)
{
    size_t room = complex->count + more;
    struct vor_twosided sides = {.memory = complex->memory};

    sides.parent = vor_malloc(sides.memory, room, sizeof *sides.parent);
    sides.contrary = vor_malloc(sides.memory, room, 1);
    sides.one = vor_malloc(sides.memory, room, 1);
    if (sides.parent == NULL || sides.contrary == NULL || sides.one == NULL) {
        vor_twosided_free(&sides);
        return vor_fail(err, VOR_E_NOMEM, "%zu triangles", room);
    }
    for (size_t t = 0; t < complex->count; t++)
        begin(&sides, (uint32_t)t);
    for (size_t t = 0; t < complex->count; t++)
        if (complex->triangle[3 * t] != VOR_COMPLEX_GONE)
            join(&sides, complex, (uint32_t)t);
    *out = sides;
    return VOR_OK;
}

void vor_twosided_free(struct vor_twosided *sides)
{
    VOR_FREE_ALL(sides->memory, sides->one, sides->contrary, sides->parent);
    memset(sides, 0, sizeof *sides);
}
