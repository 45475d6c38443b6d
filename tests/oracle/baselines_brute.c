/* Oracle: farthest points that look at every point, and a voxel grid that sorts the points by
 * cell. */
#include "core/baselines/farthest.h"
#include "core/baselines/voxels.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 4, N = 1500 };

static const size_t counts[] = {1, 2, 37, 400, N};

enum { COUNTS = sizeof counts / sizeof counts[0] };

/* The point that is farthest from those in `out`; the first of several. */
static size_t farthest(const float *xyz, const float *out, size_t chosen)
{
    double most = -1;
    size_t which = 0;

    for (size_t i = 0; i < N; i++) {
        double least = INFINITY;

        for (size_t k = 0; k < chosen; k++) {
            double sum = 0;

            for (size_t c = 0; c < 3; c++) {
                double d = (double)xyz[3 * i + c] - (double)out[3 * k + c];

                sum += d * d;
            }
            least = fmin(least, (double)(float)sum);
        }
        if (least > most) {
            most = least;
            which = i;
        }
    }
    return which;
}

VT_TEST_LOOP(each_point_is_the_farthest_from_those_before, SEEDS)
{
    struct vt_engine engine;
    struct vor_cloud cloud;

    vt_engine_open(&engine, 2);
    _i % 2 == 0 ? vt_cloud_sphere(&cloud, (uint64_t)_i, N) : vt_cloud_cube(&cloud, (uint64_t)_i, N);
    for (size_t at = 0; at < COUNTS; at++) {
        float *out = malloc(3 * N * sizeof *out);
        size_t count = counts[at], first = (size_t)_i * 100;

        vt_assert_ok(vor_farthest_points(out, cloud.xyz, N, count, first, &engine.run, &vt_err));
        ck_assert(memcmp(out, &cloud.xyz[3 * first], 3 * sizeof *out) == 0);
        for (size_t k = 1; k < count && k < 60; k++) {
            size_t which = farthest(cloud.xyz, out, k);

            ck_assert(memcmp(&out[3 * k], &cloud.xyz[3 * which], 3 * sizeof *out) == 0);
        }
        free(out);
    }
    vor_cloud_free(&cloud);
    vt_engine_close(&engine);
}

static int by_coordinates(const void *a, const void *b)
{
    const float *x = a, *y = b;

    for (int c = 0; c < 3; c++)
        if (x[c] < y[c] || x[c] > y[c])
            return x[c] < y[c] ? -1 : 1;
    return 0;
}

/* A point and the cell that it lies in. */
struct celled {
    long cell[3];
    size_t index;
};

static int by_cell(const void *a, const void *b)
{
    const struct celled *x = a, *y = b;

    for (int c = 0; c < 3; c++)
        if (x->cell[c] != y->cell[c])
            return x->cell[c] < y->cell[c] ? -1 : 1;
    return x->index < y->index ? -1 : 1;
}

/* Makes the means of the cells of that edge; returns how many. */
static size_t means(float *out, const float *xyz, double edge)
{
    struct celled *point = malloc(N * sizeof *point);
    size_t made = 0, count = 0;
    double sum[3] = {0};

    for (size_t i = 0; i < N; i++) {
        for (size_t c = 0; c < 3; c++)
            point[i].cell[c] = (long)(((double)xyz[3 * i + c] + 1) * (1 / edge));
        point[i].index = i;
    }
    qsort(point, N, sizeof *point, by_cell);
    for (size_t i = 0; i < N; i++) {
        for (size_t c = 0; c < 3; c++)
            sum[c] += (double)xyz[3 * point[i].index + c];
        count++;
        if (i + 1 < N && memcmp(point[i].cell, point[i + 1].cell, sizeof point[i].cell) == 0)
            continue;
        for (size_t c = 0; c < 3; c++)
            out[3 * made + c] = (float)(sum[c] / (double)count);
        memset(sum, 0, sizeof sum);
        made++;
        count = 0;
    }
    free(point);
    return made;
}

/* The grid that makes the number nearest to `wanted` of those tried by halving. */
static size_t brute(float *out, const float *xyz, size_t wanted)
{
    double least = 0x1p-19, most = 2, best = 2;
    size_t nearest = SIZE_MAX;

    for (int grid = 0; grid < 32; grid++) {
        double edge = grid == 0 ? 2 : sqrt(least * most);
        size_t made = means(out, xyz, edge);
        size_t off = made > wanted ? made - wanted : wanted - made;

        if (off < nearest && made <= 2 * wanted + VOR_VOXELS_SLACK) {
            nearest = off;
            best = edge;
        }
        *(made > wanted ? &least : &most) = edge;
    }
    return means(out, xyz, best);
}

VT_TEST_LOOP(a_voxel_grid_has_the_means_of_its_cells, SEEDS)
{
    struct vt_engine engine;
    struct vor_cloud cloud;
    float *out = malloc(3 * N * sizeof *out), *other = malloc(3 * N * sizeof *other);

    vt_engine_open(&engine, 1 + (unsigned)_i);
    _i % 2 == 0 ? vt_cloud_sphere(&cloud, (uint64_t)_i, N) : vt_cloud_cube(&cloud, (uint64_t)_i, N);
    for (size_t at = 0; at < COUNTS; at++) {
        size_t made = 0, same = brute(other, cloud.xyz, counts[at]);

        vt_assert_ok(vor_voxel_points(out, &made, cloud.xyz, N, counts[at], &engine.run, &vt_err));
        ck_assert_uint_eq(made, same);
        ck_assert_uint_ge(made, 1);
        if (counts[at] >= 37) /* a sphere has at least eight cells */
            ck_assert_double_le(fabs((double)made - (double)counts[at]), 0.03 * (double)counts[at]);
        qsort(out, made, 3 * sizeof *out, by_coordinates);
        qsort(other, made, 3 * sizeof *out, by_coordinates);
        for (size_t i = 0; i < 3 * made; i++)
            ck_assert_double_eq_tol((double)out[i], (double)other[i], 1e-6);
    }
    free(other);
    free(out);
    vor_cloud_free(&cloud);
    vt_engine_close(&engine);
}
