#include "core/mesh/front.h"

#include "core/base/linalg.h"
#include "core/base/queue.h"
#include "core/mesh/balls.h"
#include "core/mesh/crossing.h"
#include "core/mesh/handle.h"
#include "core/mesh/over.h"
#include "core/mesh/peel.h"
#include "core/mesh/quality.h"
#include "core/mesh/twosided.h"

#include <string.h>

/* Cosine between the normals of a triangle that begins and of the surface at each corner, at least.
 */
#define FLAT 0.9

/* What an edge is worth whose triangle has to wait for others to be joined to its third corner; any
 * other is worth more. */
#define WAITS (-4)

/* And one that has none that is smooth among few points: it is looked at again, among many. Most
 * are closed by others before. */
#define LATER 0

/* Triangles between two questions whether to go on, and times that those at open edges are taken
 * away and the front goes on from there. Open edges of a polyhedron at 0 / 1 / 2: 12 / 2 / 0. */
enum { POLLED = 256, PEELED = 2 };

/* An open edge of the triangle that has it from a to b, and the third corner of the next. */
struct open_edge {
    uint32_t a, b, third;
    unsigned around; /* points that this was found among */
};

struct front {
    struct vor_complex *complex;
    const struct vor_sheet *sheet;
    int by_lists;      /* triangles join what the lists of the input join */
    int strict;        /* and what the normals of their corners do */
    int facing;        /* triangles face as the first ones at their corners did */
    signed char *side; /* n: so many times the normal of a point is the way its triangles face */
    struct vor_twosided sides;
    struct open_edge *edge;
    struct vor_queue_entry *heap; /* of the open edges, by what they are worth */
    size_t count, room;
    uint32_t *open;     /* room: the first `opens` are triangles that had open edges */
    size_t opens, seen; /* of the triangles before `seen` only those may have any */
    struct vor_balls *balls;
    struct vor_overs *overs;
};

static int joins(const struct front *front, uint32_t i, uint32_t j)
{
    return (!front->strict || vor_sheet_is_beside(front->sheet, i, j)) &&
           (!front->by_lists || vor_sheet_leads(front->sheet, i, j));
}

/* The cosine between the normal of a triangle, of unit length, and that of the surface at a point;
 * its amount where it is not known which side of it triangles face. */
static double agrees(const struct front *front, uint32_t point, const double normal[3], int facing)
{
    const float *m = &front->sheet->normal[3 * (size_t)point];
    double up = normal[0] * (double)m[0] + normal[1] * (double)m[1] + normal[2] * (double)m[2];
    int side = facing ? front->side[point] : 0;

    return side != 0 ? side * up : fabs(up);
}

/* Whether a triangle lies on the surface at each corner. */
static int is_flat(const struct front *front, const uint32_t corner[3], int facing)
{
    double normal[3];

    if (!vor_triangle_unit_normal(normal, front->sheet->seeds->xyz, corner))
        return 0;
    for (int c = 0; c < 3; c++)
        if (!(agrees(front, corner[c], normal, facing) >= FLAT))
            return 0;
    return 1;
}

/* Whether the third corner of a triangle has triangles, none of them beside this one. */
static int meets(const struct front *front, const uint32_t corner[3])
{
    uint32_t third[2];

    return front->complex->degree[corner[2]] > 0 &&
           vor_complex_edge(front->complex, corner[0], corner[2], third) == 0 &&
           vor_complex_edge(front->complex, corner[1], corner[2], third) == 0;
}

/* Whether a triangle passes through one of those that there are; keeps with a candidate which, or
 * how many it was looked at beside. */
static int crosses(const struct front *front, const uint32_t corner[3],
                   struct vor_candidate *candidate)
{
    const struct vor_complex *complex = front->complex;
    size_t since = candidate != NULL ? candidate->seen : 0;

