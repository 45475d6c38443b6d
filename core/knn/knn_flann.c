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
    const float *xyz;
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
    flann->xyz = xyz;
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

/* As FLANN sums it where no multiply-add is fused. */
static float distance2_of(const float *a, const float *b)
{
    float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];

    return x * x + y * y + z * z;
}

/* Where the machine fuses multiply-adds, as arm64 does, so does Debian's FLANN: its distances end
 * in other bits than those of amd64. There they are computed anew, and neighbours that this puts in
 * another order change places. Of points that are as far as the k-th but for the last bit, FLANN's
 * choice stays. Elsewhere it would find every bit as it is, for 4 % of the time of a large job. */
#ifdef __FP_FAST_FMAF
enum { FLANN_FUSES = 1 };
#else
enum { FLANN_FUSES = 0 };
#endif

static void same_everywhere(const struct vor_flann *flann, const float *query, unsigned k,
                            uint32_t *index, float *distance2)
{
    for (unsigned i = 0; i < k; i++) {
        uint32_t at = index[i];
        float d2 = distance2_of(query, &flann->xyz[3 * (size_t)at]);
        unsigned j = i;

        for (; j > 0 && distance2[j - 1] > d2; j--) {
            index[j] = index[j - 1];
            distance2[j] = distance2[j - 1];
        }
        index[j] = at;
        distance2[j] = d2;
    }
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
    for (size_t i = 0; FLANN_FUSES && i < count; i++)
        same_everywhere(flann, &queries[3 * i], k, &index[i * k], &distance2[i * k]);
}
