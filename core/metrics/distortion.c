#include "core/metrics/distortion.h"

#include "core/base/linalg.h"
#include "core/base/morton.h"
#include "core/geom/surface.h"
#include "core/knn/knn.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    BLOCK = 256,        /* points of one task */
    CHUNK = 64 * BLOCK, /* points whose ties are in memory at a time */
    FEW = 6,            /* neighbours searched first: hardly ever are more equally near */
    TIES = 30,          /* most equally near points; dmetric's limit */
    NEIGHBORS = 20      /* a normal is fitted to as many points as an exact input's surface */
};

/* One of the two clouds: its distinct points in Morton order. */
struct side {
    float *xyz, *normal;   /* n x 3 both; a normal of 0 is none */
    unsigned char *fitted; /* reference: whether that normal is fitted, and its side arbitrary */
    uint32_t *mapped;      /* cloud: how many normals are summed in normal */
    uint32_t *source;      /* index before sorting */
    size_t n;
    struct vor_knn *knn;
};

/* The points of a side nearest to one point, all at the same distance. */
struct ties {
    double distance2;
    unsigned count; /* 1 .. TIES */
    uint32_t index[TIES];
};

static void side_close(struct side *side, struct vor_memory *memory)
{
    vor_knn_free(side->knn);
    VOR_FREE_ALL(memory, side->source, side->mapped, side->fitted, side->normal, side->xyz);
}

static vor_status side_open(struct side *side, const float *xyz, size_t n,
                            const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    status = VOR_MAKE_ALL(run->memory, err, n, VOR_ARRAY(side->xyz, n, 3),
                          VOR_ZEROED(side->normal, n, 3), VOR_ZEROED(side->fitted, n, 1),
                          VOR_ZEROED(side->mapped, n, 1), VOR_ARRAY(side->source, n, 1));
    if (status != VOR_OK)
        return status;
    status = vor_morton_order(side->source, xyz, n, run, err);
    if (status != VOR_OK)
        return status;
    /* Copies the points in Morton order, without those that coincide with the one before. */
    for (size_t i = 0; i < n; i++) {
        const float *x = &xyz[3 * (size_t)side->source[i]];

        if (side->n > 0 && vor_distance2f(x, &side->xyz[3 * (side->n - 1)]) == 0)
            continue;
        memcpy(&side->xyz[3 * side->n], x, 3 * sizeof *x);
        side->source[side->n++] = side->source[i];
    }
    return vor_knn_build_sorted(&side->knn, side->xyz, side->n, run, err);
}

/* Reduces ties->index, `count` points, to those nearest to x. */
static void keep_nearest(struct ties *ties, const struct side *side, const float *x, unsigned count)
{
    double distance2[TIES];

    ties->distance2 = INFINITY;
    for (unsigned j = 0; j < count; j++) {
        distance2[j] = vor_distance2f(x, &side->xyz[3 * (size_t)ties->index[j]]);
        ties->distance2 = fmin(ties->distance2, distance2[j]);
    }
    ties->count = 0;
    for (unsigned j = 0; j < count; j++)
        if (distance2[j] == ties->distance2)
            ties->index[ties->count++] = ties->index[j];
}

static void find_ties(struct ties *ties, const struct side *side, const float *x)
{
    unsigned few = side->n < FEW ? (unsigned)side->n : FEW;
    unsigned most = side->n < TIES ? (unsigned)side->n : TIES;
    float distance2[TIES];

    vor_knn_search(side->knn, x, 1, few, ties->index, distance2);
    keep_nearest(ties, side, x, few);
    if (ties->count < few || few == most)
        return;
    vor_knn_search(side->knn, x, 1, most, ties->index, distance2);
    keep_nearest(ties, side, x, most);
}

struct peak {
    const struct side *side;
    double *block; /* the largest square in each block */
};

static void peak_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct peak *peak = ctx;
    const float *xyz = peak->side->xyz;
    double most = 0;

    for (size_t i = begin; i < end; i++) {
        uint32_t index[2];
        float distance2[2];

        /* The point itself is one of the two: the first, unless float32 squares underflow. */
        vor_knn_search(peak->side->knn, &xyz[3 * i], 1, 2, index, distance2);
        for (int j = 0; j < 2; j++)
            most = fmax(most, vor_distance2f(&xyz[3 * i], &xyz[3 * (size_t)index[j]]));
    }
    peak->block[begin / BLOCK] = most;
}

