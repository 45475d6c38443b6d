#include "core/metrics/cells.h"

#include "core/base/linalg.h"
#include "core/geom/flat.h"
#include "core/geom/metric.h"
#include "core/geom/patch.h"
#include "core/knn/knn.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 256, CORNERS = 7 };

/* Neighbours that the tangent plane is fitted to: two rings of a lattice are 18. */
enum { PLANE = 12 };

/* Spacings from the nearest point beyond which a place is wide: between the 0.577 of a hexagonal
 * lattice and the 0.658 of squares. */
#define WIDE 0.64

/* A cell. Of more corners the first are kept, and the farthest. */
struct record {
    double area, moment;
    float corner2[CORNERS]; /* squared distances to the point, the farthest first */
    unsigned sides;         /* 0: the cell is open */
};

struct cells {
    struct record *record;
    vor_cells_near near;
    void *ctx;
    const struct vor_run *run;
};

/* The axes of the plane that the nearest of k offsets lie in. */
static void find_plane(double axis[2][3], const float *offset, unsigned k)
{
    double mean[3] = {0}, m[6] = {0}, values[3], vectors[3][3];
    unsigned most = k < PLANE ? k : PLANE;

    for (unsigned j = 0; j < 3 * most; j++) /* the point itself counts as one */
        mean[j % 3] += (double)offset[j] / (most + 1);
    for (unsigned j = 0; j <= most; j++) {
        double d[3];

        for (int c = 0; c < 3; c++)
            d[c] = (j < most ? (double)offset[3 * j + (unsigned)c] : 0) - mean[c];
        vor_add_square(m, d);
    }
    vor_eigen3_flat(values, vectors, m);
    memcpy(axis, vectors[1], 2 * sizeof axis[0]);
}

/* Makes lengths in the plane of the axes those in the metric: by its Cholesky factor there. */
static void stretch(double axis[2][3], const double metric[6])
{
    double plane[3], x, y, across;

    vor_metric_restrict(plane, metric, axis);
    x = sqrt(plane[0]);
    across = plane[1] / x;
    y = sqrt(fmax(plane[2] - across * across, 0));
    for (int c = 0; c < 3; c++) {
        axis[0][c] = x * axis[0][c] + across * axis[1][c];
        axis[1][c] *= y;
    }
}

/* Cuts the cell, and sees whether it closes. No point beyond the last of the neighbours can cut
 * what lies within half its distance. */
static int cut(struct vor_flat *cell, const float *offset, unsigned k, const double metric[6])
{
    double axis[2][3], d[3], length2;

    find_plane(axis, offset, k);
    stretch(axis, metric);
    vor_to_doubles(d, &offset[3 * (size_t)(k - 1)]);
    vor_flat_begin(cell, vor_patch_octagon, VOR_PATCH_OCTAGON,
                   sqrt(vor_metric_length2(metric, d)) / 2);
    for (unsigned j = 0; j < k; j++) {
        vor_to_doubles(d, &offset[3 * (size_t)j]);
        length2 = vor_metric_length2(metric, d);
        if (length2 < 4 * cell->far2)
            vor_flat_clip(cell, (double[2]){vor_dot(axis[0], d), vor_dot(axis[1], d)}, length2 / 2,
                          j);
    }
    for (unsigned e = 0; e < cell->count; e++)
        if (cell->id[e] >= VOR_FLAT_SIDE)
            return 0;
    return cell->count > 2;
}

static void fill_record(struct record *out, const struct vor_flat *cell)
{
    double area = 0, moment = 0, least2;
    unsigned farthest = 0;

    for (unsigned e = 0; e < cell->count; e++) {
        unsigned f = e + 1 < cell->count ? e + 1 : 0;
        double x = cell->x[e], y = cell->y[e], u = cell->x[f], v = cell->y[f],
               cross = x * v - y * u;

        area += cross / 2;
        moment += cross * (x * x + y * y + x * u + y * v + u * u + v * v) / 12;
        if (e < CORNERS)
            out->corner2[e] = (float)(x * x + y * y);
        if (x * x + y * y >= cell->far2)
            farthest = e;
    }
    least2 = 1e-6 * area; /* shorter sides are those of four points on a circle */
    for (unsigned e = 0; e < cell->count; e++) {
        unsigned f = e + 1 < cell->count ? e + 1 : 0;
        double u = cell->x[f] - cell->x[e], v = cell->y[f] - cell->y[e];

        out->sides += u * u + v * v > least2;
    }
    out->area = area;
    out->moment = moment;
    if (farthest < CORNERS)
        out->corner2[farthest] = out->corner2[0];
    out->corner2[0] = (float)cell->far2;
}

