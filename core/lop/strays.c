#include "core/lop/strays.h"

#include "core/base/stat.h"
#include "core/knn/knn.h"

#include <math.h>
#include <string.h>

/* The distance from each sample to its neighbour. */
static vor_status measure(float *far, const struct vor_lop_samples *samples, struct vor_error *err)
{
    size_t n = samples->n;
    unsigned k = n > VOR_LOP_STRAY_OF ? VOR_LOP_STRAY_OF + 1 : (unsigned)n;
    struct vor_knn *knn;
    vor_status status = vor_knn_build(&knn, samples->xyz, n, samples->memory, err);

    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < n; i++) {
        uint32_t index[VOR_LOP_STRAY_OF + 1];
        float distance2[VOR_LOP_STRAY_OF + 1];

        vor_knn_search(knn, &samples->xyz[3 * i], 1, k, index, distance2);
        far[i] = sqrtf(distance2[k - 1]);
    }
    vor_knn_free(knn);
    return VOR_OK;
}

/* Keeps the samples that are no farther than that. */
static void keep_near(struct vor_lop_samples *samples, const float *far, double most)
{
    size_t left = 0;

    for (size_t i = 0; i < samples->n; i++) {
        if ((double)far[i] > most)
            continue;
        memmove(&samples->xyz[3 * left], &samples->xyz[3 * i], 3 * sizeof *samples->xyz);
        memmove(&samples->normal[3 * left], &samples->normal[3 * i], 3 * sizeof *samples->normal);
        left++;
    }
    samples->n = left;
}

vor_status vor_lop_strays_drop(struct vor_lop_samples *samples, struct vor_error *err)
{
    size_t n = samples->n;
    float *far = vor_malloc(samples->memory, n, 2 * sizeof *far), *sorted;
    vor_status status;

    if (far == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    sorted = far + n;
    status = measure(far, samples, err);
    if (status == VOR_OK) {
        memcpy(sorted, far, n * sizeof *far);
        vor_sort_floats(sorted, n);
        keep_near(samples, far, M_SQRT2 * vor_quantile(sorted, n, 0.5));
    }
    vor_free(samples->memory, far);
    return status;
}
