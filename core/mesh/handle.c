#include "core/mesh/handle.h"

#include <string.h>

/* Edges along the surface that lead around a small handle at most, as many from the third corner
 * and from the others, points that they reach, and edges along the boundary that are looked at each
 * way. */
enum { FROM_THIRD = 3, FROM_OTHERS = 2, REACHED = 96, ALONG = 48 };

/* Edges of a boundary loop that is a hole, not the end of a tube. A tunnel from a room's table to
 * its wall had five at each end. */
enum { HOLE = 6 };

/* Places of a table of points that are reached, and a place that none has. */
enum { TABLE_SIZE = 256 };
#define NONE UINT32_MAX

/* Where the boundary goes on from `at`, which it reaches by an open edge from `from`. In one fan
 * each neighbour but the two at its ends has two triangles, so that these two are the exclusive or
 * of all. Where there are several fans, that is hardly ever a neighbour: then it is looked for. */
static uint32_t go_on(const struct vor_complex *complex, uint32_t from, uint32_t at)
{
    uint32_t other[2], third[2], next = from, t = VOR_COMPLEX_GONE;

    for (unsigned k = 0; k < complex->degree[at]; k++) {
        vor_complex_others(complex, complex->around[(size_t)at * VOR_AROUND_MOST + k], at, other);
        next ^= other[0] ^ other[1];
    }
    if (vor_complex_edge(complex, at, next, third) == 1)
        return next;
    for (next = from; vor_complex_across(complex, t, at, next) != t;) {
        t = vor_complex_across(complex, t, at, next);
        vor_complex_others(complex, t, at, other);
        next = other[0] == next ? other[1] : other[0];
    }
    return next;
}

/* Goes by the open edge from `from` to `at` along the boundary. Returns the edges of the loop,
 * ALONG where it is longer, or 0 where it meets the first two corners. */
static int follow(const struct vor_complex *complex, uint32_t from, uint32_t at,
                  const uint32_t corner[3])
{
    for (int step = 1; step < ALONG; step++) {
        uint32_t next;

        if (at == corner[0] || at == corner[1])
            return 0;
        if (at == corner[2])
            return step;
        next = go_on(complex, from, at);
        from = at;
        at = next;
    }
    return ALONG;
}

/* The edges of the shortest boundary loop of the third corner; 0 where it leads to another corner.
 */
static int loop_of(const struct vor_complex *complex, const uint32_t corner[3])
{
    uint32_t c = corner[2], other[2];
    int shortest = ALONG;

    for (unsigned k = 0; k < complex->degree[c] && shortest > 0; k++) {
        uint32_t t = complex->around[(size_t)c * VOR_AROUND_MOST + k];

        vor_complex_others(complex, t, c, other);
        for (int o = 0; o < 2 && shortest > 0; o++) {
            int edges = vor_complex_across(complex, t, c, other[o]) == t
                            ? follow(complex, c, other[o], corner)
                            : ALONG;

            shortest = edges < shortest ? edges : shortest;
        }
    }
    return shortest;
}

/* Points that were reached, and a table of them by their last bits that is never full. */
struct reached {
    unsigned count;
    uint32_t point[REACHED], table[TABLE_SIZE];
};

static void clear(struct reached *reached)
{
    reached->count = 0;
    memset(reached->table, 0xff, sizeof reached->table);
}

/* The place of a point in the table, or where it would be. */
static unsigned place_of(const struct reached *reached, uint32_t point)
{
    unsigned at = point % TABLE_SIZE;

    while (reached->table[at] != NONE && reached->table[at] != point)
        at = (at + 1) % TABLE_SIZE;
    return at;
}

static void add(struct reached *reached, uint32_t point)
{
    unsigned at = place_of(reached, point);

    if (reached->table[at] == point || reached->count == REACHED)
        return;
    reached->table[at] = point;
    reached->point[reached->count++] = point;
}

/* Adds the points that so many edges lead to. */
static void spread(struct reached *reached, const struct vor_complex *complex, int steps)
{
    unsigned done = 0;

    for (int step = 0; step < steps; step++)
        for (unsigned end = reached->count; done < end; done++) {
            uint32_t i = reached->point[done], other[2];

            for (unsigned k = 0; k < complex->degree[i]; k++) {
                vor_complex_others(complex, complex->around[(size_t)i * VOR_AROUND_MOST + k], i,
                                   other);
                add(reached, other[0]);
                add(reached, other[1]);
            }
        }
}

/* Whether few edges along the surface lead from the third corner to another. */
static int is_near(const struct vor_complex *complex, const uint32_t corner[3])
{
    struct reached here, there;

    clear(&here);
    clear(&there);
    add(&here, corner[2]);
    spread(&here, complex, FROM_THIRD);
    add(&there, corner[0]);
    add(&there, corner[1]);
    spread(&there, complex, FROM_OTHERS);
    for (unsigned j = 0; j < there.count; j++)
        if (here.table[place_of(&here, there.point[j])] == there.point[j])
            return 1;
    return 0;
}

int vor_handle_is(const struct vor_complex *complex, struct vor_twosided *sides,
                  const uint32_t corner[3])
{
    uint32_t third = complex->around[(size_t)corner[2] * VOR_AROUND_MOST];
    uint32_t over = vor_complex_across(complex, VOR_COMPLEX_GONE, corner[0], corner[1]);
    int loop = vor_twosided_joined(sides, third, over) ? loop_of(complex, corner) : 0;

    return loop > 0 && (loop <= HOLE || is_near(complex, corner));
}
