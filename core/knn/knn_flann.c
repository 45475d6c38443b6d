/* FLANN's single kd-tree (Muja and Lowe 2009, "Fast approximate nearest neighbors with automatic
 * algorithm configuration"): exact, and the same answers every time; its other indexes take seeds
 * from the machine. knn.c keeps out what crashes or misleads it: no points, more neighbours than
 * points, coordinates that are not finite or overflow when squared.
 *
 * FLANN looks at every point that is as near as the k-th: for each query beside n points in one
 * place, at all n. A depth camera writes each pixel without a depth as (0, 0, 0). Where many points
 * share a place, FLANN indexes the places. */
#include "core/knn/knn_flann.h"

#include "core/knn/places.h"

#include <assert.h>
#include <flann/flann.h>

/* Bytes of an index for each point. Measured with leaves of 16 points: 37, and the allocator's own.
 */
#define BYTES_PER_POINT 44

/* Points of a place from which on places are indexed. So many cost a query that meets them a tenth
 * of a microsecond; it takes one or two without. */
enum { MANY = 64 };

struct vor_flann {
    flann_index_t index;
    const float *xyz;                  /* what is indexed: the points, or the places */
    size_t n;                          /* how many these are */
    struct vor_places places;          /* all zero: of the points */
    struct FLANNParameters parameters; /* read only once built */
    size_t charged;
    struct vor_memory *memory;
};

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
    struct vor_flann *flann = vor_calloc(memory, 1, sizeof *flann);
    float speedup;
    vor_status status;

    if (flann == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    flann->memory = memory;
    status = vor_places_find(&flann->places, xyz, n, MANY, memory, err);
    if (status != VOR_OK)
        goto failed;
    flann->xyz = flann->places.n > 0 ? flann->places.xyz : xyz;
    flann->n = flann->places.n > 0 ? flann->places.n : n;
    if (!vor_memory_charge(memory, flann->n * BYTES_PER_POINT)) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", n);
        goto failed;
    }
    flann->charged = flann->n * BYTES_PER_POINT;
    flann->parameters = (struct FLANNParameters){
        .algorithm = FLANN_INDEX_KDTREE_SINGLE,
        .checks = FLANN_CHECKS_UNLIMITED,
        .sorted = 1,
        .cores = 1, /* 0 would start an OpenMP team inside every call */
        .leaf_max_size = 16,
        .log_level = FLANN_LOG_NONE,
    };
    flann->index = flann_build_index_float(unconst(flann->xyz), (int)flann->n, 3, &speedup,
                                           &flann->parameters);
    if (flann->index == NULL) {
        status = vor_fail(err, VOR_E_INTERNAL, "FLANN did not index %zu points", n);
        goto failed;
    }
    *out = flann;
    return VOR_OK;
failed:
    vor_flann_free(flann);
    return status;
}

void vor_flann_free(struct vor_flann *flann)
{
    if (flann == NULL)
        return;
    if (flann->index != NULL)
        flann_free_index_float(flann->index, &flann->parameters);
    vor_memory_release(flann->memory, flann->charged);
    vor_places_free(&flann->places);
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

/* The k nearest of what is indexed. */
static void search(const struct vor_flann *flann, const float *queries, size_t count, unsigned k,
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

/* Writes the k nearest points where the nearest places stand, which have as many. Backwards: no
 * place is written over before it is read. */
static void put_points(const struct vor_places *places, unsigned k, uint32_t *index,
                       float *distance2)
{
    const uint32_t *first = places->first;
    size_t used = 0, end = 0;

    for (; end < k; used++)
        end += first[index[used] + 1] - first[index[used]];
    while (used-- > 0) {
        uint32_t place = index[used];
        float d2 = distance2[used];
        size_t begin = end - (first[place + 1] - first[place]);

        for (size_t i = begin; i < end && i < k; i++) {
            index[i] = places->point[first[place] + (i - begin)];
            distance2[i] = d2;
        }
        end = begin;
    }
}

/* The nearest place first, alone: a query in a crowded one is answered by it, whatever lies around.
 */
static void search_places(const struct vor_flann *flann, const float query[3], unsigned k,
                          uint32_t *index, float *distance2)
{
    const uint32_t *first = flann->places.first;

    search(flann, query, 1, 1, index, distance2);
    if (first[index[0] + 1] - first[index[0]] < k)
        search(flann, query, 1, k < flann->n ? k : (unsigned)flann->n, index, distance2);
    put_points(&flann->places, k, index, distance2);
}

void vor_flann_search(const struct vor_flann *flann, const float *queries, size_t count, unsigned k,
                      uint32_t *index, float *distance2)
{
    if (flann->places.n == 0) {
        search(flann, queries, count, k, index, distance2);
        return;
    }
    for (size_t i = 0; i < count; i++)
        search_places(flann, &queries[3 * i], k, &index[i * k], &distance2[i * k]);
}
