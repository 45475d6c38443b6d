#include "core/align/samples.h"

#include "core/base/linalg.h"
#include "core/cloud/extent.h"
#include "core/input/carried.h"
#include "core/input/orient.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    SAMPLES = 6000, /* of the larger cloud, about; with a known scale up to MANY times as many */
    MANY = 4,
    EACH = 3,            /* points of the cloud for each sample at least, or they leave gaps */
    FEW = 450,           /* far from each other, of the larger cloud */
    ENTRIES = 1 << 16,   /* of the table of cubes: twice as many as there may be */
    BITS = 21,           /* of a cube's place along an axis */
    POLL_EVERY = 1 << 16 /* points */
};

static const char *const names[] = {"cloud", "reference"};

/* Points in a cube. */
struct cube {
    uint64_t place;
    double sum[3], count; /* count is 0 where the entry is free */
    uint32_t first;
};

struct cubes {
    double low[3], edge;
    size_t used;
    struct cube entry[ENTRIES];
    uint32_t order[ENTRIES]; /* entries by their first points */
};

/* One of the two clouds. */
struct side {
    const struct vor_cloud *cloud;
    struct vor_extent extent;
    double edge; /* of cubes */
    struct vor_cloud means;
};

static struct cube *find_cube(struct cubes *cubes, const double x[3])
{
    uint64_t place = 0;
    size_t at;

    for (int c = 0; c < 3; c++)
        place = place << BITS | (uint64_t)((x[c] - cubes->low[c]) / cubes->edge);
    at = (size_t)((place * UINT64_C(0x9e3779b97f4a7c15)) >> 48);
    while (cubes->entry[at].count > 0 && cubes->entry[at].place != place)
        at = (at + 1) & (ENTRIES - 1);
    cubes->entry[at].place = place;
    return &cubes->entry[at];
}

/* Adds the points of a cloud to the cubes that they are in; ends early where these are too many. */
static vor_status fill_cubes(struct cubes *cubes, const struct side *side, size_t most,
                             const struct vor_run *run, struct vor_error *err)
{
    vor_status status = VOR_OK;

    memset(cubes, 0, sizeof *cubes);
    cubes->edge = side->edge;
    memcpy(cubes->low, side->extent.low, sizeof cubes->low);
    for (size_t i = 0; status == VOR_OK && i < side->cloud->n && cubes->used <= most; i++) {
        double x[3];
        struct cube *cube;

        if (i % POLL_EVERY == 0)
            status = vor_run_answered(vor_run_poll(run), err);
        vor_cloud_position(side->cloud, i, x);
        cube = find_cube(cubes, x);
        if (!(cube->count > 0)) {
            cube->first = (uint32_t)i;
            cubes->order[cubes->used++] = (uint32_t)(cube - cubes->entry);
        }
        for (int c = 0; c < 3; c++)
            cube->sum[c] += x[c] - cubes->low[c];
        cube->count += 1;
    }
    return status;
}

/* Makes a cloud of the means, relative to the middle of the box, with the normals of first points.
 */