static vor_status find_peak(double *out, const struct side *side, const struct vor_run *run,
                            struct vor_error *err)
{
    size_t blocks = (side->n + BLOCK - 1) / BLOCK;
    struct peak peak = {side, vor_calloc(run->memory, blocks, sizeof(double))};
    double most = 0;
    vor_status status;

    if (peak.block == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", side->n);
    status = vor_run_for(run, side->n, BLOCK, peak_block, &peak, err);
    for (size_t b = 0; b < blocks; b++)
        most = fmax(most, peak.block[b]);
    *out = sqrt(most);
    vor_free(run->memory, peak.block);
    return status;
}

struct normals {
    struct side *side;
    const struct vor_attribute *carried; /* NULL: none */
};

/* Takes the normal that point i carries. Returns false when it carries none with a direction. */
static int take_normal(const struct normals *normals, size_t i)
{
    double normal[3], length;

    if (normals->carried == NULL)
        return 0;
    for (size_t c = 0; c < 3; c++)
        normal[c] = vor_attribute_scalar(
            normals->carried, (size_t)normals->side->source[i] * normals->carried->components + c);
    length = sqrt(vor_dot(normal, normal));
    if (!(length > 0 && isfinite(length)))
        return 0;
    for (size_t c = 0; c < 3; c++)
        normals->side->normal[3 * i + c] = (float)(normal[c] / length);
    return 1;
}

static void fit_normal(struct side *side, size_t i)
{
    static const double foot[3] = {0, 0, 0};
    unsigned k = side->n < NEIGHBORS ? (unsigned)side->n : NEIGHBORS;
    uint32_t index[NEIGHBORS];
    float distance2[NEIGHBORS];
    struct vor_surface surface;
    double normal[3];

    vor_knn_search(side->knn, &side->xyz[3 * i], 1, k, index, distance2);
    (void)vor_surface_fit_to(&surface, side->xyz, index, k);
    if (surface.kind == VOR_SURFACE_NONE)
        return;
    vor_surface_normal(&surface, foot, normal);
    vor_to_floats(&side->normal[3 * i], normal);
    side->fitted[i] = 1;
}

static void normals_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct normals *normals = ctx;

    if (!take_normal(normals, i))
        fit_normal(normals->side, i);
}

static int is_none(const float normal[3])
{
    return normal[0] == 0 && normal[1] == 0 && normal[2] == 0;
}

/* Adds the normal of reference point i to that of cloud point j. */
static void add_normal(struct side *cloud, size_t j, const struct side *reference, size_t i)
{
    const float *normal = &reference->normal[3 * i];
    float *sum = &cloud->normal[3 * j], along = 0;

    for (int c = 0; c < 3; c++)
        along += sum[c] * normal[c];
    for (int c = 0; c < 3; c++)
        sum[c] += reference->fitted[i] && along < 0 ? -normal[c] : normal[c];
    cloud->mapped[j] += !is_none(normal);
}

/* The points of `from`, CHUNK at a time, and their nearest ones of `to`. */
struct mapping {
    const struct side *from, *to;
    struct ties *ties; /* of the points from first on */
    size_t first;
};

static void mapping_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct mapping *mapping = ctx;

    find_ties(&mapping->ties[i], mapping->to, &mapping->from->xyz[3 * (mapping->first + i)]);
}

/* Gives each point of the cloud the mean normal of the reference points whose nearest it is. The
 * searches run on all threads, the sums in the order of the points. */