static void cell_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct cells *cells = ctx;
    struct vor_flat cell;

    for (size_t i = begin; i < end && !vor_run_is_late(cells->run); i++) {
        float offset[3 * VOR_CELLS_NEAR];
        double metric[6] = {1, 0, 0, 1, 0, 1};
        unsigned k = cells->near(cells->ctx, i, worker, offset, metric);

        if (k > 2 && cut(&cell, offset, k, metric))
            fill_record(&cells->record[i], &cell);
    }
}

static void sum_up(struct vor_cells *out, const struct record *record, size_t n)
{
    double area = 0, moment = 0, far2 = 0, mean, spacing2;
    size_t closed = 0, six = 0, corners = 0;

    *out = (struct vor_cells){.open = n};
    for (size_t i = 0; i < n; i++) {
        if (record[i].sides == 0)
            continue;
        closed++;
        six += record[i].sides == 6;
        area += record[i].area;
        moment += record[i].moment;
        far2 = fmax(far2, (double)record[i].corner2[0]);
    }
    if (closed == 0 || !(area > 0))
        return;
    mean = area / (double)closed;
    spacing2 = 2 / sqrt(3) * mean;
    for (size_t i = 0; i < n; i++)
        for (unsigned c = 0; c < CORNERS && record[i].sides > 0; c++)
            corners += (double)record[i].corner2[c] > WIDE * WIDE * spacing2;
    out->eta = moment / ((double)closed * 5 / (18 * sqrt(3)) * mean * mean) - 1;
    out->six = (double)six / (double)closed;
    out->gap = sqrt(far2 / spacing2);
    out->wide = (corners + 1) / 3;
    out->open = n - closed;
}

vor_status vor_cells_of(struct vor_cells *out, size_t n, vor_cells_near near, void *ctx,
                        const struct vor_run *run, struct vor_error *err)
{
    struct cells cells = {vor_calloc(run->memory, n, sizeof *cells.record), near, ctx, run};
    vor_status status;

    if (cells.record == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_run_for(run, n, BLOCK, cell_block, &cells, err);
    if (status == VOR_OK)
        sum_up(out, cells.record, n);
    vor_free(run->memory, cells.record);
    return status;
}

struct cloud {
    const float *xyz;
    const struct vor_knn *knn;
    size_t n;
};

static unsigned near_in_cloud(void *ctx, size_t i, VOR_UNUSED unsigned worker, float *offset,
                              VOR_UNUSED double metric[6])
{
    const struct cloud *cloud = ctx;
    const float *x = &cloud->xyz[3 * i];
    uint32_t index[VOR_CELLS_NEAR + 1];
    float distance2[VOR_CELLS_NEAR + 1];
    unsigned most = cloud->n <= VOR_CELLS_NEAR ? (unsigned)cloud->n : VOR_CELLS_NEAR + 1, k = 0;

    vor_knn_search(cloud->knn, x, 1, most, index, distance2);
    for (unsigned j = 0; j < most && k < VOR_CELLS_NEAR; j++)
        if (index[j] != i) {
            for (size_t c = 0; c < 3; c++)
                offset[3 * k + c] = cloud->xyz[3 * (size_t)index[j] + c] - x[c];
            k++;
        }
    return k;
}

vor_status vor_cells_measure(struct vor_cells *out, const float *xyz, size_t n,
                             const struct vor_knn *knn, const struct vor_run *run,
                             struct vor_error *err)
{
    struct cloud cloud = {xyz, knn, n};

    return vor_cells_of(out, n, near_in_cloud, &cloud, run, err);
}
