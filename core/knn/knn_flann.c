/* FLANN's single kd-tree (Muja and Lowe 2009, "Fast approximate nearest neighbors with automatic
 * algorithm configuration"): exact, and the same answers every time; its other indexes take seeds
 * from the machine. knn.c keeps out what crashes or misleads it: no points, more neighbours than
 * points, coordinates that are not finite or overflow when squared. */
#include "core/knn/knn_flann.h"

#include <assert.h>
#include <flann/flann.h>

/* Bytes of an index for each point. Measured with leaves of 16 points: 37, and the allocator's own.
 */
#define BYTES_PER_POINT 44

struct vor_flann {
    flann_index_t index;
    struct FLANNParameters parameters; /* read only once built */
    size_t charged;
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

vor_status vor_flann_build(struct vor_flann **out, const float *xyz, size_t n,
                           struct vor_memory *memory, struct vor_error *err)
{
    struct vor_flann *flann;
    float speedup;

    flann = vor_calloc(memory, 1, sizeof *flann);
    if (flann == NULL || !vor_memory_charge(memory, n * BYTES_PER_POINT)) {
        vor_free(memory, flann);
        return vor_fail(err, VOR_E_NOMEM, "an index of %zu points", n);
    }
    flann->memory = memory;
    flann->charged = n * BYTES_PER_POINT;
    set_parameters(&flann->parameters);
    flann->index = flann_build_index_float(unconst(xyz), (int)n, 3, &speedup, &flann->parameters);
    if (flann->index == NULL) {
        vor_flann_free(flann);
        return vor_fail(err, VOR_E_INTERNAL, "FLANN did not index %zu points", n);
    }
    *out = flann;
    return VOR_OK;
}

void vor_flann_free(struct vor_flann *flann)
{
    if (flann == NULL)
        return;
    if (flann->index != NULL)
        flann_free_index_float(flann->index, &flann->parameters);
    vor_memory_release(flann->memory, flann->charged);
    vor_free(flann->memory, flann);
}

void vor_flann_search(const struct vor_flann *flann, const float *queries, size_t count, unsigned k,
                      uint32_t *index, float *distance2)
{
    struct FLANNParameters parameters = flann->parameters; /* every call rewrites its parameters */
    int result;

    result = flann_find_nearest_neighbors_index_float(flann->index, unconst(queries), (int)count,
                                                      (int *)index, distance2, (int)k, &parameters);
    assert(result == 0);
    (void)result;
}
