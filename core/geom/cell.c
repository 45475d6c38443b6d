#include "core/geom/cell.h"

#include "core/base/linalg.h"
#include "core/base/vector.h"

#include <string.h>

enum { LANES = 4 };
typedef double lanes __attribute__((vector_size(8 * LANES), aligned(8), may_alias));
typedef int64_t marks __attribute__((vector_size(8 * LANES), aligned(8), may_alias));

VOR_INLINE void find_radius(struct vor_polygon *polygon)
{
    double far = 0;

    for (unsigned j = 0; j < polygon->count; j++)
        far = polygon->vertex[j][3] > far ? polygon->vertex[j][3] : far;
    polygon->radius2 = far;
}

/* The polygon of these corners in the tangent plane at the seed, one piece. Inlined, so that the
 * compiler knows the corners. */
VOR_INLINE void begin_flat(struct vor_cell *cell, const struct vor_surface *surface, double radius,
                           const double (*corner)[2], unsigned sides)
{
    struct vor_polygon *piece = &cell->piece[0];
    double g[2], w = vor_surface_height(surface, cell->seed[0], cell->seed[1], g) - cell->seed[2];
    double a = sqrt(1 + g[0] * g[0]), b = sqrt(1 + g[0] * g[0] + g[1] * g[1]);
    double e[2][3] = {{1 / a, 0, g[0] / a}, {-g[0] * g[1] / (a * b), a / b, g[1] / (a * b)}};

    piece->count = sides;
    for (unsigned i = 0; i < sides; i++) {
        double s = radius * corner[i][0], t = radius * corner[i][1];

        for (int c = 0; c < 3; c++)
            piece->vertex[i][c] = s * e[0][c] + t * e[1][c];
        piece->vertex[i][2] += w;
        piece->vertex[i][3] = vor_dot(piece->vertex[i], piece->vertex[i]);
    }
    find_radius(piece);
    cell->radius2 = piece->radius2;
    cell->count = 1;
}

void vor_cell_begin(struct vor_cell *cell, const struct vor_disc *disc,
                    const struct vor_surface *surface, const double seed[3], double radius)
{
    double lifted[VOR_PATCH_VERTICES_MAX][4];

    memcpy(cell->seed, seed, sizeof cell->seed);
    cell->bisectors = 0;
    cell->radius2 = 0;
    if (disc->triangle_count == 0) {
        if (disc->sides == VOR_PATCH_HEXAGON)
            begin_flat(cell, surface, radius, vor_patch_corner, VOR_PATCH_HEXAGON);
        else
            begin_flat(cell, surface, radius, vor_patch_octagon, VOR_PATCH_OCTAGON);
        return;
    }
    for (unsigned i = 0; i < disc->vertex_count; i++) {
        double u = radius * disc->vertex[i][0], v = radius * disc->vertex[i][1];

        lifted[i][0] = u;
        lifted[i][1] = v;
        lifted[i][2] = vor_surface_height(surface, seed[0] + u, seed[1] + v, NULL) - seed[2];
        lifted[i][3] = vor_dot(lifted[i], lifted[i]);
    }
    cell->count = disc->triangle_count;
    for (unsigned i = 0; i < cell->count; i++) {
        cell->piece[i].count = 3;
        for (unsigned j = 0; j < 3; j++)
            memcpy(cell->piece[i].vertex[j], lifted[disc->triangle[i][j]], sizeof lifted[0]);
        find_radius(&cell->piece[i]);
        if (cell->piece[i].radius2 > cell->radius2)
            cell->radius2 = cell->piece[i].radius2;
    }
}

/* The point where the edge from a to b meets the plane, from their signed distances to it. */
VOR_INLINE void cut_edge(double cut[4], const double a[3], const double b[3], double side_a,
                         double side_b)
{
    double t = side_a / (side_a - side_b);
    double x = a[0] + t * (b[0] - a[0]), y = a[1] + t * (b[1] - a[1]), z = a[2] + t * (b[2] - a[2]);

    cut[0] = x;
    cut[1] = y;
    cut[2] = z;
    cut[3] = x * x + y * y + z * z;
}

/* Clips by one plane (Sutherland and Hodgman 1974): corners with side[i] <= 0 stay. from and to are
 * different polygons. */
VOR_INLINE void clip_polygon(struct vor_polygon *to, const struct vor_polygon *from,
                             const double *side)
{
    unsigned n = from->count, count = 0;

    for (unsigned i = 0; i < n; i++) {
        unsigned j = i + 1 < n ? i + 1 : 0;

        if (side[i] <= 0)
            memcpy(to->vertex[count++], from->vertex[i], sizeof from->vertex[i]);
        if ((side[i] <= 0) != (side[j] <= 0))
            cut_edge(to->vertex[count++], from->vertex[i], from->vertex[j], side[i], side[j]);
    }
    to->count = count;
    find_radius(to);
}

/* Moves corners within an array. Few are moved: a call of memmove takes longer. */
VOR_INLINE void move_corners(double (*vertex)[4], unsigned to, unsigned from, unsigned n)
{
    lanes *at = (lanes *)vertex[to];
    const lanes *of = (const lanes *)vertex[from];

    for (unsigned j = 0; to < from && j < n; j++)
        at[j] = of[j];
    for (unsigned j = n; to > from && j-- > 0;)
        at[j] = of[j];
}

/* The same in place. Some corners are outside, not all, and they follow one another, as they do in
 * a convex polygon unless rounding interferes. */
