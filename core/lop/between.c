#include "core/lop/between.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "core/geom/plane.h"
#include "core/knn/knn.h"
#include "core/lop/tree.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    /* Points of one task. */
    BLOCK = 256,
    /* Stream of random numbers. */
    STREAM_FAR = 3
};

struct between {
    struct vor_lop_samples *samples;
    struct vor_knn *knn;
    size_t begun, more; /* points that there were, that are added */
    uint64_t seed;
};

/* The points that others are put towards. */
struct towards {
    uint32_t index[VOR_PLANE_POINTS];
    unsigned count;
};

/* Finds the neighbours of point i that lie on its surface, or, if none does, all of them. */
static void look_around(struct towards *out, const struct between *between, size_t i)
{
    const float *normal = between->samples->normal;
    unsigned k = between->begun < VOR_PLANE_POINTS ? (unsigned)between->begun : VOR_PLANE_POINTS;
    uint32_t index[VOR_PLANE_POINTS];
    float distance2[VOR_PLANE_POINTS];

    vor_knn_search(between->knn, &between->samples->xyz[3 * i], 1, k, index, distance2);
    out->count = 0;
    for (int all = 0; all < 2 && out->count == 0; all++)
        for (unsigned j = 0; j < k; j++) {
            double cosine = vor_dotf(&normal[3 * i], &normal[3 * (size_t)index[j]]);

            if (index[j] != i && (all || (distance2[j] > 0 && cosine >= -VOR_SAME_WAY)))
                out->index[out->count++] = index[j];
        }
    assert(out->count > 0); /* there are two points */
}

/* Puts an added point part of the way from point i to one of its neighbours, or beside an edge half
 * as far, on the plane of i. */
static void put_row(void *ctx, size_t added, VOR_UNUSED unsigned worker)
{
    const struct between *between = ctx;
    const float *xyz = between->samples->xyz, *normal = between->samples->normal;
    size_t at = 3 * (between->begun + added), j;
    size_t i = (size_t)((double)added / (double)between->more * (double)between->begun);
    double t = vor_rng_unit(between->seed, STREAM_FAR, added) / 2;
    double n[3], m[3], there[3], down, up = 0, length = 1;
    struct towards towards;

    look_around(&towards, between, i);
    j = towards.index[added % towards.count];
    vor_to_doubles(n, &normal[3 * i]);
    vor_to_doubles(m, &normal[3 * j]);
    vor_way(there, &xyz[3 * i], &xyz[3 * j]);
    if (vor_dot(n, m) > 0) {
        down = t * (1 - t) / 2 * vor_dot(there, n);
        up = t * (1 - t) / 2 * vor_dot(there, m);
        length = sqrt(1 - 2 * t * (1 - t) * (1 - vor_dot(n, m)));
    } else {
        t /= 2;
        down = t * vor_dot(there, n);
        memcpy(m, n, sizeof m);
    }
    for (size_t c = 0; c < 3; c++) {
        double x = (double)xyz[3 * i + c] + t * there[c] - down * n[c] + up * m[c];

        between->samples->xyz[at + c] = (float)x;
        between->samples->normal[at + c] = (float)(((1 - t) * n[c] + t * m[c]) / length);
    }
}

vor_status vor_lop_between(struct vor_lop_samples *samples, size_t n, uint64_t seed,
                           const struct vor_run *run, struct vor_error *err)
{
    struct between between = {.samples = samples, .begun = samples->n, .seed = seed};
    vor_status status;

    if (n <= samples->n)
        return VOR_OK;
    between.more = n - samples->n;
    status = vor_knn_build(&between.knn, samples->xyz, samples->n, samples->memory, err);
    VOR_THEN(status, vor_run_rows(run, between.more, BLOCK, put_row, &between, err));
    vor_knn_free(between.knn);
    if (status == VOR_OK)
        samples->n = n;
    return status;
}