static vor_status make_means(struct side *side, const struct cubes *cubes, struct vor_error *err)
{
    const struct vor_attribute *carried = vor_carried(side->cloud);
    struct vor_cloud *means = &side->means;
    vor_status status = vor_cloud_resize(means, cubes->used, err);
    uint32_t *first = NULL;

    if (status == VOR_OK && carried != NULL) {
        first = vor_malloc(means->memory, cubes->used, sizeof *first);
        if (first == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu samples", cubes->used);
    }
    for (size_t i = 0; status == VOR_OK && i < cubes->used; i++) {
        const struct cube *cube = &cubes->entry[cubes->order[i]];

        for (int c = 0; c < 3; c++) /* low is the origin of sums, and means are about the middle */
            means->xyz[3 * i + (size_t)c] =
                (float)(cube->sum[c] / cube->count -
                        (side->extent.high[c] - side->extent.low[c]) / 2);
        if (first != NULL)
            first[i] = cube->first;
    }
    if (first != NULL && status == VOR_OK)
        status = vor_cloud_copy_attribute(means, carried, first, err);
    vor_free(means->memory, first);
    return status;
}

/* Makes the means of both clouds, in wider cubes where one cloud has too many. */
static vor_status make_both(struct side side[2], int fixed, const struct vor_run *run,
                            struct vor_error *err)
{
    struct cubes *cubes = vor_malloc(run->memory, 1, sizeof *cubes);
    vor_status status = VOR_OK;

    if (cubes == NULL)
        return vor_fail(err, VOR_E_NOMEM, "cubes");
    for (int k = 0; status == VOR_OK && k < 2;) {
        status = fill_cubes(cubes, &side[k], SAMPLES * MANY, run, err);
        if (status == VOR_OK && cubes->used <= SAMPLES * MANY) {
            status = make_means(&side[k++], cubes, err);
            continue;
        }
        side[k].edge *= M_SQRT2; /* half as many */
        if (fixed) {
            vor_cloud_free(&side[0].means);
            side[0].edge = side[1].edge = side[k].edge;
            k = 0;
        }
    }
    vor_free(run->memory, cubes);
    return status;
}

static double diagonal(const struct vor_extent *extent)
{
    double sum = 0;

    for (int c = 0; c < 3; c++)
        sum += (extent->high[c] - extent->low[c]) * (extent->high[c] - extent->low[c]);
    return sqrt(sum);
}

static double edge_for(const struct side *side, double most)
{
    double wanted = fmin(most, (double)side->cloud->n / EACH);

    return sqrt(VOR_EXTENT_CUBES * side->extent.area / wanted);
}

/* Measures both clouds and chooses their cubes. */
static vor_status choose_cubes(struct side side[2], int fixed, struct vor_error *err)
{
    double diagonals[2];

    for (int k = 0; k < 2; k++) {
        if (side[k].cloud->n < VOR_ALIGN_POINTS_MIN)
            return vor_fail_param(err, VOR_E_DEGENERATE, names[k],
                                  "the %s has %zu points, want at least %d", names[k],
                                  side[k].cloud->n, VOR_ALIGN_POINTS_MIN);
        vor_extent_measure(&side[k].extent, side[k].cloud);
        diagonals[k] = diagonal(&side[k].extent);
        if (!(diagonals[k] > 0))
            return vor_fail_param(err, VOR_E_DEGENERATE, names[k],
                                  "all %zu points of the %s are at the same position",
                                  side[k].cloud->n, names[k]);
        side[k].edge = edge_for(&side[k], SAMPLES);
    }
    if (!(diagonals[0] / diagonals[1] <= VOR_ALIGN_RATIO_MAX &&
          diagonals[1] / diagonals[0] <= VOR_ALIGN_RATIO_MAX))
        return vor_fail(err, VOR_E_DEGENERATE,
                        "the diagonals of the clouds are %g and %g, want a ratio of at most %g",
                        diagonals[0], diagonals[1], VOR_ALIGN_RATIO_MAX);
    if (fixed) {
        double edge = fmin(side[0].edge, side[1].edge);

        for (int k = 0; k < 2; k++)
            edge = fmax(edge, edge_for(&side[k], SAMPLES * MANY));
        side[0].edge = side[1].edge = edge;
    }
    for (int k = 0; k < 2; k++) /* places of cubes have so many bits */
        side[k].edge = fmax(side[k].edge, diagonals[k] / ((1 << BITS) - 1));
    return VOR_OK;
}

/* Takes over the points of a domain with their normals. */
static vor_status take_oriented(struct vor_align_samples *out, const struct side *side,
                                const struct vor_domain *domain,
                                const struct vor_orientation *oriented, struct vor_error *err)
{
    double sum[3] = {0, 0, 0}, sum2 = 0, n = (double)domain->n;

    assert(oriented->thin.n == 0);
    out->n = domain->n;
    out->xyz = vor_malloc(out->memory, out->n, 3 * sizeof *out->xyz);
    out->normal = vor_malloc(out->memory, out->n, 3 * sizeof *out->normal);
    if (out->xyz == NULL || out->normal == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu samples", out->n);
    memcpy(out->normal, oriented->normal, 3 * out->n * sizeof *out->normal);
    for (size_t i = 0; i < 3 * out->n; i++) {
        double x = (double)domain->xyz[i] * domain->unit + domain->shift[i % 3];

        out->xyz[i] = (float)x;
        sum[i % 3] += x;
        sum2 += x * x;
    }
    for (int c = 0; c < 3; c++) {
        sum2 -= sum[c] * sum[c] / n;
        out->middle[c] = (side->extent.low[c] + side->extent.high[c]) / 2;
    }
    out->unit = sqrt(sum2 / n);
    return VOR_OK;
}

static vor_status orient(struct vor_align_samples *out, const struct side *side,
                         const struct vor_run *run, struct vor_error *err)
{
    struct vor_orientation oriented = {.normal = NULL};
    struct vor_orient_how how = {.carried = vor_carried(&side->means), .plain = 1};
    struct vor_domain domain;
    vor_status status = vor_domain_init(&domain, &side->means, run, err);

    if (status != VOR_OK)
        return status;
    how.points = domain.n;
    out->carried = how.carried != NULL;
    status = vor_orient(&oriented, &domain, &how, run, err);
    if (status == VOR_OK)
        status = take_oriented(out, side, &domain, &oriented, err);
    vor_orientation_free(&oriented, run->memory);
    vor_domain_free(&domain);
    return status;
}

/* Chooses points, each the farthest from those before, until they are nearer than `apart` or enough
 * (Gonzalez 1985). Sets samples->apart to the distance of the last one. */
static vor_status choose_few(struct vor_align_samples *samples, double apart, struct vor_error *err)
{
    size_t most = samples->n < FEW ? samples->n : FEW;
    float *near2 = vor_malloc(samples->memory, samples->n, sizeof *near2);
    uint32_t next = 0;

    samples->chosen = vor_malloc(samples->memory, most, sizeof *samples->chosen);
    if (samples->chosen == NULL || near2 == NULL) {
        vor_free(samples->memory, near2);
        return vor_fail(err, VOR_E_NOMEM, "%zu samples", samples->n);
    }
    for (size_t i = 0; i < samples->n; i++)
        near2[i] = INFINITY;
    while (samples->few < most && (double)near2[next] > apart * apart) {
        const float *at = &samples->xyz[3 * (size_t)next];
        float farthest = -1;

        if (samples->few > 0)
            samples->apart = sqrt((double)near2[next]);
        samples->chosen[samples->few++] = next;
        for (size_t i = 0; i < samples->n; i++) {
            near2[i] = fminf(near2[i], (float)vor_distance2f(&samples->xyz[3 * i], at));
            if (near2[i] > farthest) {
                farthest = near2[i];
                next = (uint32_t)i;
            }
        }
    }
    vor_free(samples->memory, near2);
    return VOR_OK;
}

/* Scales the samples to their unit, indexes them and chooses the few. */
static vor_status finish(struct vor_align_samples *samples, double edge, double apart,
                         const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    for (size_t i = 0; i < 3 * samples->n; i++)
        samples->xyz[i] = (float)((double)samples->xyz[i] / samples->unit);
    samples->gap = edge / samples->unit;
    status = vor_knn_build_sorted(&samples->knn, samples->xyz, samples->n, run, err);
    return status == VOR_OK ? choose_few(samples, apart, err) : status;
}

vor_status vor_align_samples_make(struct vor_align_samples out[2],
                                  const struct vor_cloud *const cloud[2], int fixed,
                                  const struct vor_run *run, struct vor_error *err)
{
    struct side *side = vor_calloc(run->memory, 2, sizeof *side);
    vor_status status;
    int large;

    memset(out, 0, 2 * sizeof *out);
    if (side == NULL)
        return vor_fail(err, VOR_E_NOMEM, "samples");
    for (int k = 0; k < 2; k++) {
        out[k].memory = run->memory;
        side[k].cloud = cloud[k];
        vor_cloud_init(&side[k].means, run->memory);
    }
    status = choose_cubes(side, fixed, err);
    if (status == VOR_OK)
        status = make_both(side, fixed, run, err);
    for (int k = 0; status == VOR_OK && k < 2; k++) {
        status = orient(&out[k], &side[k], run, err);
        if (status == VOR_E_DEGENERATE)
            status = vor_fail_param(err, status, names[k],
                                    "all %zu points of the %s lie on one line, or too close to one "
                                    "line",
                                    cloud[k]->n, names[k]);
    }
    if (status == VOR_OK && fixed)
        out[0].unit = out[1].unit = fmax(out[0].unit, out[1].unit);
    large = out[0].n > out[1].n ? 0 : 1;
    if (status == VOR_OK)
        status = finish(&out[large], side[large].edge, 0, run, err);
    if (status == VOR_OK)
        status = finish(&out[!large], side[!large].edge, fixed ? out[large].apart : 0, run, err);
    for (int k = 0; k < 2; k++)
        vor_cloud_free(&side[k].means);
    vor_free(run->memory, side);
    return status;
}

void vor_align_samples_free(struct vor_align_samples *samples)
{
    vor_knn_free(samples->knn);
    VOR_FREE_ALL(samples->memory, samples->xyz, samples->normal, samples->chosen);
    memset(samples, 0, sizeof *samples);
}
