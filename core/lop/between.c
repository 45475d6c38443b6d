#include "core/lop/between.h"

#include "core/base/rng.h"
#include "core/knn/knn.h"
#include "core/lop/tree.h"
#include "core/seeds/hurried.h"

#include <assert.h>
#include <math.h>

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
    float *room;        /* begun: squared distance to the farthest of the few */
    size_t *first;      /* begun + 1: points added beside those before each */
    uint64_t seed;
};

/* The points that others are put towards. */
struct towards {
    uint32_t index[VOR_PLANE_POINTS];
    unsigned count;
    float room;
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
    out->room = distance2[k - 1];
    for (int all = 0; all < 2 && out->count == 0; all++)
        for (unsigned j = 0; j < k; j++) {
            double cosine = vor_dotf(&normal[3 * i], &normal[3 * (size_t)index[j]]);

            if (index[j] != i && (all || (distance2[j] > 0 && cosine >= (double)VOR_LOP_AWAY)))
                out->index[out->count++] = index[j];
        }
    assert(out->count > 0); /* there are two points */
}

/* Puts point `at` part of the way from point i to point j. */
static void put(struct vor_lop_samples *samples, size_t at, const size_t ends[2], double part)
{
    const float *x = &samples->xyz[3 * ends[0]], *y = &samples->xyz[3 * ends[1]];
    const float *n = &samples->normal[3 * ends[0]], *m = &samples->normal[3 * ends[1]];
    float *normal = &samples->normal[3 * at];
    const float there[3] = {y[0] - x[0], y[1] - x[1], y[2] - x[2]};
    int alike = vor_dotf(n, m) >= (double)VOR_LOP_BETWEEN_ALIKE;
    double t = alike ? part : part / 2, down = -t * vor_dotf(there, n), length2 = 0;
    double beyond = (1 - t) * vor_dotf(there, m);

    for (int c = 0; c < 3; c++) {
        double lift = alike ? ((1 - t) * down * (double)n[c] + t * beyond * (double)m[c]) / 2
                            : down * (double)n[c];

        samples->xyz[3 * at + (size_t)c] = (float)((double)x[c] + t * (double)there[c] + lift);
        normal[c] = alike ? (float)((1 - t) * (double)n[c] + t * (double)m[c]) : n[c];
        length2 += (double)normal[c] * (double)normal[c];
    }
    for (int c = 0; c < 3; c++)
        normal[c] = (float)((double)normal[c] / sqrt(length2));
}

static void room_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct between *between = ctx;
    struct towards towards;

    for (size_t i = begin; i < end; i++) {
        look_around(&towards, between, i);
        between->room[i] = towards.room;
    }
}

/* How much more room point i has. A comparison: gcc 12 for arm64 fails on sums of fmax. */
static double beyond(const struct between *between, size_t i, double own)
{
    double room = (double)between->room[i];

    return room > own ? room - own : 0;
}

/* Shares the points added out: as many beside a point as its room has more of than that which each
 * point of the result gets. */
static void share_out(struct between *between)
{
    double all = 0, own = 0, sum = 0;

    for (size_t i = 0; i < between->begun; i++)
        all += (double)between->room[i];
    own = all / (double)(between->begun + between->more);
    all = 0;
    for (size_t i = 0; i < between->begun; i++)
        all += beyond(between, i, own);
    between->first[0] = 0;
    for (size_t i = 0; i < between->begun; i++) {
        size_t more = between->more;

        sum += beyond(between, i, own);
        if (i + 1 < between->begun && sum < all)
            more = (size_t)(sum / all * (double)more);
        between->first[i + 1] = more;
    }
}

static void put_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct between *between = ctx;

    for (size_t i = begin; i < end; i++) {
        size_t first = between->first[i], count = between->first[i + 1] - first, times;
        struct towards towards;

        if (count == 0)
            continue;
        look_around(&towards, between, i);
        times = (count + towards.count - 1) / towards.count;
        for (size_t j = 0; j < count; j++) {
            size_t at = between->begun + first + j, time = j / towards.count;
            size_t ends[2] = {i, towards.index[(i + j) % towards.count]};
            double far = vor_rng_unit(between->seed, STREAM_FAR, at);

            put(between->samples, at, ends, ((double)time + far) / (2 * (double)times));
        }
    }
}

vor_status vor_lop_between(struct vor_lop_samples *samples, size_t n, uint64_t seed,
                           const struct vor_run *run, struct vor_error *err)
{
    struct between between = {.samples = samples, .begun = samples->n, .seed = seed};
    vor_status status = VOR_OK;

    if (n <= samples->n)
        return VOR_OK;
    between.more = n - samples->n;
    between.room = vor_malloc(samples->memory, samples->n, sizeof *between.room);
    between.first = vor_malloc(samples->memory, samples->n + 1, sizeof *between.first);
    if (between.room == NULL || between.first == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", samples->n);
    if (status == VOR_OK)
        status = vor_knn_build(&between.knn, samples->xyz, samples->n, samples->memory, err);
    if (status == VOR_OK)
        status = vor_run_for(run, samples->n, BLOCK, room_block, &between, err);
    if (status == VOR_OK)
        share_out(&between);
    if (status == VOR_OK)
        status = vor_run_for(run, samples->n, BLOCK, put_block, &between, err);
    vor_knn_free(between.knn);
    VOR_FREE_ALL(samples->memory, between.first, between.room);
    if (status == VOR_OK)
        samples->n = n;
    return status;
}
