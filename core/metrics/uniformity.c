#include "core/metrics/uniformity.h"

#include "core/base/linalg.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 256 }; /* points of one task */

void vor_uniformity_from(struct vor_uniformity *out, const float *nearest, size_t n)
{
    double sum = 0, square = 0, deviation = 0;

    memset(out, 0, sizeof *out);
    out->epsilon = 1;
    out->min = INFINITY;
    for (size_t i = 0; i < n; i++) {
        double d = (double)nearest[i];

        sum += d;
        out->min = fmin(out->min, d);
        out->max = fmax(out->max, d);
        out->coincident += d == 0;
    }
    if (!(sum > 0)) {
        out->min = 0;
        return;
    }
    out->mean = sum / (double)n;
    for (size_t i = 0; i < n; i++) {
        double d = (double)nearest[i] / out->mean - 1;

        square += d * d;
        deviation += fabs(d);
    }
    out->delta = sqrt(square / (double)n);
    out->sigma = deviation / (double)n * out->mean;
    out->epsilon = 1 / sqrt(1 + out->delta * out->delta);
}

struct search {
    float *out;
    const float *queries;
    const struct vor_knn *knn;
    unsigned k;
};

static void search_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct search *search = ctx;
    uint32_t index[VOR_KTH_MAX * BLOCK];
    float distance2[VOR_KTH_MAX * BLOCK];

    vor_knn_search(search->knn, &search->queries[3 * begin], end - begin, search->k, index,
                   distance2);
    for (size_t i = begin; i < end; i++)
        search->out[i] = sqrtf(distance2[(i - begin + 1) * search->k - 1]);
}

vor_status vor_kth_distances(float *out, const float *queries, size_t n, const struct vor_knn *knn,
                             unsigned k, const struct vor_run *run, struct vor_error *err)
{
    struct search search = {out, queries, knn, k};

    return vor_run_for(run, n, BLOCK, search_block, &search, err);
}

/* Goes along the index, so that those of one search are near each other. The nearest but one: each
 * point, or one it coincides with, comes first. */
static void nearest_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct search *search = ctx;
    const uint32_t *order = vor_knn_order(search->knn);
    uint32_t index[2 * VOR_KNN_NEAR_MAX], of[VOR_KNN_NEAR_MAX];
    float query[3 * VOR_KNN_NEAR_MAX], distance2[2 * VOR_KNN_NEAR_MAX];
    struct vor_knn_near near = {query, 0, 2, NULL, 0};

    for (size_t i = begin, count; i < end; i += count) {
        count = end - i < VOR_KNN_NEAR_MAX ? end - i : VOR_KNN_NEAR_MAX;
        for (size_t j = 0; j < count; j++)
            of[j] = order != NULL ? order[i + j] : (uint32_t)(i + j);
        vor_gather(query, search->queries, of, count);
        near.count = count;
        vor_knn_search_near(search->knn, &near, index, distance2);
        for (size_t j = 0; j < count; j++)
            search->out[of[j]] = sqrtf(distance2[2 * j + 1]);
    }
}

vor_status vor_nearest_distances(float *nearest, const float *xyz, size_t n,
                                 const struct vor_knn *knn, const struct vor_run *run,
                                 struct vor_error *err)
{
    struct search search = {nearest, xyz, knn, 2};

    if (n > 1)
        return vor_run_for(run, n, BLOCK, nearest_block, &search, err);
    nearest[0] = 0;
    return VOR_OK;
}

vor_status vor_uniformity_indexed(struct vor_uniformity *out, const float *xyz, size_t n,
                                  const struct vor_knn *knn, const struct vor_run *run,
                                  struct vor_error *err)
{
    float *nearest = vor_malloc(run->memory, n, sizeof *nearest);
    vor_status status;

    if (nearest == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_nearest_distances(nearest, xyz, n, knn, run, err);
    if (status == VOR_OK)
        vor_uniformity_from(out, nearest, n);
    vor_free(run->memory, nearest);
    return status;
}

vor_status vor_uniformity_measure(struct vor_uniformity *out, const float *xyz, size_t n,
                                  const struct vor_run *run, struct vor_error *err)
{
    struct vor_knn *knn = NULL;
    vor_status status = vor_knn_build_along(&knn, xyz, n, run, err);

    VOR_THEN(status, vor_uniformity_indexed(out, xyz, n, knn, run, err));
    vor_knn_free(knn);
    return status;
}