    if (since > 0 && candidate->crossed) {
        if (complex->triangle[3 * since] != VOR_COMPLEX_GONE)
            return 1;
        since = 0;
    }
    since = vor_crossing_near(complex, front->balls, corner, since);
    if (candidate != NULL) {
        candidate->seen = (uint32_t)since;
        candidate->crossed = since < complex->count;
    }
    return since < complex->count;
}

/* Whether those that there are leave room for a triangle over the edge of its first two corners,
 * and the surface keeps its two sides with it, or has one, as a Moebius band. The candidate may be
 * NULL. */
static int is_free(struct front *front, const uint32_t corner[3], struct vor_candidate *candidate)
{
    return vor_complex_takes(front->complex, corner) &&
           (vor_twosided_takes(&front->sides, front->complex, corner) ||
            (!front->facing && is_flat(front, corner, 0))) &&
           !crosses(front, corner, candidate) &&
           !(meets(front, corner) && vor_handle_is(front->complex, &front->sides, corner));
}

/* Whether it lies on the input and its sheet. */
static int is_on(const struct front *front, const uint32_t corner[3])
{
    return joins(front, corner[0], corner[2]) && joins(front, corner[1], corner[2]) &&
           vor_sheet_is_under(front->sheet, corner);
}

/* Whether it lies along the surface, on the side that others at its corners are on. */
static int is_along(const struct front *front, const uint32_t corner[3])
{
    double normal[3], sum = 0;

    (void)vor_triangle_unit_normal(normal, front->sheet->seeds->xyz, corner);
    for (int c = 0; c < 3; c++)
        sum += agrees(front, corner[c], normal, front->facing);
    return sum >= 3 * VOR_OVER_ALONG &&
           (!front->strict || vor_sheet_is_along(front->sheet, corner));
}

/* Whether a candidate over an edge makes a triangle on the input and its sheet, facing as others
 * do, that those that there are leave room for. */
static int fits(struct front *front, const struct open_edge *edge, struct vor_candidate *candidate)
{
    uint32_t corner[3] = {edge->b, edge->a, candidate->point};

    return is_along(front, corner) && is_on(front, corner) && is_free(front, corner, candidate);
}

/* Finds the best next triangle over an edge among as many points as the edge says, and what it is
 * worth; -INFINITY where there is none. */
static float find_best(struct front *front, struct open_edge *edge)
{
    struct vor_candidate all[VOR_BALLS_MANY], *at;
    struct vor_over *over;
    unsigned count, k;
    uint32_t beside[2];

    if (vor_complex_edge(front->complex, edge->a, edge->b, beside) != 1)
        return -INFINITY;
    over = vor_overs_look(front->overs, (uint32_t[3]){edge->a, edge->b, beside[0]}, edge->around);
    for (k = 0; k < over->count; k++)
        if (fits(front, edge, &over->best[k])) {
            edge->third = over->best[k].point;
            return over->best[k].worth;
        }
    count = over->whole ? k : vor_overs_list(front->overs, over, all);
    for (; k < count; k++) {
        at = k < over->count ? &over->best[k] : &all[k];
        if (fits(front, edge, at)) {
            edge->third = at->point;
            return at->worth;
        }
    }
    return -INFINITY;
}

/* Looks among many points over the first edge of the queue, which was looked at among few. Returns
 * whether it stays the first. */
static int look_farther(struct front *front)
{
    struct open_edge *edge = &front->edge[front->heap[0].point];
    float worth;

    edge->around = VOR_BALLS_MANY;
    worth = find_best(front, edge);
    if (worth > LATER)
        return 1;
    vor_queue_lower(front->heap, front->count, worth);
    return 0;
}

