#include "core/metrics/mls_error.h"

#include "core/base/bounds.h"
#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/base/vector.h"
#include "core/geom/plane.h"
#include "core/knn/knn.h"

#include <string.h>

enum {
    BLOCK = 1024, /* points of one task */
    NEAREST = 12, /* points of the result that an input point is moved on */
    PLANE = 20,   /* points of a plane */
    STEPS = 10,
    TERMS = 8,   /* of the exponential series */
    HALVINGS = 8 /* of its argument */
};

/* A step of less than this share of h is the last. */
#define STILL 1e-9
/* exp(-x) beyond it counts as 0. */
#define NOTHING 40.0

struct measure {
    const struct vor_mls_error_of *of;
    size_t points;         /* of the input that are measured */
    float *normal;         /* n x 3 */
    double h2;             /* squared, the largest distance to the twelfth neighbour */
    struct vor_sums *sums; /* blocks: first only the largest h2 of each */
};

/* exp(-x), each x >= 0, to 1e-9 and to the same bits everywhere, unlike that of libm. */
VOR_CLONES static void falloff(double x[NEAREST])
{
    double y[NEAREST], power[NEAREST];

    for (int j = 0; j < NEAREST; j++) {
        y[j] = x[j] / (1 << HALVINGS);
        power[j] = 1;
    }
    for (int i = TERMS; i > 0; i--)
        for (int j = 0; j < NEAREST; j++)
            power[j] = 1 - y[j] / i * power[j];
    for (int i = 0; i < HALVINGS; i++)
        for (int j = 0; j < NEAREST; j++)
            power[j] *= power[j];
    for (int j = 0; j < NEAREST; j++)
        x[j] = x[j] > NOTHING ? 0 : power[j];
}

static void normal_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct measure *measure = ctx;
    const struct vor_mls_error_of *of = measure->of;
    unsigned k = of->n < PLANE ? (unsigned)of->n : PLANE;
    const uint32_t *order = vor_knn_order(of->knn);
    uint32_t index[PLANE * VOR_KNN_NEAR_MAX];
    float query[3 * VOR_KNN_NEAR_MAX], distance2[PLANE * VOR_KNN_NEAR_MAX];
    struct vor_knn_near near = {query, 0, k, NULL, 0};
    double far2 = 0;

    for (size_t i = begin; i < end; i += near.count) {
        near.count = end - i < VOR_KNN_NEAR_MAX ? end - i : VOR_KNN_NEAR_MAX;
        for (size_t j = 0; j < near.count; j++)
            memcpy(&query[3 * j], &of->xyz[3 * (size_t)order[i + j]], 3 * sizeof *query);
        vor_knn_search_near(of->knn, &near, index, distance2);
        for (size_t j = 0; j < near.count; j++) {
            struct vor_plane plane;

            vor_plane_fit(&plane, of->xyz, &index[j * k], k);
            memcpy(&measure->normal[3 * (size_t)order[i + j]], plane.normal, sizeof plane.normal);
            far2 = fmax(far2, (double)distance2[j * k + NEAREST]); /* itself is the first */
        }
    }
    measure->sums[begin / BLOCK].max = far2;
}

/* One step of Eq. 1: moves x, and returns how far, squared. */
static double step(double x[3], double near[NEAREST][3], double normal[NEAREST][3], double h2)
{
    double d2[NEAREST], weight[NEAREST], least = INFINITY, total = 0, a[3] = {0}, n[3] = {0}, off;

    for (int j = 0; j < NEAREST; j++) {
        d2[j] = vor_distance2(x, near[j]);
        least = d2[j] < least ? d2[j] : least; /* fmin is a call */
    }
    for (int j = 0; j < NEAREST; j++)
        weight[j] = h2 > 0 ? (d2[j] - least) / h2 : 0;
    falloff(weight);
    for (int j = 0; j < NEAREST; j++) {
        total += weight[j];
        for (int c = 0; c < 3; c++) {
            a[c] += weight[j] * near[j][c];
            n[c] += weight[j] * normal[j][c];
        }
    }
    for (int c = 0; c < 3; c++) {
        a[c] = x[c] - a[c] / total;
        n[c] /= total;
    }
    off = vor_dot(n, a);
    for (int c = 0; c < 3; c++)
        x[c] -= off * n[c];
    return off * off * vor_dot(n, n);
}

