#include "core/mesh/sheet.h"

#include "core/base/linalg.h"
#include "core/geom/patch.h"
#include "core/input/adjacency.h"
#include "core/input/lists.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Sine of the steepest offset between two seeds over the tangent planes of both, 60 degrees: what
 * is steeper over either lies on the other face of a thin part. Over a crease the one is as steep
 * as the other is flat. */
#define STEEP VOR_HEXAGON_HEIGHT

/* On one surface, bent or creased between two seeds, their normals turn by as much as the offset is
 * steep over both tangent planes, as on a circle. On two parallel sheets they do not turn at all.
 * By so much may the cosine between them be more than that turn gives. At 0.1 / 0.25: the mesh of
 * armadillo (30,000) has a hole / is closed. */
#define STIFF 0.25

/* Distance from a place of a triangle to the nearest input point up to which it lies over the
 * input: in input spacings as far as a point of the result may be, or in its mean edges, for what
 * bends between the points. Midway over a crease of 90 degrees it is 0.35 edges. */
#define NEAR_EDGE 0.4

/* Cosine between the normals of a triangle and of its corners at least. Over a crease of 90 degrees
 * it is 0.7. */
#define ALONG 0.3

static void find_normal(struct vor_sheet *sheet, struct vor_seeds *seeds,
                        const struct vor_recall *how, struct vor_scratch *scratch, size_t i)
{
    const struct vor_surface *surface = how != NULL ? &scratch->onto : &scratch->here.surface;
    double x[3], local[3], normal[3];

    memset(&sheet->normal[3 * i], 0, 3 * sizeof *sheet->normal);
    if ((how != NULL ? vor_seeds_recall(seeds, scratch, i, how)
                     : vor_seeds_fit(seeds, scratch, i)) == VOR_SURFACE_NONE)
        return;
    vor_seeds_position(seeds, i, x);
    vor_surface_to_local(surface, x, local);
    vor_surface_normal(surface, local, normal);
    vor_to_floats(&sheet->normal[3 * i], normal);
}

/* What a worker writes to. */
struct finding {
    struct vor_sheet *sheet;
    struct vor_seeds *seeds;
    const struct vor_recall *how;
    const unsigned char *moved; /* only these are looked at, and put onto the surface; NULL: all */
};

/* Finds what is known of seed i. */
static void find(struct vor_sheet *sheet, struct vor_seeds *seeds, const struct vor_recall *how,
                 struct vor_scratch *scratch, size_t i)
{
    float distance2;
    uint32_t nearest;

    find_normal(sheet, seeds, how, scratch, i);
    vor_knn_search(seeds->domain->knn, &seeds->xyz[3 * i], 1, 1, &nearest, &distance2);
    sheet->near[i] = sqrtf(distance2);
    if (sheet->root == NULL)
        return;
    sheet->root[i] = seeds->last_fit[i].root;
    if (sheet->root[i] == VOR_LISTS_NO_ROOT)
        sheet->root[i] = nearest;
}

void vor_sheet_put_one(struct vor_sheet *sheet, struct vor_seeds *seeds,
                       const struct vor_recall *how, struct vor_scratch *scratch, size_t i)
{
    double x[3];

    if (vor_seeds_recall(seeds, scratch, i, how) != VOR_SURFACE_NONE) {
        vor_seeds_position(seeds, i, x);
        vor_surface_put(&scratch->onto, x);
        vor_to_floats(&seeds->xyz[3 * i], x);
    }
    find(sheet, seeds, how, scratch, i);
}

static void find_row(void *ctx, size_t i, unsigned worker)
{
    struct finding *finding = ctx;
    struct vor_scratch *scratch = &finding->seeds->scratch[worker];

    if (finding->moved == NULL)
        find(finding->sheet, finding->seeds, finding->how, scratch, i);
    else if (finding->moved[i])
        vor_sheet_put_one(finding->sheet, finding->seeds, finding->how, scratch, i);
}

/* Takes the domain's graph, or makes one where fits look for layers without: of lists near second
 * sheets, as nowhere else do lists pay there. Open edges of three closed bowls of 2,000 points,
 * whose wall is 1.55 of their spacings thick: 27, 41, 82, with such lists 0, 0, 8. */
