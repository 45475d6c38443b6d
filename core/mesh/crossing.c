#include "core/mesh/crossing.h"

#include "core/base/linalg.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Points nearest to the middle of a triangle at which others are looked for. One that passes
 * through it has a corner within 1.2 edges of the middle; on each of three even sheets 8 points
 * reach 1.5 edges far. On shell60k 6, 16, 24 and 48 find the same. */
enum { AROUND = VOR_BALLS_MANY, BLOCK = 256 };

/* What workers share. */
struct crossing {
    const struct vor_complex *complex;
    const struct vor_sheet *sheet;
    const struct vor_knn *knn; /* over the points */
    unsigned most;             /* points looked at */
    unsigned char *passes;     /* count: NOT, or which other the triangle passes through */
};

/* One that no lists lead to, of another sheet; one that they do lead to. */
enum { NOT, OTHER, RELATED };

/* Whether the edge from a to b passes through the inside of a triangle of such corners. */
static int passes(const float *a, const float *b, const float *const corner[3])
{
    double side[3], other[3], normal[3], to_a[3], to_b[3], up, down, at[3];

    vor_way(side, corner[0], corner[1]);
    vor_way(other, corner[0], corner[2]);
    vor_cross(normal, side, other);
    vor_way(to_a, corner[0], a);
    vor_way(to_b, corner[0], b);
    up = vor_dot(to_a, normal);
    down = vor_dot(to_b, normal);
    if (!(up * down < 0))
        return 0;
    for (int c = 0; c < 3; c++)
        at[c] = (double)a[c] + up / (up - down) * ((double)b[c] - (double)a[c]);
    for (int e = 0; e < 3; e++) {
        double from[3], turn[3];

        vor_way(side, corner[e], corner[(e + 1) % 3]);
        for (int c = 0; c < 3; c++)
            from[c] = at[c] - (double)corner[e][c];
        vor_cross(turn, side, from);
        if (!(vor_dot(turn, normal) > 0))
            return 0;
    }
    return 1;
}

/* How many corners two triangles have in common, and which: 3 where none is. */
static int share(const uint32_t s[3], const uint32_t t[3], int common[2])
{
    int count = 0;

    common[0] = common[1] = 3;
    for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++)
            if (s[c] == t[d]) {
                common[0] = c;
                common[1] = d;
                count++;
            }
    return count;
}

/* Triangles that are kept in mind, by their last bits: each comes up at three corners. */
enum { SLOTS = 256 };

/* A triangle that others are compared with. */
struct one {
    const float *xyz; /* of all points */
    const uint32_t *corner;
    const float *x[3];
    float low[3], high[3]; /* the box around it */
    double normal[3];
    uint32_t compared[SLOTS];
};

static void take(struct one *one, const float *xyz, const uint32_t corner[3])
{
    one->xyz = xyz;
    one->corner = corner;
    for (int c = 0; c < 3; c++)
        one->x[c] = &xyz[3 * (size_t)corner[c]];
    for (int c = 0; c < 3; c++) {
        one->low[c] = one->high[c] = one->x[0][c];
        for (int k = 1; k < 3; k++) {
            one->low[c] = one->x[k][c] < one->low[c] ? one->x[k][c] : one->low[c];
            one->high[c] = one->x[k][c] > one->high[c] ? one->x[k][c] : one->high[c];
        }
    }
    vor_triangle_normal(one->normal, xyz, corner);
    memset(one->compared, 0xff, sizeof one->compared);
}

/* Whether corners lie on both sides of a plane through a place. */
static int straddle(const float *const corner[3], const float *place, const double normal[3])
{
    double to[3], low = 0, high = 0;

    for (int c = 0; c < 3; c++) {
        double up;

        vor_way(to, place, corner[c]);
        up = vor_dot(to, normal);
        low = up < low ? up : low;
        high = up > high ? up : high;
    }
    return low < 0 && high > 0;
}

/* Whether there is room between the boxes around two triangles. */
static int are_apart(const struct one *one, const float *const b[3])
{
    for (int c = 0; c < 3; c++)
        if ((b[0][c] < one->low[c] && b[1][c] < one->low[c] && b[2][c] < one->low[c]) ||
            (b[0][c] > one->high[c] && b[1][c] > one->high[c] && b[2][c] > one->high[c]))
            return 1;
    return 0;
}

/* Whether two triangles with at most so many common corners, one or none, pass through each other.
 * An edge from a common corner touches. */
static int cross(const struct one *one, const uint32_t t[3], int most)
{
    const float *const *a = one->x;
    const float *b[3];
    double normal[3];
    int common[2];

    for (int c = 0; c < 3; c++)
        b[c] = &one->xyz[3 * (size_t)t[c]];
    if (are_apart(one, b) || share(one->corner, t, common) > most ||
        !straddle(b, a[0], one->normal))
        return 0;
    vor_triangle_normal(normal, one->xyz, t);
    if (!straddle(a, b[0], normal))
        return 0;
    for (int c = 0; c < 3; c++)
        if ((c != common[0] && (c + 1) % 3 != common[0] && passes(a[c], a[(c + 1) % 3], b)) ||
            (c != common[1] && (c + 1) % 3 != common[1] && passes(b[c], b[(c + 1) % 3], a)))
            return 1;
    return 0;
}

/* Points at which triangles are looked for, but for those nearer to a place than `seen2`, and how
 * many corners these may have in common with one that passes through them. */
struct near {
    const uint32_t *point;
    unsigned count;
    int common;
    const float *place;
    float seen2;
    size_t since;
};

/* The first triangle found that passes through another and is not one of the first `since`; their
 * number where none is. */