static vor_status grow(struct front *front, struct vor_error *err)
{
    struct vor_memory *memory = front->complex->memory;
    size_t room = 2 * front->room + 256;
    struct open_edge *edge = vor_realloc(memory, front->edge, room, sizeof *edge);
    struct vor_queue_entry *heap;
    uint32_t *open;

    if (edge != NULL)
        front->edge = edge;
    heap = edge == NULL ? NULL : vor_realloc(memory, front->heap, room, sizeof *heap);
    if (heap != NULL)
        front->heap = heap;
    open = heap == NULL ? NULL : vor_realloc(memory, front->open, room, sizeof *open);
    if (open == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu edges", room);
    front->open = open;
    front->room = room;
    return VOR_OK;
}

static vor_status push(struct front *front, uint32_t a, uint32_t b, struct vor_error *err)
{
    struct open_edge edge = {a, b, a, VOR_BALLS_FEW};
    float worth = find_best(front, &edge);

    if (front->count == front->room && grow(front, err) != VOR_OK)
        return VOR_E_NOMEM;
    front->edge[front->count] = edge;
    vor_queue_push(front->heap, front->count,
                   (struct vor_queue_entry){fmaxf(worth, LATER), (uint32_t)front->count});
    front->count++;
    return VOR_OK;
}

static vor_status push_edges(struct front *front, size_t t, struct vor_error *err)
{
    vor_status status = VOR_OK;

    for (int c = 0; c < 3 && status == VOR_OK; c++) {
        const uint32_t *corner = &front->complex->triangle[3 * t];

        if (vor_complex_is_open(front->complex, t, c))
            status = push(front, corner[c], corner[(c + 1) % 3], err);
    }
    return status;
}

/* Lets a triangle tell the sides of its corners that none has told before, where its normal and the
 * surface's are less than 60 degrees apart, as lines. */
static void set_sides(struct front *front, const uint32_t corner[3])
{
    double normal[3];

    (void)vor_triangle_unit_normal(normal, front->sheet->seeds->xyz, corner);
    for (int c = 0; c < 3; c++) {
        const float *m = &front->sheet->normal[3 * (size_t)corner[c]];
        double up = normal[0] * (double)m[0] + normal[1] * (double)m[1] + normal[2] * (double)m[2];

        if (front->side[corner[c]] == 0 && fabs(up) >= VOR_SAME_WAY)
            front->side[corner[c]] = up > 0 ? 1 : -1;
    }
}

/* Adds a triangle; the edges that it opens are not in the queue yet. */
static vor_status put(struct front *front, const uint32_t corner[3], struct vor_error *err)
{
    vor_status status = vor_complex_add(front->complex, corner, err);

    if (status == VOR_OK)
        vor_twosided_add(&front->sides, front->complex, (uint32_t)(front->complex->count - 1));
    return status;
}

static vor_status open_edges(struct front *front, struct vor_error *err)
{
    size_t t = front->complex->count - 1;

    set_sides(front, &front->complex->triangle[3 * t]);
    return push_edges(front, t, err);
}

static vor_status add(struct front *front, const uint32_t corner[3], struct vor_error *err)
{
    vor_status status = put(front, corner, err);

    return status == VOR_OK ? open_edges(front, err) : status;
}

/* A triangle whose third corner meets others there is joined to these by a second one: the best
 * over an open edge at that corner, if it leads to another corner of the first. Returns whether
 * there is one. */
static int find_join(struct front *front, const uint32_t corner[3], uint32_t join[3])
{
    const struct vor_complex *complex = front->complex;
    uint32_t c = corner[2];

    for (unsigned k = 0; k < complex->degree[c]; k++) {
        uint32_t t = complex->around[(size_t)c * VOR_AROUND_MOST + k], other[2];

        vor_complex_others(complex, t, c, other);
        for (int o = 0; o < 2; o++) {
            struct open_edge beside = {c, other[o], c, VOR_BALLS_MANY};

            if (vor_complex_across(complex, t, c, other[o]) != t)
                continue;
            if (vor_complex_runs(&complex->triangle[3 * (size_t)t], other[o], c))
                beside = (struct open_edge){other[o], c, c, VOR_BALLS_MANY};
            if (!(find_best(front, &beside) > -INFINITY) ||
                (beside.third != corner[0] && beside.third != corner[1]))
                continue;
            memcpy(join, (uint32_t[3]){beside.b, beside.a, beside.third}, 3 * sizeof *join);
            return 1;
        }
    }
    return 0;
}

/* Adds a triangle whose third corner meets others together with the one that joins it to these, or
 * none: a corner of two fans would hide which boundary loop it is on. */
static vor_status add_joined(struct front *front, const uint32_t corner[3], struct vor_error *err)
{
    struct vor_complex *complex = front->complex;
    uint32_t join[3];
    vor_status status;

    if (!find_join(front, corner, join))
        return VOR_OK;
    status = put(front, corner, err);
    if (status == VOR_OK && !is_free(front, join, NULL)) {
        vor_complex_remove(complex, (uint32_t)--complex->count);
        return VOR_OK;
    }
    VOR_THEN(status, open_edges(front, err));
    return status == VOR_OK ? add(front, join, err) : status;
}

/* Adds the triangle over the first edge of the queue, or finds it another one. */
static vor_status step(struct front *front, struct vor_error *err)
{
    struct open_edge *edge = &front->edge[front->heap[0].point];
    float key = front->heap[0].key, worth;
    uint32_t corner[3] = {edge->b, edge->a}, third[2];
    struct vor_candidate *candidate;

    if (vor_complex_edge(front->complex, edge->a, edge->b, third) != 1) {
        vor_queue_lower(front->heap, front->count, -INFINITY);
        return VOR_OK;
    }
    if (!(key > (float)LATER) && edge->around == VOR_BALLS_FEW && !look_farther(front))
        return VOR_OK;
    corner[2] = edge->third;
    candidate = vor_overs_find(front->overs, (uint32_t[3]){edge->a, edge->b, third[0]},
                               edge->around, edge->third);
    if (!is_free(front, corner, candidate)) {
        worth = find_best(front, edge);
        vor_queue_lower(front->heap, front->count,
                        edge->around == VOR_BALLS_FEW ? fmaxf(worth, LATER) : worth);
        return VOR_OK;
    }
    if (meets(front, corner)) {
        vor_queue_lower(front->heap, front->count, key > (float)WAITS ? (float)WAITS : -INFINITY);
        return add_joined(front, corner, err);
    }
    vor_queue_lower(front->heap, front->count, -INFINITY);
    return add(front, corner, err);
}

/* Takes triangles over open edges until there are none. */
static vor_status advance(struct front *front, const struct vor_run *run, struct vor_error *err)
{
    vor_status status = VOR_OK;

    for (size_t at = 0; status == VOR_OK && front->count > 0 && front->heap[0].key > -INFINITY;
         at++) {
        if (at % POLLED == 0)
            status = vor_run_answered(vor_run_poll(run), err);
        VOR_THEN(status, step(front, err));
    }
    front->count = 0;
    return status;
}

/* Whether a triangle touches others at a corner alone. */
static int touches(const struct vor_complex *complex, const uint32_t corner[3])
{
    uint32_t third[2];

    for (int c = 0; c < 3; c++)
        if (complex->degree[corner[c]] > 0 &&
            vor_complex_edge(complex, corner[c], corner[(c + 1) % 3], third) == 0 &&
            vor_complex_edge(complex, corner[c], corner[(c + 2) % 3], third) == 0)
            return 1;
    return 0;
}

/* Begins at point i: with the triangle of the smallest ball that is flat and free. */
static vor_status begin_at(struct front *front, uint32_t i, struct vor_error *err)
{
    struct vor_balls *balls = front->balls;
    uint32_t best[3] = {i, i, i};
    double most2 = INFINITY;

    vor_balls_look(balls, i, VOR_BALLS_FEW);
    for (unsigned j = 0; j < balls->around; j++)
        for (unsigned k = 0; k < balls->around; k++) {
            uint32_t corner[3] = {balls->index[j], balls->index[k], i};
            double radius2;

            if (corner[0] == i || corner[1] == i || j == k)
                continue;
            radius2 = vor_balls_radius2(balls, balls->x[j], balls->x[k], most2);
            if (radius2 < most2 && !touches(front->complex, corner) && is_flat(front, corner, 1) &&
                joins(front, corner[0], corner[1]) && is_on(front, corner) &&
                is_free(front, corner, NULL)) {
                most2 = radius2;
                memcpy(best, corner, sizeof best);
            }
        }
    return best[0] == i ? VOR_OK : add(front, best, err);
}

static vor_status push_all(struct front *front, const struct vor_run *run, struct vor_error *err)
{
    const struct vor_complex *complex = front->complex;
    size_t there = complex->count, waiting = front->opens + there - front->seen, open = 0;
    vor_status status = VOR_OK;

    for (size_t k = 0; k < waiting && status == VOR_OK; k++) {
        size_t before = front->count;
        size_t t = k < front->opens ? front->open[k] : front->seen + k - front->opens;

        if (k % POLLED == 0)
            status = vor_run_answered(vor_run_poll(run), err);
        if (status == VOR_OK && complex->triangle[3 * t] != VOR_COMPLEX_GONE)
            status = push_edges(front, t, err);
        if (front->count > before)
            front->open[open++] = (uint32_t)t;
    }
    front->opens = open;
    front->seen = there;
    return status;
}

/* Goes on from all open edges, and then from points without triangles. */
static vor_status go_on(struct front *front, const struct vor_run *run, struct vor_error *err)
{
    struct vor_complex *complex = front->complex;
    vor_status status = vor_overs_make(front->overs, front->balls, front->opens, err);

    VOR_THEN(status, push_all(front, run, err));
    VOR_THEN(status, vor_overs_make(front->overs, front->balls, front->opens, err));
    VOR_THEN(status, advance(front, run, err));
    for (size_t i = 0; i < complex->n && status == VOR_OK; i++) {
        if (i % POLLED == 0)
            status = vor_run_answered(vor_run_poll(run), err);
        if (status != VOR_OK || !front->facing || complex->degree[i] > 0 ||
            !vor_sheet_has(front->sheet, i))
            continue;
        status = begin_at(front, (uint32_t)i, err);
        VOR_THEN(status, advance(front, run, err));
    }
    return status;
}

/* Goes on by sides, first where normals leave no doubt, and then without. */
static vor_status go_on_all(struct front *front, const struct vor_run *run, struct vor_error *err)
{
    static const struct {
        int strict, facing;
    } pass[] = {{1, 1}, {0, 1}, {0, 0}};
    /* twice as many triangles as points, and handles */
    vor_status status =
        vor_twosided_make(&front->sides, front->complex, 4 * front->complex->n, err);

    front->opens = front->seen = 0;
    for (size_t k = 0; k < sizeof pass / sizeof *pass && status == VOR_OK; k++) {
        front->strict = pass[k].strict;
        front->facing = pass[k].facing;
        status = go_on(front, run, err);
    }
    vor_twosided_free(&front->sides);
    return status;
}

vor_status vor_front_advance(struct vor_complex *complex, struct vor_overs *overs,
                             const struct vor_run *run, struct vor_error *err)
{
    struct vor_balls *balls = overs->balls;
    const struct vor_sheet *sheet = balls->sheet;
    struct front front = {.complex = complex,
                          .sheet = sheet,
                          .balls = balls,
                          .overs = overs,
                          .by_lists = sheet->graph != NULL,
                          .side = vor_calloc(run->memory, complex->n, 1)};
    vor_status status = front.side == NULL ? vor_fail(err, VOR_E_NOMEM, "%zu points", complex->n)
                                           : go_on_all(&front, run, err);

    if (status == VOR_OK && front.by_lists && !balls->parts) {
        front.by_lists = 0;
        status = go_on_all(&front, run, err);
    }
    for (int round = 0; round < PEELED && status == VOR_OK; round++) {
        status = vor_peel(complex, err);
        VOR_THEN(status, go_on_all(&front, run, err));
    }
    vor_peel_notches(complex, sheet->seeds->xyz);
    VOR_FREE_ALL(complex->memory, front.side, front.open, front.heap, front.edge);
    return status;
}
