#include "core/mesh/exact.h"

#include "core/base/linalg.h"
#include "core/geom/through.h"
#include "core/input/adjacency.h"

#include <string.h>

/* A surface goes through VOR_ADJACENT_FEWEST to VOR_THROUGH_MOST points. Of 39,970 triangles of
 * shell60k made from lists without a wrong entry, with corners nearest to two sheets: none moved
 * 310, through 10 / 14 points 101 / 73. */

/* What workers share. */
struct putting {
    const struct vor_sheet *sheet;
    struct vor_seeds *seeds;
};

/* The input points of a sheet nearest to a place, nearest first. */
struct around {
    unsigned count;
    double distance2[VOR_THROUGH_MOST];
    const float *point[VOR_THROUGH_MOST];
};

static void insert(struct around *around, const float *point, const float *x)
{
    double d2 = vor_distance2f(point, x);
    unsigned k = around->count;

    if (k == VOR_THROUGH_MOST && around->distance2[--k] <= d2)
        return;
    around->count = k + 1;
    for (; k > 0 && around->distance2[k - 1] > d2; k--) {
        around->distance2[k] = around->distance2[k - 1];
        around->point[k] = around->point[k - 1];
    }
    around->distance2[k] = d2;
    around->point[k] = point;
}

/* Gathers those of the sheet of seed i. */
static void gather(struct around *out, const struct vor_sheet *sheet, size_t i)
{
    const struct vor_graph *graph = sheet->graph;
    const float *xyz = sheet->seeds->domain->xyz, *x = &sheet->seeds->xyz[3 * i];
    size_t root = sheet->root[i];

    memset(out, 0, sizeof *out);
    insert(out, &xyz[3 * root], x);
    for (unsigned e = 0; e < graph->count[root]; e++)
        insert(out, &xyz[3 * (size_t)graph->list[root * graph->most + e]], x);
}

/* Moves x, along the normal of a plane through the points, onto the surface through them. */
static int put(const struct around *around, double x[3])
{
    float near[3 * VOR_THROUGH_MOST];
    double at[3], height, u, v;
    struct vor_surface frame;

    for (unsigned k = 0; k < around->count; k++)
        memcpy(&near[3 * k], around->point[k], 3 * sizeof *near);
    if (!vor_through_fit(&frame, at, &height, near, around->count, x))
        return 0;
    u = at[0] - frame.center[0];
    v = at[1] - frame.center[1];
    if (u * u + v * v > frame.reach * frame.reach)
        return 0;
    if (!(fabs(height - at[2]) < frame.spacing))
        return 0;
    at[2] = height;
    vor_surface_to_world(&frame, at, x);
    return 1;
}

static void put_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct putting *putting = ctx;
    struct vor_seeds *seeds = putting->seeds;
    struct around around;
    double x[3];

    if (!seeds->last_fit[i].layered)
        return;
    gather(&around, putting->sheet, i);
    vor_seeds_position(seeds, i, x);
    if (around.count < VOR_ADJACENT_FEWEST || !put(&around, x))
        return;
    vor_to_floats(&seeds->xyz[3 * i], x);
}

vor_status vor_exact_put(const struct vor_sheet *sheet, struct vor_seeds *seeds, size_t fixed,
                         struct vor_error *err)
{
    struct putting putting = {sheet, seeds};

    if (sheet->graph == NULL || sheet->root == NULL)
        return VOR_OK;
    return vor_run_rows(&seeds->run, seeds->n - fixed, VOR_SEEDS_BLOCK, put_row, &putting, err);
}
