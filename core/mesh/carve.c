#include "core/mesh/carve.h"

#include "core/base/linalg.h"
#include "core/mesh/crossing.h"
#include "core/mesh/cut.h"
#include "core/mesh/facing.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Most triangles that are taken away around a loop. Nearly always the first ring will do, of less
 * than two for each of its edges. */
enum { GONE = 4 * VOR_CUT_MOST };

struct carving {
    struct vor_complex *complex;
    struct vor_cut cut;
    signed char *side;                  /* n: as the cut has it */
    unsigned points, inner, gone, mine; /* the first `inner` points have no other triangles */
    uint32_t point[GONE];
    uint32_t number[GONE], corner[GONE][3]; /* of triangles that were taken away */
    uint32_t own[2 * GONE];                 /* numbers of those in their place */
    uint32_t border[VOR_CUT_MOST];
};

/* So many times the normal of a point is the way its triangles face. */
static signed char side_of(const struct carving *carving, uint32_t point)
{
    const struct vor_sheet *sheet = carving->cut.balls->sheet;
    const float *m = &sheet->normal[3 * (size_t)point];
    double normal[3], up = 0;

    for (unsigned k = 0; k < carving->complex->degree[point]; k++) {
        uint32_t t = carving->complex->around[(size_t)point * VOR_AROUND_MOST + k];

        vor_triangle_normal(normal, sheet->seeds->xyz, &carving->complex->triangle[3 * (size_t)t]);
        up += normal[0] * (double)m[0] + normal[1] * (double)m[1] + normal[2] * (double)m[2];
    }
    return (signed char)((up > 0) - (up < 0));
}

static void list_point(struct carving *carving, uint32_t point)
{
    for (unsigned i = 0; i < carving->points; i++)
        if (carving->point[i] == point)
            return;
    carving->point[carving->points++] = point;
    carving->side[point] = side_of(carving, point);
}

/* Takes the triangles at the listed points away, and lists their other corners. Returns whether
 * there were some, and room. */
static int take_ring(struct carving *carving)
{
    struct vor_complex *complex = carving->complex;
    unsigned before = carving->gone;

    carving->inner = carving->points;
    for (unsigned i = 0; i < carving->inner; i++)
        while (complex->degree[carving->point[i]] > 0) {
            uint32_t t = complex->around[(size_t)carving->point[i] * VOR_AROUND_MOST];
            uint32_t *corner;

            if (carving->gone == GONE || carving->points + 2 > GONE)
                return 0;
            corner = carving->corner[carving->gone];
            memcpy(corner, &complex->triangle[3 * (size_t)t], 3 * sizeof *corner);
            for (int c = 0; c < 3; c++)
                list_point(carving, corner[c]);
            carving->number[carving->gone++] = t;
            vor_complex_remove(complex, t);
        }
    return carving->gone > before;
}

/* Finds the edges between what was taken away and what was not. Returns how many there are; 0 where
 * they are too many. */
static unsigned find_edges(const struct carving *carving, uint32_t edge[VOR_CUT_MOST][2])
{
    const struct vor_complex *complex = carving->complex;
    unsigned edges = 0;
    uint32_t third[2];

    for (unsigned t = 0; t < carving->gone; t++)
        for (int c = 0; c < 3; c++) {
            uint32_t a = carving->corner[t][c], b = carving->corner[t][(c + 1) % 3];

            if (vor_complex_edge(complex, a, b, third) == 0)
                continue;
            if (edges == VOR_CUT_MOST)
                return 0;
            edge[edges][0] = a;
            edge[edges++][1] = b;
        }
    return edges;
}

/* Follows these edges the way that what was taken away ran. Returns whether they are one loop. */
static int find_border(struct carving *carving)
{
    uint32_t edge[VOR_CUT_MOST][2];
    unsigned edges = find_edges(carving, edge), at = 0;

    for (unsigned k = 0; k < edges; k++) {
        unsigned next = edges;

        carving->border[k] = edge[at][0];
        for (unsigned e = 0; e < edges; e++)
            if (edge[e][0] == edge[at][1])
                next = next == edges ? e : edges + 1;
        if (next >= edges || (next == 0) != (k + 1 == edges))
            return 0;
        at = next;
    }
    carving->cut.loop = carving->border;
    carving->cut.count = edges;
    return edges > 2;
}