static vor_status take_graph(struct vor_sheet *sheet, const struct vor_seeds *seeds,
                             const struct vor_run *run, struct vor_error *err)
{
    const struct vor_domain *domain = seeds->domain;
    vor_status status = VOR_OK;

    if (vor_graph_is(&domain->graph)) {
        sheet->graph = &domain->graph;
    } else if (seeds->sheets || domain->known.lists != VOR_LISTS_NONE) {
        struct vor_domain seen = *domain;

        if (seen.known.lists == VOR_LISTS_NONE)
            seen.known.lists = VOR_LISTS_FEW;
        status = vor_adjacency_make(&sheet->own, &seen, run, err);
        sheet->graph = status == VOR_OK ? &sheet->own : NULL;
    }
    if (status != VOR_OK || sheet->graph == NULL)
        return status;
    sheet->root = vor_malloc(seeds->run.memory, seeds->n, sizeof *sheet->root);
    return sheet->root == NULL ? vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n) : VOR_OK;
}

vor_status vor_sheet_find(struct vor_sheet *out, struct vor_seeds *seeds,
                          const struct vor_recall *how, const struct vor_run *run,
                          struct vor_error *err)
{
    struct finding finding = {out, seeds, how, NULL};
    vor_status status;

    memset(out, 0, sizeof *out);
    out->seeds = seeds;
    out->normal = vor_malloc(seeds->run.memory, seeds->n, 3 * sizeof *out->normal);
    out->near = vor_malloc(seeds->run.memory, seeds->n, sizeof *out->near);
    if (out->normal == NULL || out->near == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    status = take_graph(out, seeds, run, err);
    VOR_THEN(status, vor_run_rows(run, seeds->n, VOR_SEEDS_BLOCK, find_row, &finding, err));
    return status;
}

vor_status vor_sheet_put(struct vor_sheet *sheet, struct vor_seeds *seeds,
                         const unsigned char *moved, const struct vor_recall *how,
                         struct vor_error *err)
{
    struct finding finding = {sheet, seeds, how, moved};