static size_t find(const struct vor_complex *complex, struct one *one, const struct near *near)
{
    for (unsigned i = 0; i < near->count; i++) {
        const uint32_t *around = &complex->around[(size_t)near->point[i] * VOR_AROUND_MOST];

        if (near->seen2 > 0 && vor_distance2f(near->place, &one->xyz[3 * (size_t)near->point[i]]) <
                                   (double)near->seen2)
            continue;
        for (unsigned k = 0; k < complex->degree[near->point[i]]; k++) {
            uint32_t t = around[k];

            if (t < near->since || one->compared[t % SLOTS] == t)
                continue;
            if (cross(one, &complex->triangle[3 * (size_t)t], near->common))
                return t;
            one->compared[t % SLOTS] = t;
        }
    }
    return complex->count;
}

size_t vor_crossing_near(const struct vor_complex *complex, const struct vor_balls *balls,
                         const uint32_t corner[3], size_t since)
{
    const float *xyz = balls->sheet->seeds->xyz, *place = &xyz[3 * (size_t)corner[2]];
    size_t t = complex->count;
    struct one one;

    take(&one, xyz, corner);
    for (int c = 2; c >= 0 && t == complex->count; c--) {
        const struct near near = {&balls->list[(size_t)corner[c] * VOR_BALLS_FEW],
                                  balls->count[corner[c]],
                                  1,
                                  place,
                                  c == 2 || balls->parts ? 0 : balls->far2[corner[2]],
                                  since};

        t = find(complex, &one, &near);
    }
    return t;
}

/* Whether lists lead from triangle t to another: from its first corner, a spacing from the rest. */
static int is_related(const struct crossing *crossing, size_t t, size_t other)
{
    const uint32_t *root = crossing->sheet->root;

    return vor_graph_leads(crossing->sheet->graph, root[crossing->complex->triangle[3 * t]],
                           root[crossing->complex->triangle[3 * other]]);
}

/* Which triangle t passes through at a point near it. */
static size_t find_crossed(const struct crossing *crossing, size_t t)
{
    const struct vor_complex *complex = crossing->complex;
    const float *xyz = crossing->sheet->seeds->xyz;
    const uint32_t *corner = &complex->triangle[3 * t];
    uint32_t index[AROUND];
    float distance2[AROUND], middle[3] = {0, 0, 0};
    const struct near near = {index, crossing->most, 0, xyz, 0, 0};
    struct one one;

    for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++)
            middle[d] += xyz[3 * (size_t)corner[c] + (size_t)d] / 3;
    vor_knn_search(crossing->knn, middle, 1, crossing->most, index, distance2);
    take(&one, xyz, corner);
    return find(complex, &one, &near);
}

static void cross_row(void *ctx, size_t t, VOR_UNUSED unsigned worker)
{
    const struct crossing *crossing = ctx;
    size_t count = crossing->complex->count, other = count;

    if (crossing->complex->triangle[3 * t] != VOR_COMPLEX_GONE)
        other = find_crossed(crossing, t);
    crossing->passes[t] = other == count ? NOT : is_related(crossing, t, other) ? RELATED : OTHER;
}

/* Marks the triangles that pass through others, and counts those that are related. */
static vor_status mark(struct crossing *crossing, size_t *count, const struct vor_run *run,
                       struct vor_error *err)
{
    const struct vor_seeds *seeds = crossing->sheet->seeds;
    struct vor_knn *knn = NULL;
    vor_status status = vor_knn_build(&knn, seeds->xyz, seeds->n, run->memory, err);

    crossing->knn = knn;
    crossing->most = seeds->n < AROUND ? (unsigned)seeds->n : AROUND;
    VOR_THEN(status, vor_run_rows(run, crossing->complex->count, BLOCK, cross_row, crossing, err));
    vor_knn_free(knn);
    *count = 0;
    for (size_t t = 0; t < crossing->complex->count && status == VOR_OK; t++)
        *count += crossing->passes[t] == RELATED;
    return status;
}

/* Puts the corners of triangles that pass through related ones back to where they were. */
static void put_back(const struct crossing *crossing, float *xyz, const float *before)
{
    for (size_t t = 0; t < crossing->complex->count; t++)
        for (size_t c = 0; c < 3 && crossing->passes[t] == RELATED; c++) {
            size_t i = crossing->complex->triangle[3 * t + c];

            memcpy(&xyz[3 * i], &before[3 * i], 3 * sizeof *xyz);
        }
}

static void drop(struct vor_complex *complex, const unsigned char *passes)
{
    for (size_t t = 0; t < complex->count; t++)
        if (passes[t])
            vor_complex_remove(complex, (uint32_t)t);
    vor_complex_prune(complex);
}

vor_status vor_crossing_drop(struct vor_complex *complex, struct vor_seeds *seeds,
                             const struct vor_sheet *sheet, const float *before,
                             struct vor_error *err)
{
    const struct vor_run *run = &seeds->run;
    struct crossing crossing = {.complex = complex, .sheet = sheet};
    size_t count, last = 2 * complex->count;
    vor_status status;

    if (complex->count == 0)
        return VOR_OK;
    crossing.passes = vor_malloc(run->memory, complex->count, 1);
    if (crossing.passes == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu triangles", complex->count);
    status = mark(&crossing, &count, run, err);
    while (status == VOR_OK && before != NULL && count > 0 && count <= last / 2) {
        last = count;
        put_back(&crossing, seeds->xyz, before);
        status = mark(&crossing, &count, run, err);
    }
    if (status == VOR_OK)
        drop(complex, crossing.passes);
    vor_free(run->memory, crossing.passes);
    return status;
}