/* How far point p of the input moves on the points of the result nearest to it. */
static double error_at(const struct measure *measure, const float p[3], const uint32_t *index)
{
    double x[3], from[3], near[NEAREST][3], normal[NEAREST][3];

    for (int j = 0; j < NEAREST; j++) {
        vor_to_doubles(near[j], &measure->of->xyz[3 * (size_t)index[j]]);
        vor_to_doubles(normal[j], &measure->normal[3 * (size_t)index[j]]);
        if (vor_dot(normal[j], normal[0]) < 0)
            for (int c = 0; c < 3; c++)
                normal[j][c] = -normal[j][c];
    }
    vor_to_doubles(x, p);
    vor_to_doubles(from, p);
    for (int s = 0; s < STEPS && step(x, near, normal, measure->h2) > STILL * STILL * measure->h2;)
        s++;
    return sqrt(vor_distance2(x, from));
}

static void error_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct measure *measure = ctx;
    const struct vor_mls_error_of *of = measure->of;
    struct vor_sums sums = {0};
    uint32_t index[NEAREST * VOR_KNN_NEAR_MAX];
    float query[3 * VOR_KNN_NEAR_MAX], distance2[NEAREST * VOR_KNN_NEAR_MAX];
    struct vor_knn_near near = {query, 0, NEAREST, NULL, 0};

    for (size_t i = begin; i < end; i += near.count) {
        near.count = end - i < VOR_KNN_NEAR_MAX ? end - i : VOR_KNN_NEAR_MAX;
        for (size_t j = 0; j < near.count; j++)
            memcpy(&query[3 * j],
                   &of->input[3 * (size_t)((uint64_t)(i + j) * of->m / measure->points)],
                   3 * sizeof *query);
        vor_knn_search_near(of->knn, &near, index, distance2);
        for (size_t j = 0; j < near.count; j++) {
            double error = error_at(measure, &query[3 * j], &index[j * NEAREST]);

            vor_sums_add(&sums, error, error * error);
        }
    }
    measure->sums[begin / BLOCK] = sums;
}

static vor_status run_blocks(struct vor_sums *all, struct measure *measure,
                             const struct vor_run *run, struct vor_error *err)
{
    size_t n = measure->of->n;
    vor_status status = vor_run_for(run, n, BLOCK, normal_block, measure, err);

    for (size_t b = 0; status == VOR_OK && b < vor_blocks_of(n, BLOCK); b++)
        measure->h2 = fmax(measure->h2, measure->sums[b].max);
    VOR_THEN(status, vor_run_for(run, measure->points, BLOCK, error_block, measure, err));
    for (size_t b = 0; status == VOR_OK && b < vor_blocks_of(measure->points, BLOCK); b++)
        vor_sums_merge(all, &measure->sums[b]);
    return status;
}

vor_status vor_mls_error_measure(struct vor_mls_error *out, const struct vor_mls_error_of *of,
                                 const struct vor_run *run, struct vor_error *err)
{
    struct measure measure = {.of = of, .points = of->m < of->most ? of->m : of->most};
    struct vor_memory *memory = run->memory;
    struct vor_sums all = {0};
    struct vor_box box;
    vor_status status;

    status = VOR_MAKE_ALL(
        memory, err, of->n, VOR_ARRAY(measure.normal, of->n, 3),
        VOR_ARRAY(measure.sums,
                  vor_blocks_of(of->n > measure.points ? of->n : measure.points, BLOCK), 1));
    VOR_THEN(status, run_blocks(&all, &measure, run, err));
    VOR_THEN(status, vor_bounds(&box, of->input, of->m, run, err));
    if (status == VOR_OK) {
        struct vor_stat stat = vor_sums_stat(&all, measure.points);
        double half = 0;

        for (int c = 0; c < 3; c++)
            half = fmax(half, (double)(box.high[c] - box.low[c]) / 2);
        *out =
            (struct vor_mls_error){half > 0 ? stat.max / half : 0, half > 0 ? stat.mean / half : 0};
    }
    VOR_FREE_ALL(memory, measure.sums, measure.normal);
    return status;
}