    return vor_run_rows(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, find_row, &finding, err);
}

void vor_sheet_free(struct vor_sheet *sheet)
{
    if (sheet->seeds == NULL)
        return;
    VOR_FREE_ALL(sheet->seeds->run.memory, sheet->root, sheet->crowded, sheet->near, sheet->normal);
    vor_graph_free(&sheet->own);
    memset(sheet, 0, sizeof *sheet);
}

/* Walks from the input point `from` to `to`, each step to the neighbour nearest to it. Returns
 * whether it gets there: on another sheet it ends at the place below. */
static int leads(const struct vor_sheet *sheet, uint32_t from, uint32_t to)
{
    const struct vor_graph *graph = sheet->graph;
    const float *xyz = sheet->seeds->domain->xyz, *x = &xyz[3 * (size_t)to];
    double best = vor_distance2f(&xyz[3 * (size_t)from], x);

    while (from != to) {
        const uint32_t *list = &graph->list[(size_t)from * graph->most];
        uint32_t next = from;

        for (unsigned j = 0; j < graph->count[from]; j++) {
            double d2 = vor_distance2f(&xyz[3 * (size_t)list[j]], x);

            if (list[j] == to || d2 < best) {
                best = d2;
                next = list[j];
            }
            if (next == to)
                return 1;
        }
        if (next == from)
            return 0;
        from = next;
    }
    return 1;
}

int vor_sheet_is_along(const struct vor_sheet *sheet, const uint32_t corner[3])
{
    double normal[3], length;
    int along = 0;

    vor_triangle_normal(normal, sheet->seeds->xyz, corner);
    length = sqrt(vor_dot(normal, normal));
    for (int c = 0; c < 3; c++) {
        const float *m = &sheet->normal[3 * (size_t)corner[c]];
        double up =
            fabs(normal[0] * (double)m[0] + normal[1] * (double)m[1] + normal[2] * (double)m[2]);

        along += up >= ALONG * length;
    }
    return along >= 2;
}

/* Whether a place is no farther than `most` from the input point nearest to a corner. */
static int is_near_input(const struct vor_sheet *sheet, const uint32_t corner[3], const float at[3],
                         double most)
{
    for (int c = 0; c < 3; c++) {
        double left = most - (double)sheet->near[corner[c]];

        if (left > 0 &&
            vor_distance2f(at, &sheet->seeds->xyz[3 * (size_t)corner[c]]) <= left * left)
            return 1;
    }
    return 0;
}

int vor_sheet_is_under(const struct vor_sheet *sheet, const uint32_t corner[3])
{
    const struct vor_domain *domain = sheet->seeds->domain;
    float at[4][3] = {{0}}, distance2;
    uint32_t index;
    double edge = 0, most;

    for (unsigned c = 0; c < 3; c++) {
        const float *a = &sheet->seeds->xyz[3 * (size_t)corner[c]];
        const float *b = &sheet->seeds->xyz[3 * (size_t)corner[(c + 1) % 3]];

        edge += sqrt(vor_distance2f(a, b)) / 3;
        for (int d = 0; d < 3; d++) {
            at[c][d] = (a[d] + b[d]) / 2;
            at[3][d] += a[d] / 3;
        }
    }
    most = fmax(VOR_OUTSIDE_IN_RESULT * domain->sparse, NEAR_EDGE * edge);
    for (int k = 3; k >= 0; k--) {
        if (is_near_input(sheet, corner, at[k], most))
            continue;
        vor_knn_search(domain->knn, at[k], 1, 1, &index, &distance2);
        if ((double)distance2 > most * most)
            return 0;
    }
    return 1;
}

/* Whether the surface of seed i passes seed j by. */
static int passes(const struct vor_sheet *sheet, uint32_t i, uint32_t j)
{
    const struct vor_surface *surface = &sheet->seeds->last_fit[i].surface;
    double x[3], up;

    if (surface->kind == VOR_SURFACE_NONE)
        return 1;
    vor_seeds_position(sheet->seeds, j, x);
    up = vor_surface_above(surface, x);
    return up * up >
           VOR_SHEET_PASSES * VOR_SHEET_PASSES *
               vor_distance2f(&sheet->seeds->xyz[3 * (size_t)i], &sheet->seeds->xyz[3 * (size_t)j]);
}

int vor_sheet_doubts(const struct vor_sheet *sheet, const uint32_t corner[3])
{
    const struct vor_last_fit *fit = sheet->seeds->last_fit;

    if (sheet->graph == NULL)
        return sheet->crowded != NULL && (sheet->crowded[corner[0]] || sheet->crowded[corner[1]] ||
                                          sheet->crowded[corner[2]]);
    if (!(fit[corner[0]].layered || fit[corner[1]].layered || fit[corner[2]].layered))
        return 0;
    for (int c = 0; c < 3; c++)
        if (passes(sheet, corner[c], corner[(c + 1) % 3]) ||
            passes(sheet, corner[(c + 1) % 3], corner[c]))
            return 1;
    return 0;
}

int vor_sheet_has(const struct vor_sheet *sheet, size_t i)
{
    const float *normal = &sheet->normal[3 * i];

    return normal[0] != 0 || normal[1] != 0 || normal[2] != 0;
}

int vor_sheet_is_beside(const struct vor_sheet *sheet, size_t i, size_t j)
{
    const float *a = &sheet->seeds->xyz[3 * i], *b = &sheet->seeds->xyz[3 * j];
    const float *m = &sheet->normal[3 * i], *n = &sheet->normal[3 * j];
    double up[2] = {0, 0}, cosine = 0, length = 0, turned;

    if (!vor_sheet_has(sheet, i) || !vor_sheet_has(sheet, j))
        return 0;
    for (int c = 0; c < 3; c++) {
        double d = (double)b[c] - (double)a[c];

        up[0] += d * (double)m[c];
        up[1] += d * (double)n[c];
        cosine += (double)m[c] * (double)n[c];
        length += d * d;
    }
    if (!(length > 0))
        return 0;
    for (int e = 0; e < 2; e++)
        up[e] = fmin(fabs(up[e]) / sqrt(length), 1);
    turned = sqrt((1 - up[0] * up[0]) * (1 - up[1] * up[1])) - up[0] * up[1];
    return fmin(up[0], up[1]) <= STEEP && fabs(cosine) - fabs(turned) <= STIFF;
}

int vor_sheet_joins(const struct vor_sheet *sheet, uint32_t i, uint32_t j)
{
    return vor_sheet_is_beside(sheet, i, j) && vor_sheet_leads(sheet, i, j);
}

int vor_sheet_leads(const struct vor_sheet *sheet, uint32_t i, uint32_t j)
{
    return sheet->root == NULL || leads(sheet, sheet->root[i], sheet->root[j]) ||
           leads(sheet, sheet->root[j], sheet->root[i]);
}
