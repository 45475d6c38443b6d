#include "core/mesh/cut.h"

#include "core/base/linalg.h"
#include "core/mesh/crossing.h"
#include "core/mesh/quality.h"

/* Edges of a loop whose cells disagreed on three triangles: what they lie on does not matter
 * as long as it is one sheet of the input. */
enum { SMALL = 5 };

/* Quality that a triangle without area counts as, and how much more one costs that stands upright
 * on the tangent planes of its corners. */
#define LEAST 0.02
#define UPRIGHT 3.0

/* Whether a and b may be joined by an edge inside of the loop. Lists are asked where the front asks
 * them to the end. */
static int may_join(const struct vor_cut *cut, unsigned a, unsigned b)
{
    uint32_t i = cut->loop[a], j = cut->loop[b], third[2];

    if (b == a + 1 || (a == 0 && b == cut->count - 1))
        return 1;
    return i != j && vor_complex_edge(cut->complex, i, j, third) == 0 &&
           (cut->count <= SMALL || vor_sheet_is_beside(cut->balls->sheet, i, j)) &&
           (!cut->balls->parts || vor_sheet_leads(cut->balls->sheet, i, j));
}

double vor_cut_cost(const struct vor_cut *cut, const uint32_t corner[3])
{
    const struct vor_sheet *sheet = cut->balls->sheet;
    const float *xyz = sheet->seeds->xyz;
    double normal[3], length, agrees = 0;

    vor_triangle_normal(normal, xyz, corner);
    length = sqrt(vor_dot(normal, normal));
    for (int c = 0; c < 3 && length > 0; c++) {
        const float *m = &sheet->normal[3 * (size_t)corner[c]];

        double up = normal[0] * (double)m[0] + normal[1] * (double)m[1] + normal[2] * (double)m[2];
        int side = cut->side == NULL ? 0 : cut->side[corner[c]];

        agrees += (side != 0 ? side * up : fabs(up)) / (3 * length);
    }
    return (1 + UPRIGHT * (1 - agrees)) / fmax(vor_triangle_quality(xyz, corner), LEAST);
}

/* Finds the best way to cut the part from a to b. */
static void cut_part(struct vor_cut *cut, unsigned a, unsigned b)
{
    const uint32_t *loop = cut->loop;

    cut->cost[a][b] = INFINITY;
    if (!may_join(cut, a, b))
        return;
    for (unsigned m = a + 1; m < b; m++) {
        uint32_t corner[3] = {loop[a], loop[m], loop[b]};
        double cost = cut->cost[a][m] + cut->cost[m][b];

        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[0] == corner[2] ||
            !(cost < cut->cost[a][b]))
            continue;
        cost += vor_cut_cost(cut, corner);
        if (cost < cut->cost[a][b] &&
            (cut->blind ||
             vor_crossing_near(cut->complex, cut->balls, corner, 0) == cut->complex->count)) {
            cut->cost[a][b] = cost;
            cut->by[a][b] = (unsigned char)m;
        }
    }
}

static void collect(struct vor_cut *cut, unsigned a, unsigned b)
{
    unsigned begin[VOR_CUT_MOST], end[VOR_CUT_MOST], waiting = 1;

    cut->taken = 0;
    begin[0] = a;
    end[0] = b;
    while (waiting > 0) {
        unsigned from = begin[--waiting], to = end[waiting], m;
        uint32_t *corner;

        if (to == from + 1)
            continue;
        m = cut->by[from][to];
        corner = cut->triangle[cut->taken++];
        corner[0] = cut->loop[from];
        corner[1] = cut->loop[m];
        corner[2] = cut->loop[to];
        begin[waiting] = from;
        end[waiting++] = m;
        begin[waiting] = m;
        end[waiting++] = to;
    }
}

void vor_cut_set_loop(struct vor_cut *cut, const struct vor_rims *rims, size_t l)
{
    size_t count = rims->start[l + 1] - rims->start[l];

    cut->loop = &rims->point[rims->start[l]];
    cut->count = (unsigned)(count <= VOR_CUT_MOST ? count : VOR_CUT_MOST + 1);
}

int vor_cut_find(struct vor_cut *cut)
{
    unsigned count = cut->count;

    for (unsigned a = 0; a + 1 < count; a++)
        cut->cost[a][a + 1] = 0;
    for (unsigned width = 2; width < count; width++)
        for (unsigned a = 0; a + width < count; a++)
            cut_part(cut, a, a + width);
    if (!(cut->cost[0][count - 1] < INFINITY))
        return 0;
    collect(cut, 0, count - 1);
    for (unsigned t = 0; t < cut->taken; t++)
        if (!vor_sheet_is_under(cut->balls->sheet, cut->triangle[t]))
            return 0;
    return 1;
}
