#include "core/mesh/close.h"

#include "core/base/linalg.h"
#include "core/mesh/crossing.h"
#include "core/mesh/quality.h"
#include "core/mesh/rims.h"
#include "core/mesh/twosided.h"

#include <string.h>

/* Edges of a loop whose cells disagreed on three triangles: what they lie on does not matter
 * as long as it is one sheet of the input. */
enum { SMALL = 5 };

/* Quality that a triangle without area counts as, and how much more one costs that stands upright
 * on the tangent planes of its corners. */
#define LEAST 0.02
#define UPRIGHT 3.0

/* The best ways to cut parts of a loop into triangles: cost[a][b] of the part from point a to b,
 * which begins with the triangle (a, by[a][b], b). */
struct closing {
    struct vor_complex *complex;
    const struct vor_sheet *sheet;
    const struct vor_balls *balls;
    const uint32_t *loop;
    unsigned count;
    double cost[VOR_CLOSE_MOST][VOR_CLOSE_MOST];
    unsigned char by[VOR_CLOSE_MOST][VOR_CLOSE_MOST];
    unsigned taken;
    uint32_t triangle[VOR_CLOSE_MOST][3];
    struct vor_twosided sides; /* of the triangles there are */
};

/* Whether a and b may be joined by an edge inside of the loop. Lists are asked where the front asks
 * them to the end. */
static int may_join(const struct closing *closing, unsigned a, unsigned b)
{
    uint32_t i = closing->loop[a], j = closing->loop[b], third[2];

    if (b == a + 1 || (a == 0 && b == closing->count - 1))
        return 1;
    return i != j && vor_complex_edge(closing->complex, i, j, third) == 0 &&
           (closing->count <= SMALL || vor_sheet_is_beside(closing->sheet, i, j)) &&
           (!closing->balls->parts || vor_sheet_leads(closing->sheet, i, j));
}

/* What a triangle costs: the worse and the more upright, the more. */
static double cost_of(const struct closing *closing, const uint32_t corner[3])
{
    const float *xyz = closing->sheet->seeds->xyz;
    double normal[3], length, agrees = 0;

    vor_triangle_normal(normal, xyz, corner);
    length = sqrt(vor_dot(normal, normal));
    for (int c = 0; c < 3 && length > 0; c++) {
        const float *m = &closing->sheet->normal[3 * (size_t)corner[c]];

        agrees +=
            fabs(normal[0] * (double)m[0] + normal[1] * (double)m[1] + normal[2] * (double)m[2]) /
            (3 * length);
    }
    return (1 + UPRIGHT * (1 - agrees)) / fmax(vor_triangle_quality(xyz, corner), LEAST);
}

/* Finds the best way to cut the part from a to b. */
static void cut_part(struct closing *closing, unsigned a, unsigned b)
{
    const uint32_t *loop = closing->loop;

    closing->cost[a][b] = INFINITY;
    if (!may_join(closing, a, b))
        return;
    for (unsigned m = a + 1; m < b; m++) {
        uint32_t corner[3] = {loop[a], loop[m], loop[b]};
        double cost = closing->cost[a][m] + closing->cost[m][b];

        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[0] == corner[2] ||
            !(cost < closing->cost[a][b]))
            continue;
        cost += cost_of(closing, corner);
        if (cost < closing->cost[a][b] && vor_crossing_near(closing->complex, closing->balls,
                                                            corner, 0) == closing->complex->count) {
            closing->cost[a][b] = cost;
            closing->by[a][b] = (unsigned char)m;
        }
    }
}

static void collect(struct closing *closing, unsigned a, unsigned b)
{
    unsigned begin[VOR_CLOSE_MOST], end[VOR_CLOSE_MOST], waiting = 1;

    closing->taken = 0;
    begin[0] = a;
    end[0] = b;
    while (waiting > 0) {
        unsigned from = begin[--waiting], to = end[waiting], m;
        uint32_t *corner;

        if (to == from + 1)
            continue;
        m = closing->by[from][to];
        corner = closing->triangle[closing->taken++];
        corner[0] = closing->loop[from];
        corner[1] = closing->loop[m];
        corner[2] = closing->loop[to];
        begin[waiting] = from;
        end[waiting++] = m;
        begin[waiting] = m;
        end[waiting++] = to;
    }
}

/* Finds triangles for a loop; returns whether they close it. */
static int find_triangles(struct closing *closing)
{
    unsigned count = closing->count;

    for (unsigned a = 0; a + 1 < count; a++)
        closing->cost[a][a + 1] = 0;
    for (unsigned width = 2; width < count; width++)
        for (unsigned a = 0; a + width < count; a++)
            cut_part(closing, a, a + width);
    if (!(closing->cost[0][count - 1] < INFINITY))
        return 0;
    collect(closing, 0, count - 1);
    for (unsigned t = 0; t < closing->taken; t++)
        if (!vor_sheet_is_under(closing->sheet, closing->triangle[t]))
            return 0;
    return 1;
}

static vor_status close_loop(struct closing *closing, size_t *closed, struct vor_error *err)
{
    vor_status status = VOR_OK;
    int whole = 1;

    if (closing->count > VOR_CLOSE_MOST || !find_triangles(closing))
        return VOR_OK;
    for (unsigned t = 0; t < closing->taken && status == VOR_OK; t++) {
        int takes = vor_complex_takes(closing->complex, closing->triangle[t]) &&
                    vor_twosided_takes(&closing->sides, closing->complex, closing->triangle[t]) &&
                    vor_crossing_near(closing->complex, closing->balls, closing->triangle[t], 0) ==
                        closing->complex->count;

        whole &= takes;
        if (!takes)
            continue;
        status = vor_complex_add(closing->complex, closing->triangle[t], err);
        if (status == VOR_OK)
            vor_twosided_add(&closing->sides, closing->complex,
                             (uint32_t)(closing->complex->count - 1));
    }
    *closed += whole != 0;
    return status;
}

vor_status vor_close(struct vor_complex *complex, size_t *closed, const struct vor_balls *balls,
                     const struct vor_run *run, struct vor_error *err)
{
    struct closing *closing = vor_calloc(complex->memory, 1, sizeof *closing);
    const struct vor_sheet *sheet = balls->sheet;
    struct vor_rims rims = {.count = 0};
    vor_status status;

    *closed = 0;
    if (closing == NULL)
        return vor_fail(err, VOR_E_NOMEM, "closing loops of the mesh");
    closing->complex = complex;
    closing->sheet = sheet;
    closing->balls = balls;
    status = vor_rims_find(&rims, complex, sheet, err);
    if (status == VOR_OK && rims.count > 0) /* a loop of k edges has k - 2 triangles */
        status = vor_twosided_make(&closing->sides, complex, rims.start[rims.count], err);
    for (size_t l = 0; l < rims.count && status == VOR_OK; l++) {
        closing->loop = &rims.point[rims.start[l]];
        closing->count = (unsigned)(rims.start[l + 1] - rims.start[l] <= VOR_CLOSE_MOST
                                        ? rims.start[l + 1] - rims.start[l]
                                        : VOR_CLOSE_MOST + 1);
        status = vor_run_answered(vor_run_poll(run), err);
        VOR_THEN(status, close_loop(closing, closed, err));
    }
    vor_twosided_free(&closing->sides);
    vor_rims_free(&rims);
    vor_free(complex->memory, closing);
    return status;
}
