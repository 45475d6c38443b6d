/* FLANN's single kd-tree (Muja, Lowe 2009): exact, and the same answers every time. The other
 * indexes seed themselves from the machine. What crashes or misleads it is kept out here: no
 * points, more neighbours than points, coordinates that are not finite or overflow when squared. */
#include "core/knn/knn.h"

#include <assert.h>
#include <flann/flann.h>
#include <math.h>

#define COORDINATE_MAX 1e6f
#define BYTES_PER_POINT 44 /* measured at leaves of 16: 37, plus the allocator's own */

struct vor_knn {
    flann_index_t index;
    struct FLANNParameters parameters; /* read only once built */
    size_t n, charged;
    struct vor_memory *memory;
};

static void set_parameters(struct FLANNParameters *parameters)
{
    *parameters = DEFAULT_FLANN_PARAMETERS;
    parameters->algorithm = FLANN_INDEX_KDTREE_SINGLE;
    parameters->checks = FLANN_CHECKS_UNLIMITED;
    parameters->sorted = 1;
    parameters->cores = 1; /* 0 would start an OpenMP team inside every call */
    parameters->leaf_max_size = 16;
    parameters->random_seed = 0;
    parameters->log_level = FLANN_LOG_NONE;
}

/* The library's interface lacks const; it does not write. */
static float *unconst(const float *p)
{
    union {
        const float *in;
        float *out;
    } cast = {.in = p};

    return cast.out;
}

vor_status vor_knn_build(struct vor_knn **out, const float *xyz, size_t n,
                         struct vor_memory *memory, struct vor_error *err)
{
    struct vor_knn *knn;
    float speedup;

    if (n == 0 || n > INT32_MAX)
        return vor_fail(err, VOR_E_EMPTY, "an index of %zu points, want 1 to %d", n, INT32_MAX);
    for (size_t i = 0; i < 3 * n; i++)
        if (!(fabsf(xyz[i]) <= COORDINATE_MAX))
            return vor_fail(err, VOR_E_NONFINITE, "coordinate %c of point %zu is %g", "xyz"[i % 3],
                            i / 3, (double)xyz[i]);
    knn = vor_calloc(memory, 1, sizeof *knn);
    if (knn == NULL || !vor_memory_charge(memory, n * BYTES_PER_POINT)) {
        vor_free(memory, knn);
        return vor_fail(err, VOR_E_NOMEM, "an index of %zu points", n);
    }
    knn->memory = memory;
    knn->n = n;
    knn->charged = n * BYTES_PER_POINT;
    set_parameters(&knn->parameters);
    knn->index = flann_build_index_float(unconst(xyz), (int)n, 3, &speedup, &knn->parameters);
    if (knn->index == NULL) {
        vor_knn_free(knn);
        return vor_fail(err, VOR_E_INTERNAL, "FLANN did not index %zu points", n);
    }
    *out = knn;
    return VOR_OK;
}

void vor_knn_free(struct vor_knn *knn)
{
    if (knn == NULL)
        return;
    if (knn->index != NULL)
        flann_free_index_float(knn->index, &knn->parameters);
    vor_memory_release(knn->memory, knn->charged);
    vor_free(knn->memory, knn);
}

void vor_knn_search(const struct vor_knn *knn, const float *queries, size_t count, unsigned k,
                    uint32_t *index, float *distance2)
{
    struct FLANNParameters parameters = knn->parameters; /* every call rewrites its parameters */
    int result;

    assert(k >= 1 && k <= knn->n && count <= INT32_MAX / k);
    if (count == 0)
        return;
    for (size_t i = 0; i < 3 * count; i++)
        assert(isfinite(queries[i]));
    result = flann_find_nearest_neighbors_index_float(knn->index, unconst(queries), (int)count,
                                                      (int *)index, distance2, (int)k, &parameters);
    assert(result == 0);
    (void)result;
}