static vor_status add(struct carving *carving, const uint32_t corner[3], struct vor_error *err)
{
    vor_status status = vor_complex_add(carving->complex, corner, err);

    if (status == VOR_OK)
        carving->own[carving->mine++] = (uint32_t)(carving->complex->count - 1);
    return status;
}

/* One or two triangles beside each other that make room for a point. */
struct room {
    unsigned count, at[2]; /* places among the own ones */
    uint32_t corner[2][3]; /* their corners */
    uint32_t end[2];       /* of the edge between the two */
    unsigned parts;        /* triangles of the point and an edge */
    uint32_t part[4][3];
};

/* Finds the triangles of the point and the edges around a room. */
static void find_parts(struct room *room, uint32_t point)
{
    room->parts = 0;
    for (unsigned k = 0; k < room->count; k++)
        for (int c = 0; c < 3; c++) {
            uint32_t a = room->corner[k][c], b = room->corner[k][(c + 1) % 3];

            if (room->count == 2 && (a == room->end[0] || a == room->end[1]) &&
                (b == room->end[0] || b == room->end[1]))
                continue;
            memcpy(room->part[room->parts++], (uint32_t[3]){a, b, point}, 3 * sizeof a);
        }
}

/* What it costs to put the point there; INFINITY if it is not less than `least`. */
static double cost_of(const struct carving *carving, const struct room *room, double least)
{
    double cost = 0;

    for (unsigned k = 0; k < room->count; k++)
        cost -= vor_cut_cost(&carving->cut, room->corner[k]);
    for (unsigned p = 0; p < room->parts; p++)
        cost += vor_cut_cost(&carving->cut, room->part[p]);
    for (unsigned p = 0; p < room->parts && cost < least; p++)
        if (carving->complex->degree[room->part[p][0]] == VOR_AROUND_MOST ||
            vor_crossing_near(carving->complex, carving->cut.balls, room->part[p], 0) <
                carving->complex->count)
            return INFINITY;
    return cost < least ? cost : INFINITY;
}

/* The place of a triangle among the own ones; `mine` where it is none. */
static unsigned place_of(const struct carving *carving, uint32_t t)
{
    unsigned k = 0;

    while (k < carving->mine && carving->own[k] != t)
        k++;
    return k;
}

/* Sets the room of an own triangle and, for c < 3, that over its edge from corner c on. Returns
 * whether there is such. */
static int set_room(struct room *room, const struct carving *carving, unsigned k, int c)
{
    const struct vor_complex *complex = carving->complex;
    const uint32_t *corner = &complex->triangle[3 * (size_t)carving->own[k]];

    room->count = c < 3 ? 2 : 1;
    room->at[0] = k;
    memcpy(room->corner[0], corner, sizeof room->corner[0]);
    if (c == 3)
        return 1;
    room->end[0] = corner[c];
    room->end[1] = corner[(c + 1) % 3];
    room->at[1] =
        place_of(carving, vor_complex_across(complex, carving->own[k], corner[c], room->end[1]));
    if (room->at[1] >= carving->mine || room->at[1] <= k)
        return 0;
    memcpy(room->corner[1], &complex->triangle[3 * (size_t)carving->own[room->at[1]]],
           sizeof room->corner[1]);
    return 1;
}

/* Puts a point without triangles where it costs least; *done says whether there is such a place. */
static vor_status insert(struct carving *carving, uint32_t point, int *done, struct vor_error *err)
{
    struct room room, best = {.count = 0};
    double least = INFINITY, cost;
    vor_status status = VOR_OK;

    for (unsigned k = 0; k < carving->mine; k++)
        for (int c = 0; c <= 3; c++) {
            if (!set_room(&room, carving, k, c))
                continue;
            find_parts(&room, point);
            cost = cost_of(carving, &room, least);
            if (cost < least) {
                least = cost;
                best = room;
            }
        }
    *done = best.count > 0 && carving->mine + 4 <= 2 * GONE;
    if (!*done)
        return VOR_OK;
    for (unsigned k = best.count; k-- > 0;) { /* the later one first */
        vor_complex_remove(carving->complex, carving->own[best.at[k]]);
        carving->own[best.at[k]] = carving->own[--carving->mine];
    }
    for (unsigned p = 0; p < best.parts && status == VOR_OK; p++)
        status = add(carving, best.part[p], err);
    return status;
}