VOR_INLINE void clip_in_place(struct vor_polygon *polygon, const double *side)
{
    double(*vertex)[4] = polygon->vertex, leave[4], enter[4];
    unsigned n = polygon->count, begin = 0, end;

    if (side[0] > 0) {
        for (begin = n - 1; side[begin] > 0;)
            begin--;
        for (end = 1; side[end] > 0;)
            end++;
        begin++; /* kept: from end to before begin */
        cut_edge(leave, vertex[begin - 1], vertex[begin % n], side[begin - 1], side[begin % n]);
        cut_edge(enter, vertex[end - 1], vertex[end], side[end - 1], side[end]);
        move_corners(vertex, 1, end, begin - end);
        polygon->count = begin - end + 2;
        memcpy(vertex[0], enter, sizeof enter);
        memcpy(vertex[polygon->count - 1], leave, sizeof leave);
    } else {
        while (side[begin] <= 0)
            begin++;
        for (end = begin + 1; end < n && side[end] > 0;)
            end++;
        cut_edge(leave, vertex[begin - 1], vertex[begin], side[begin - 1], side[begin]);
        cut_edge(enter, vertex[end - 1], vertex[end % n], side[end - 1], side[end % n]);
        move_corners(vertex, begin + 2, end, n - end);
        polygon->count = n - (end - begin) + 2;
        memcpy(vertex[begin], leave, sizeof leave);
        memcpy(vertex[begin + 1], enter, sizeof enter);
    }
    find_radius(polygon);
}

VOR_INLINE void copy_polygon(struct vor_polygon *to, const struct vor_polygon *from)
{
    to->count = from->count;
    to->radius2 = from->radius2;
    for (unsigned j = 0; j < from->count; j++)
        memcpy(to->vertex[j], from->vertex[j], sizeof from->vertex[j]);
}

/* Clips a polygon with some corners outside, whose boundary crosses the plane at `turns` edges. */
VOR_INLINE void clip_piece(struct vor_polygon *polygon, const double *side, unsigned turns)
{
    struct vor_polygon clipped;

    if (polygon->count >= VOR_POLYGON_MAX - 1)
        return; /* full (VOR_POLYGON_MAX): left uncut */
    if (turns == 2) {
        clip_in_place(polygon, side);
        return;
    }
    clip_polygon(&clipped, polygon, side);
    copy_polygon(polygon, &clipped);
}

/* Finds the signed distances of all corners to a plane, and beyond them of what there is in the
 * array. Returns a bit for each that is outside. */
VOR_INLINE uint32_t find_sides(double side[VOR_POLYGON_MAX], const struct vor_polygon *polygon,
                               const double offset[3], double limit)
{
    const marks bit = {1, 2, 4, 8};
    uint32_t outside = 0;

    for (unsigned j = 0; j < polygon->count; j += LANES) {
        const lanes *corner = (const lanes *)polygon->vertex[j];
        lanes a, b, c, d, x, y, z, here;
        marks out;

        a = __builtin_shufflevector(corner[0], corner[1], 0, 4, 2, 6);
        b = __builtin_shufflevector(corner[0], corner[1], 1, 5, 3, 7);
        c = __builtin_shufflevector(corner[2], corner[3], 0, 4, 2, 6);
        d = __builtin_shufflevector(corner[2], corner[3], 1, 5, 3, 7);
        x = __builtin_shufflevector(a, c, 0, 1, 4, 5);
        y = __builtin_shufflevector(b, d, 0, 1, 4, 5);
        z = __builtin_shufflevector(a, c, 2, 3, 6, 7);
        here = x * offset[0] + y * offset[1] + z * offset[2] - limit;
        out = (here > 0) & bit;
        outside |= (uint32_t)(out[0] | out[1] | out[2] | out[3]) << j;
        *(lanes *)&side[j] = here;
    }
    return outside & ((UINT32_C(1) << polygon->count) - 1);
}

VOR_INLINE void clip(struct vor_cell *cell, const double offset[3], double length2)
{
    double side[VOR_POLYGON_MAX], limit = length2 / 2, far = 0;
    unsigned kept = 0;
    int cut = 0;

    side[0] = 0; /* clang-analyzer cannot see that every polygon has corners */
    for (unsigned i = 0; i < cell->count; i++) {
        struct vor_polygon *polygon = &cell->piece[i];
        uint32_t outside = 0, all = (UINT32_C(1) << polygon->count) - 1;

        /* Otherwise no corner reaches half way to the other seed. */
        if (4 * polygon->radius2 > length2)
            outside = find_sides(side, polygon, offset, limit);
        cut |= outside > 0;
        if (outside == all)
            continue;
        if (outside > 0) {
            uint32_t next = (outside >> 1) | (outside << (polygon->count - 1));

            clip_piece(polygon, side, (unsigned)__builtin_popcount((outside ^ next) & all));
        }
        if (kept != i)
            copy_polygon(&cell->piece[kept], polygon);
        far = cell->piece[kept].radius2 > far ? cell->piece[kept].radius2 : far;
        kept++;
    }
    if (!cut)
        return;
    cell->count = kept;
    cell->bisectors++;
    cell->radius2 = far;
}

VOR_CLONES void vor_cell_clip(struct vor_cell *cell, const double offset[3])
{
    clip(cell, offset, vor_dot(offset, offset));
}

VOR_CLONES unsigned vor_cell_clip_by(struct vor_cell *cell, const double axis[3][3],
                                     const float *xyz, size_t i, const uint32_t *index,
                                     unsigned count)
{
    for (unsigned j = 0; j < count; j++) {
        double way[3], offset[3], length2;

        vor_way(way, &xyz[3 * i], &xyz[3 * (size_t)index[j]]);
        for (int c = 0; c < 3; c++)
            offset[c] = vor_dot(axis[c], way);
        length2 = vor_dot(offset, offset);
        if (!(length2 > 0) || vor_cell_secure(cell, length2))
            return j;
        clip(cell, offset, length2);
    }
    return count;
}
