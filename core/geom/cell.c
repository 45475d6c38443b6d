#include "core/geom/cell.h"

#include "core/base/linalg.h"
#include "core/base/vector.h"

#include <float.h>
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

/* The tangent plane at the seed, in the surface's axes: two of its directions, and its height over
 * the seed. */
struct tangent {
    double e[2][3], height;
};

VOR_INLINE void find_tangent(struct tangent *out, const struct vor_surface *surface,
                             const double seed[3])
{
    double g[2], w = vor_surface_height(surface, seed[0], seed[1], g) - seed[2];
    double a = sqrt(1 + g[0] * g[0]), b = sqrt(1 + g[0] * g[0] + g[1] * g[1]);

    *out = (struct tangent){{{1 / a, 0, g[0] / a}, {-g[0] * g[1] / (a * b), a / b, g[1] / (a * b)}},
                            w};
}

VOR_INLINE void put_corner(double corner[4], const struct tangent *plane, double s, double t)
{
    for (int c = 0; c < 3; c++)
        corner[c] = s * plane->e[0][c] + t * plane->e[1][c];
    corner[2] += plane->height;
    corner[3] = vor_dot(corner, corner);
}

/* The polygon of these corners in the tangent plane at the seed, one piece. Inlined, so that the
 * compiler knows the corners. */