/* Fills what was taken away; *done says whether that was possible. */
static vor_status fill(struct carving *carving, int *done, struct vor_error *err)
{
    vor_status status = VOR_OK;

    *done = vor_cut_find(&carving->cut);
    for (unsigned t = 0; t < carving->cut.taken && *done && status == VOR_OK; t++) {
        *done = vor_complex_takes(carving->complex, carving->cut.triangle[t]);
        if (*done)
            status = add(carving, carving->cut.triangle[t], err);
    }
    for (unsigned i = 0; i < carving->inner && *done && status == VOR_OK; i++)
        status = insert(carving, carving->point[i], done, err);
    while (!*done && carving->mine > 0)
        vor_complex_remove(carving->complex, carving->own[--carving->mine]);
    return status;
}

/* Whether a loop is still open, and only other triangles are in the way of closing it. */
static int is_in_the_way(struct carving *carving)
{
    struct vor_cut *cut = &carving->cut;
    int found;

    for (unsigned k = 0; k < cut->count; k++) {
        uint32_t third[2];

        if (vor_complex_edge(carving->complex, cut->loop[k], cut->loop[(k + 1) % cut->count],
                             third) != 1)
            return 0;
    }
    cut->blind = 1;
    found = vor_cut_find(cut);
    cut->blind = 0;
    return found;
}

static vor_status carve_loop(struct carving *carving, size_t *closed, struct vor_error *err)
{
    vor_status status = VOR_OK;
    int done = 0;

    if (carving->cut.count > VOR_CUT_MOST || !is_in_the_way(carving))
        return VOR_OK;
    carving->points = carving->gone = carving->mine = 0;
    for (unsigned k = 0; k < carving->cut.count; k++)
        list_point(carving, carving->cut.loop[k]);
    while (!done && status == VOR_OK && take_ring(carving))
        if (find_border(carving))
            status = fill(carving, &done, err);
    for (unsigned t = 0; t < carving->gone && !done; t++)
        vor_complex_put(carving->complex, carving->number[t], carving->corner[t]);
    *closed += done != 0;
    return status;
}

/* Carves the loops that there are. */
static vor_status carve_all(struct carving *carving, const struct vor_rims *rims, size_t *closed,
                            const struct vor_run *run, struct vor_error *err)
{
    struct vor_facing facing;
    vor_status status = vor_facing_turn(carving->complex, &facing, NULL, err);

    for (size_t l = 0; l < rims->count && status == VOR_OK; l++) {
        vor_cut_set_loop(&carving->cut, rims, l);
        status = vor_run_answered(vor_run_poll(run), err);
        VOR_THEN(status, carve_loop(carving, closed, err));
    }
    return status;
}

vor_status vor_carve(struct vor_complex *complex, size_t *closed, const struct vor_balls *balls,
                     const struct vor_run *run, struct vor_error *err)
{
    struct carving *carving = vor_calloc(complex->memory, 1, sizeof *carving);
    struct vor_rims rims = {.count = 0};
    vor_status status;

    if (carving == NULL)
        return vor_fail(err, VOR_E_NOMEM, "closing loops of the mesh");
    carving->complex = complex;
    carving->side = vor_calloc(complex->memory, complex->n, 1);
    carving->cut = (struct vor_cut){.complex = complex, .balls = balls, .side = carving->side};
    status = carving->side == NULL ? vor_fail(err, VOR_E_NOMEM, "%zu points", complex->n)
                                   : vor_rims_find(&rims, complex, balls->sheet, err);
    if (status == VOR_OK && rims.count > 0)
        status = carve_all(carving, &rims, closed, run, err);
    vor_rims_free(&rims);
    VOR_FREE_ALL(complex->memory, carving->side, carving);
    return status;
}
