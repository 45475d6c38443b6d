#include "core/align/points.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "core/base/stat.h"

#include <math.h>
#include <string.h>

enum {
    POINTS = 16000,
    /* Neighbours of a plane. At 8 / 12, 30 pairs of 250 points of a body, with wrong poses all
     * nearly as good: mean trust of tetrahedra 0.239 / 0.142, one in 30 over a half / none; of
     * cubes 0.079 / 0.024; of octahedra 0.048 / 0.029. */
    AROUND = 12,
    BLOCK = 256 /* points of a task */
};

/* About the angle of a vector in a plane, in quarters of a turn: exact at whole ones. */
static double quarters(double x, double y)
{
    double sum = fabs(x) + fabs(y), part = sum > 0 ? x / sum : 0;

    return y >= 0 ? 1 - part : 3 + part;
}

/* The widest angle in the plane of two axes that no neighbour is in, in quarters of a turn. */
static double widest(const double d[AROUND][3], const double axes[3][3])
{
    double angle[AROUND], most;

    for (unsigned k = 0; k < AROUND; k++)
        angle[k] = quarters(vor_dot(d[k], axes[1]), vor_dot(d[k], axes[2]));
    vor_sort_doubles(angle, AROUND);
    most = 4 + angle[0] - angle[AROUND - 1];
    for (unsigned k = 1; k < AROUND; k++)
        most = fmax(most, angle[k] - angle[k - 1]);
    return most;
}

static void lay_plane(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct vor_align_points *points = ctx;
    struct vor_align_plane *plane = &points->plane[i];
    const float *x = &points->xyz[3 * i];
    double d[AROUND][3], mean[3] = {0, 0, 0}, square[6] = {0}, values[3], axes[3][3];
    uint32_t at[AROUND + 1];
    float d2[AROUND + 1];
    unsigned n = 0;

    vor_knn_search(points->knn, x, 1, AROUND + 1, at, d2);
    for (unsigned k = 0; k <= AROUND && n < AROUND; k++) {
        if (at[k] == i)
            continue;
        plane->reach = sqrtf(d2[k]);
        for (int c = 0; c < 3; c++) {
            d[n][c] = (double)points->xyz[3 * (size_t)at[k] + (size_t)c] - (double)x[c];
            mean[c] += d[n][c] / AROUND;
        }
        n++;
    }
    for (unsigned k = 0; k < AROUND; k++)
        for (int r = 0, s = 0; r < 3; r++)
            for (int c = r; c < 3; c++)
                square[s++] += (d[k][r] - mean[r]) * (d[k][c] - mean[c]) / (AROUND - 3);
    vor_eigen3(values, axes, square);
    plane->rough = (float)sqrt(fmax(values[0], 0));
    plane->off = (float)fabs(vor_dot(mean, axes[0]));
    /* a third of a turn without neighbours */
    plane->border = widest((const double(*)[3])d, (const double(*)[3])axes) > 4.0 / 3;
    for (int c = 0; c < 3; c++) {
        plane->middle[c] = (float)((double)x[c] + mean[c]);
        plane->normal[c] = (float)axes[0][c];
    }
}

/* Takes one point at random of each stretch of the cloud. */
static void take(struct vor_align_points *points, const struct vor_cloud *cloud,
                 const struct vor_align_samples *samples)
{
    for (size_t i = 0; i < points->n; i++) {
        size_t begin = i * cloud->n / points->n, end = (i + 1) * cloud->n / points->n;
        double x[3];

        vor_cloud_position(cloud, begin + vor_rng_below(1, 2, i, end - begin), x);
        for (int c = 0; c < 3; c++)
            points->xyz[3 * i + (size_t)c] = (float)((x[c] - samples->middle[c]) / samples->unit);
    }
}

static vor_status set_medians(struct vor_align_points *points, struct vor_error *err)
{
    float *values = vor_malloc(points->memory, points->n, sizeof *values);

    if (values == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", points->n);
    for (size_t i = 0; i < points->n; i++)
        values[i] = points->plane[i].reach;
    vor_sort_floats(values, points->n);
    points->reach = vor_quantile(values, points->n, 0.5);
    for (size_t i = 0; i < points->n; i++)
        values[i] = points->plane[i].rough;
    vor_sort_floats(values, points->n);
    points->rough = vor_quantile(values, points->n, 0.5);
    vor_free(points->memory, values);
    return VOR_OK;
}

vor_status vor_align_points_make(struct vor_align_points *out, const struct vor_cloud *cloud,
                                 const struct vor_align_samples *samples, const struct vor_run *run,
                                 struct vor_error *err)
{
    vor_status status;

    memset(out, 0, sizeof *out);
    out->memory = run->memory;
    out->n = cloud->n < POINTS ? cloud->n : POINTS;
    out->xyz = vor_malloc(out->memory, out->n, 3 * sizeof *out->xyz);
    out->plane = vor_malloc(out->memory, out->n, sizeof *out->plane);
    if (out->xyz == NULL || out->plane == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", out->n);
    take(out, cloud, samples);
    status = vor_knn_build_along(&out->knn, out->xyz, out->n, run, err);
    if (status == VOR_OK)
        status = vor_run_rows(run, out->n, BLOCK, lay_plane, out, err);
    return status == VOR_OK ? set_medians(out, err) : status;
}

void vor_align_points_free(struct vor_align_points *points)
{
    vor_knn_free(points->knn);
    VOR_FREE_ALL(points->memory, points->xyz, points->plane);
    memset(points, 0, sizeof *points);
}