static vor_status map_normals(struct side *cloud, const struct side *reference,
                              const struct vor_run *run, struct vor_error *err)
{
    size_t room = reference->n < CHUNK ? reference->n : CHUNK;
    struct mapping mapping = {reference, cloud, vor_malloc(run->memory, room, sizeof(struct ties)),
                              0};
    vor_status status = VOR_OK;

    if (mapping.ties == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", room);
    for (; mapping.first < reference->n && status == VOR_OK; mapping.first += room) {
        size_t left = reference->n - mapping.first, count = left < room ? left : room;

        status = vor_run_rows(run, count, BLOCK, mapping_row, &mapping, err);
        for (size_t i = 0; i < count && status == VOR_OK; i++)
            for (unsigned j = 0; j < mapping.ties[i].count; j++)
                add_normal(cloud, mapping.ties[i].index[j], reference, mapping.first + i);
    }
    for (size_t j = 0; j < cloud->n; j++)
        for (size_t c = 0; c < 3 && cloud->mapped[j] > 0; c++)
            cloud->normal[3 * j + c] /= (float)cloud->mapped[j];
    vor_free(run->memory, mapping.ties);
    return status;
}

/* Mean square of the distances from x to its nearest points along their normals. */
static double along_normals(const struct ties *ties, const struct side *side, const float *x)
{
    double sum = 0;

    for (unsigned j = 0; j < ties->count; j++) {
        const float *to = &side->xyz[3 * (size_t)ties->index[j]];
        const float *normal = &side->normal[3 * (size_t)ties->index[j]];
        double along = 0;

        for (int c = 0; c < 3; c++)
            along += ((double)x[c] - (double)to[c]) * (double)normal[c];
        sum += is_none(normal) ? ties->distance2 : along * along;
    }
    return sum / ties->count;
}

struct errors {
    double d1, d2;
};

struct comparison {
    const struct side *from, *to;
    struct errors *block; /* sums over each block */
};

static void compare_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct comparison *comparison = ctx;
    struct errors sum = {0, 0};

    for (size_t i = begin; i < end; i++) {
        const float *x = &comparison->from->xyz[3 * i];
        struct ties ties;

        find_ties(&ties, comparison->to, x);
        sum.d1 += ties.distance2;
        sum.d2 += along_normals(&ties, comparison->to, x);
    }
    comparison->block[begin / BLOCK] = sum;
}

/* Mean errors over the points of from, summed in block order. */
static vor_status compare(struct errors *out, const struct side *from, const struct side *to,
                          const struct vor_run *run, struct vor_error *err)
{
    struct comparison comparison = {from, to, NULL};
    size_t n = from->n, blocks = (n + BLOCK - 1) / BLOCK;
    vor_status status;

    *out = (struct errors){0, 0};
    comparison.block = vor_calloc(run->memory, blocks, sizeof *comparison.block);
    if (comparison.block == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_run_for(run, n, BLOCK, compare_block, &comparison, err);
    for (size_t b = 0; b < blocks; b++) {
        out->d1 += comparison.block[b].d1 / (double)n;
        out->d2 += comparison.block[b].d2 / (double)n;
    }
    vor_free(run->memory, comparison.block);
    return status;
}

static vor_status measure(struct vor_distortion *out, struct side *cloud, struct side *reference,
                          const struct vor_attribute *carried, const struct vor_run *run,
                          struct vor_error *err)
{
    struct normals normals = {reference, carried};
    struct errors from_cloud = {0, 0}, from_reference = {0, 0};
    vor_status status = find_peak(&out->peak, reference, run, err);

    VOR_THEN(status, vor_run_rows(run, reference->n, BLOCK, normals_row, &normals, err));
    VOR_THEN(status, map_normals(cloud, reference, run, err));
    VOR_THEN(status, compare(&from_cloud, cloud, reference, run, err));
    VOR_THEN(status, compare(&from_reference, reference, cloud, run, err));
    out->d1_mse = fmax(from_cloud.d1, from_reference.d1);
    out->d2_mse = fmax(from_cloud.d2, from_reference.d2);
    return status;
}

vor_status vor_distortion_measure(struct vor_distortion *out,
                                  const struct vor_distortion_pair *pair, const struct vor_run *run,
                                  struct vor_error *err)
{
    const struct vor_attribute *carried = pair->normals;
    struct side cloud = {0}, reference = {0};
    struct vor_distortion distortion;
    vor_status status;

    if (pair->n == 0 || pair->m == 0)
        return vor_fail(
            err, VOR_E_DEGENERATE,
            "the cloud has %zu points and the reference has %zu, want at least 1 in each", pair->n,
            pair->m);
    if (carried != NULL && carried->components < 3)
        carried = NULL;
    status = side_open(&cloud, pair->xyz, pair->n, run, err);
    VOR_THEN(status, side_open(&reference, pair->reference, pair->m, run, err));
    if (status == VOR_OK && reference.n < 2)
        status =
            vor_fail(err, VOR_E_DEGENERATE,
                     "the reference has %zu points at the same position, want at least 2 positions",
                     pair->m);
    VOR_THEN(status, measure(&distortion, &cloud, &reference, carried, run, err));
    if (status == VOR_OK)
        *out = distortion;
    side_close(&reference, run->memory);
    side_close(&cloud, run->memory);
    return status;
}

double vor_distortion_psnr(double mse, double peak)
{
    assert(mse >= 0 && peak > 0);
    return mse > 0 ? 10 * log10(3 * peak * peak / mse) : INFINITY;
}