VOR_INLINE void begin_flat(struct vor_cell *cell, const struct vor_surface *surface, double radius,
                           const double (*corner)[2], unsigned sides)
{
    struct vor_polygon *piece = &cell->piece[0];
    struct tangent plane;

    find_tangent(&plane, surface, cell->seed);
    piece->count = sides;
    for (unsigned i = 0; i < sides; i++)
        put_corner(piece->vertex[i], &plane, radius * corner[i][0], radius * corner[i][1]);
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

enum { WRAP_LANES = 8 };
typedef float wraps __attribute__((vector_size(4 * WRAP_LANES), aligned(4), may_alias));
typedef int32_t wrap_marks __attribute__((vector_size(4 * WRAP_LANES), aligned(4), may_alias));

/* Bisectors in the tangent plane: along[0] x + along[1] y = room. Those beyond the last have no
 * direction. */
struct lines {
    unsigned count;
    float along[2][VOR_CELL_WRAP_MAX], room[VOR_CELL_WRAP_MAX];
};

VOR_INLINE int all(const wrap_marks *of)
{
    return ((*of)[0] & (*of)[1] & (*of)[2] & (*of)[3] & (*of)[4] & (*of)[5] & (*of)[6] &
            (*of)[7]) != 0;
}

/* Returns whether the seed is on its side of all. */
VOR_INLINE int find_lines(struct lines *out, const struct tangent *plane, const double axis[3][3],
                          const struct vor_cell_around *around)
{
    const float *at = &around->xyz[3 * around->i];
    float e[3][3], way[3][VOR_CELL_WRAP_MAX];
    wrap_marks within = {-1, -1, -1, -1, -1, -1, -1, -1};

    for (int c = 0; c < 3; c++) {
        for (int d = 0; d < 2; d++)
            e[d][c] = (float)(plane->e[d][0] * axis[0][c] + plane->e[d][1] * axis[1][c] +
                              plane->e[d][2] * axis[2][c]);
        e[2][c] = (float)(plane->height * axis[2][c]);
    }
    for (unsigned j = 0; j < around->count; j++)
        for (unsigned c = 0; c < 3; c++)
            way[c][j] = around->xyz[3 * (size_t)around->index[j] + c] - at[c];
    for (out->count = around->count; out->count % WRAP_LANES > 0; out->count++)
        way[0][out->count] = way[1][out->count] = way[2][out->count] = 0;
    for (unsigned j = 0; j < out->count; j += WRAP_LANES) {
        wraps x = *(const wraps *)&way[0][j], y = *(const wraps *)&way[1][j];
        wraps z = *(const wraps *)&way[2][j];
        wraps room = (x * x + y * y + z * z) / 2 - (e[2][0] * x + e[2][1] * y + e[2][2] * z);

        *(wraps *)&out->along[0][j] = e[0][0] * x + e[0][1] * y + e[0][2] * z;
        *(wraps *)&out->along[1][j] = e[1][0] * x + e[1][1] * y + e[1][2] * z;
        *(wraps *)&out->room[j] = room;
        within &= room >= 0;
    }
    return all(&within);
}

VOR_INLINE void take_less(wrap_marks *least, const wrap_marks *other)
{
    wrap_marks less = *other < *least;

    *least = (*other & less) | (*least & ~less);
}

/* The line that crosses a line first, counter-clockwise of `from` on it, along `way`. Distances
 * from 0 on have the order of their bits, of which the last here say which line it is. */
VOR_INLINE unsigned next_line(const struct lines *lines, const float from[2], const float way[2])
{
    const wraps none = {FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX};
    const wrap_marks lane = {0, 1, 2, 3, 4, 5, 6, 7};
    wrap_marks least = (wrap_marks)none, other;

    for (unsigned j = 0; j < lines->count; j += WRAP_LANES) {
        wraps x = *(const wraps *)&lines->along[0][j], y = *(const wraps *)&lines->along[1][j];
        wraps turn = way[0] * x + way[1] * y;
        wraps here = (*(const wraps *)&lines->room[j] - from[0] * x - from[1] * y) / turn;
        wrap_marks ahead = turn > 0, far = (wrap_marks)here & (here > 0);

        far = (far & ahead) | ((wrap_marks)none & ~ahead);
        far = (far & -VOR_CELL_WRAP_MAX) | (lane + (int)j);
        take_less(&least, &far);
    }
    other = __builtin_shufflevector(least, least, 4, 5, 6, 7, 0, 1, 2, 3);
    take_less(&least, &other);
    other = __builtin_shufflevector(least, least, 2, 3, 0, 1, 6, 7, 4, 5);
    take_less(&least, &other);
    other = __builtin_shufflevector(least, least, 1, 0, 3, 2, 5, 4, 7, 6);
    take_less(&least, &other);
    return (unsigned)least[0] & (VOR_CELL_WRAP_MAX - 1);
}

/* Where two lines meet. Returns whether the second one turns counter-clockwise. */
VOR_INLINE int meet(double out[2], const struct lines *lines, unsigned i, unsigned j)
{
    double a[2] = {(double)lines->along[0][i], (double)lines->along[1][i]};
    double b[2] = {(double)lines->along[0][j], (double)lines->along[1][j]};
    double at = (double)lines->room[i], to = (double)lines->room[j];
    double turn = a[0] * b[1] - a[1] * b[0];

    out[0] = (at * b[1] - to * a[1]) / turn;
    out[1] = (to * a[0] - at * b[0]) / turn;
    return turn > 0;
}

/* The line nearest to the seed: its foot lies on a side of the cell. That of the nearest seed need
 * not, which may be above the plane. */
VOR_INLINE unsigned nearest_line(const struct lines *lines)
{
    unsigned best = 0;
    float room2 = INFINITY, along2 = 1;

    for (unsigned j = 0; j < lines->count; j++) {
        float x = lines->along[0][j], y = lines->along[1][j], here2 = x * x + y * y;
        float own2 = lines->room[j] * lines->room[j];

        if (here2 > 0 && own2 * along2 < room2 * here2) {
            room2 = own2;
            along2 = here2;
            best = j;
        }
    }
    return best;
}

/* Goes around the cell in the tangent plane. Corner j lies where side[j] and the next one meet. */
VOR_INLINE int go_around(struct vor_polygon *piece, unsigned side[VOR_POLYGON_MAX],
                         const struct tangent *plane, const struct lines *lines, double inner)
{
    const float *x = lines->along[0], *y = lines->along[1];
    unsigned first = nearest_line(lines), at = first;
    float share = lines->room[at] / (x[at] * x[at] + y[at] * y[at]);
    float from[2] = {share * x[at], share * y[at]};

    piece->count = 0;
    piece->radius2 = 0;
    do {
        unsigned next = next_line(lines, from, (float[2]){-y[at], x[at]});
        double corner[2], *vertex;

        if (!meet(corner, lines, at, next) || piece->count == VOR_POLYGON_MAX)
            return 0;
        side[piece->count] = at;
        vertex = piece->vertex[piece->count++];
        put_corner(vertex, plane, corner[0], corner[1]);
        if (!(vertex[3] <= inner * inner))
            return 0;
        piece->radius2 = vertex[3] > piece->radius2 ? vertex[3] : piece->radius2;
        from[0] = (float)corner[0];
        from[1] = (float)corner[1];
        at = next;
    } while (at != first);
    return 1;
}

/* Moves a corner to where the bisectors with the seeds at a and b meet on the surface: by one step
 * of Newton's method. */
VOR_INLINE void lift_corner(double corner[4], const struct vor_surface *surface,
                            const double seed[3], const double a[3], const double b[3])
{
    double g[2], m[2][2], r[2], turn;

    corner[2] = vor_surface_height(surface, seed[0] + corner[0], seed[1] + corner[1], g) - seed[2];
    for (int c = 0; c < 2; c++) {
        m[0][c] = a[c] + a[2] * g[c];
        m[1][c] = b[c] + b[2] * g[c];
    }
    r[0] = vor_dot(a, a) / 2 - vor_dot(a, corner);
    r[1] = vor_dot(b, b) / 2 - vor_dot(b, corner);
    turn = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    if (turn > 0) {
        corner[0] += (r[0] * m[1][1] - r[1] * m[0][1]) / turn;
        corner[1] += (r[1] * m[0][0] - r[0] * m[1][0]) / turn;
    }
    corner[2] =
        vor_surface_height(surface, seed[0] + corner[0], seed[1] + corner[1], NULL) - seed[2];
    corner[3] = vor_dot(corner, corner);
}

/* Makes triangles on the surface of the polygon in the tangent plane, one for each side. */
VOR_INLINE void lift(struct vor_cell *cell, const struct vor_surface *surface, double height,
                     const unsigned side[VOR_POLYGON_MAX], const struct vor_cell_around *around)
{
    const double middle[4] = {0, 0, height, height * height};
    double to[VOR_POLYGON_MAX][3] = {{0}}; /* clang-analyzer cannot see that the loop sets them */
    struct vor_polygon flat = cell->piece[0];

    for (unsigned j = 0; j < flat.count; j++) {
        double way[3];

        vor_way(way, &around->xyz[3 * around->i], &around->xyz[3 * (size_t)around->index[side[j]]]);
        for (int c = 0; c < 3; c++)
            to[j][c] = vor_dot(surface->axis[c], way);
    }
    cell->count = flat.count;
    cell->radius2 = 0;
    for (unsigned j = 0; j < flat.count; j++)
        lift_corner(flat.vertex[j], surface, cell->seed, to[j], to[(j + 1) % flat.count]);
    for (unsigned j = 0; j < flat.count; j++) {
        struct vor_polygon *piece = &cell->piece[j];

        piece->count = 3;
        memcpy(piece->vertex[0], middle, sizeof middle);
        memcpy(piece->vertex[1], flat.vertex[j], sizeof flat.vertex[j]);
        memcpy(piece->vertex[2], flat.vertex[(j + 1) % flat.count], sizeof flat.vertex[j]);
        find_radius(piece);
        cell->radius2 = piece->radius2 > cell->radius2 ? piece->radius2 : cell->radius2;
    }
}

VOR_CLONES int vor_cell_wrap(struct vor_cell *cell, const struct vor_surface *surface,
                             const double seed[3], double inner,
                             const struct vor_cell_around *around)
{
    struct vor_polygon *piece = &cell->piece[0];
    unsigned side[VOR_POLYGON_MAX];
    struct tangent plane;
    struct lines lines;

    if (around->count == 0 || around->count > VOR_CELL_WRAP_MAX)
        return 0;
    find_tangent(&plane, surface, seed);
    if (!find_lines(&lines, &plane, surface->axis, around) ||
        !go_around(piece, side, &plane, &lines, inner))
        return 0;
    memcpy(cell->seed, seed, sizeof cell->seed);
    cell->bisectors = piece->count;
    cell->radius2 = piece->radius2;
    cell->count = 1;
    if (around->bent)
        lift(cell, surface, plane.height, side, around);
    return cell->radius2 <= inner * inner;
}
