#include "core/input/domain.h"

#include "core/base/bounds.h"
#include "core/base/linalg.h"
#include "core/base/morton.h"
#include "core/base/stat.h"
#include "core/geom/patch.h"
#include "core/input/remote.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 1 << 16 }; /* points of one task */

/* Share of the sample that is not sparser than vor_domain.sparse: a spacing beyond it is believed
 * nowhere, so that a lone point does not gather a ring of results around it. At 0.99 / 0.999 / 1
 * the largest distance of the result to the input is 0.94 / 1.39 / 2.29 spacings on autzen, 3.2
 * / 6.8 / 8.5 on kitti; at 0.99 thin parts of scans lose points. */
#define SPARSE_SHARE 0.999

/* Lone points that are more than one in a thousand lie beyond a gap in the sorted distances: one is
 * LONE_GAP times the one before. Such a gap is believed to be the end of the surface if it comes
 * after LONE_FROM of them. Measured with spheres of 1,000, 2,500 and 10,000 points, 43 lone points
 * at 4 to 8 radii around each, four seeds: without the gap, 0 of 516 are found to be islands; at a
 * gap of 4 / 8 / 16, 516 / 516 / 301; after 0.9 / 0.95 / 0.975, 516 / 516 / 344. At a gap of 4, a
 * floor 20 times as coarse as the rest is taken for 399 islands, at 8 for none. Of 20 scans and
 * made clouds, none has a gap of more than 1.5 there. */
#define LONE_FROM 0.95
#define LONE_GAP 8.0

/* Chooses shift and unit. The shift is 0 where the middle is nearer to the origin than the cloud is
 * long, because shifting costs small coordinates their last bits. Float32 then has at most two bits
 * less for it than about its own middle. */
static void choose_frame(struct vor_domain *out, const struct vor_box *box)
{
    double low[3], high[3], extent = 0, middle = 0, largest = 0;
    int exponent;

    for (int c = 0; c < 3; c++) {
        low[c] = (double)box->low[c];
        high[c] = (double)box->high[c];
        out->shift[c] = (double)(float)(low[c] / 2 + high[c] / 2);
        extent = fmax(extent, high[c] - low[c]);
        middle = fmax(middle, fabs(out->shift[c]));
    }
    for (int c = 0; c < 3; c++) {
        if (middle <= extent)
            out->shift[c] = 0;
        largest = fmax(largest, fmax(fabs(low[c] - out->shift[c]), fabs(high[c] - out->shift[c])));
    }
    (void)frexp(largest, &exponent);
    out->unit = largest > 0 ? ldexp(1, exponent) : 1;
}

/* Drops points that coincide with the one before, and the room of those. */
static vor_status drop_coincident(struct vor_domain *out, struct vor_error *err)
{
    size_t n = out->n, kept = 1;
    float *xyz;
    uint32_t *source;

    for (size_t i = 1; i < n; i++) {
        const float *a = &out->xyz[3 * i], *b = &out->xyz[3 * (kept - 1)];

        if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2])
            continue;
        if (kept < i)
            memcpy(&out->xyz[3 * kept], &out->xyz[3 * i], 3 * sizeof *out->xyz);
        out->source[kept++] = out->source[i];
    }
    out->n = kept;
    if (kept == n)
        return VOR_OK;
    source = vor_realloc(out->memory, out->source, kept, sizeof *source);
    out->source = source != NULL ? source : out->source;
    xyz = vor_realloc(out->memory, out->xyz, kept, 3 * sizeof *xyz);
    out->xyz = xyz != NULL ? xyz : out->xyz;
    return source != NULL && xyz != NULL ? VOR_OK : vor_fail(err, VOR_E_NOMEM, "%zu points", n);
}

/* Normalises, sorts and drops coincident points. */
static vor_status sort_points(struct vor_domain *out, const struct vor_cloud *cloud,
                              const struct vor_run *run, struct vor_error *err)
{
    struct vor_morton_input in = {.xyz = cloud->xyz, .n = cloud->n, .scale = 1 / out->unit};
    vor_status status;

    memcpy(in.shift, out->shift, sizeof in.shift);
    out->n = cloud->n;
    out->xyz = vor_malloc(out->memory, out->n, 3 * sizeof *out->xyz);
    out->source = vor_malloc(out->memory, out->n, sizeof *out->source);
    if (out->xyz == NULL || out->source == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", out->n);
    status = vor_morton_sort(out->xyz, out->source, &in, run, err);
    return status == VOR_OK ? drop_coincident(out, err) : status;
}

/* Sums over the points, by blocks. */
struct sums {
    const float *xyz;
    double mean[3];
    double (*block)[6];
};

static void sum_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct sums *sums = ctx;
    double *sum = sums->block[begin / BLOCK];

    memset(sum, 0, 6 * sizeof *sum);
    for (size_t i = begin; i < end; i++)
        for (size_t c = 0; c < 3; c++)
            sum[c] += (double)sums->xyz[3 * i + c];
}

static void spread_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct sums *sums = ctx;
    double *m = sums->block[begin / BLOCK];

    memset(m, 0, 6 * sizeof *m);
    for (size_t i = begin; i < end; i++) {
        double d[3];

        for (size_t c = 0; c < 3; c++)
            d[c] = (double)sums->xyz[3 * i + c] - sums->mean[c];
        vor_add_square(m, d);
    }
}

/* Second moments of the points about their mean. */
static vor_status moments(double m[6], const struct vor_domain *domain, const struct vor_run *run,
                          struct vor_error *err)
{
    size_t blocks = vor_blocks_of(domain->n, BLOCK);
    struct sums sums = {.xyz = domain->xyz};
    vor_status status;

    sums.block = vor_malloc(run->memory, blocks, sizeof *sums.block);
    if (sums.block == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    status = vor_run_for(run, domain->n, BLOCK, sum_block, &sums, err);
    if (status == VOR_OK) {
        for (size_t i = 0; i < 3 * blocks; i++)
            sums.mean[i % 3] += sums.block[i / 3][i % 3];
        for (int c = 0; c < 3; c++)
            sums.mean[c] /= (double)domain->n;
        status = vor_run_for(run, domain->n, BLOCK, spread_block, &sums, err);
    }
    for (size_t i = 0; status == VOR_OK && i < 6 * blocks; i++)
        m[i % 6] += sums.block[i / 6][i % 6];
    vor_free(run->memory, sums.block);
    return status;
}

vor_status vor_domain_check(const struct vor_domain *domain, const struct vor_run *run,
                            struct vor_error *err)
{
    double m[6] = {0}, values[3], vectors[3][3];
    vor_status status;

    if (domain->n < 4)
        return vor_fail(err, VOR_E_DEGENERATE, "the cloud has %zu distinct points, want at least 4",
                        domain->n);
    status = moments(m, domain, run, err);
    if (status != VOR_OK)
        return status;
    vor_eigen3(values, vectors, m);
    if (!(values[1] > VOR_ROUNDED2 * values[2]))
        return vor_fail(err, VOR_E_DEGENERATE,
                        "all %zu distinct points lie on one line, or too close to one line",
                        domain->n);
    return VOR_OK;
}

/* The rank of the largest distance that is believed: SPARSE_SHARE, or below the first gap. */
static size_t rank_below_gap(const float *far2, size_t n)
{
    size_t last = vor_quantile_rank(SPARSE_SHARE, n);

    for (size_t i = vor_quantile_rank(LONE_FROM, n); i < last; i++)
        if ((double)far2[i + 1] > LONE_GAP * LONE_GAP * (double)far2[i])
            return i;
    return last;
}

vor_status vor_domain_index(struct vor_domain *domain, const struct vor_run *run,
                            struct vor_error *err)
{
    vor_status status = vor_knn_build_sorted(&domain->knn, domain->xyz, domain->n, run, err);

    if (status == VOR_OK) {
        /* Sets sparse from a sample of points at equal steps along the order. */
        size_t n = domain->n < VOR_DOMAIN_SAMPLED ? domain->n : VOR_DOMAIN_SAMPLED;
        unsigned k = domain->n > VOR_PATCH_HEXAGON ? VOR_PATCH_HEXAGON + 1 : (unsigned)domain->n;
        float far2[VOR_DOMAIN_SAMPLED] = {0}; /* clang-analyzer cannot see that n >= 1 */

        for (size_t i = 0; i < n; i++) {
            size_t at = (size_t)((double)i / (double)n * (double)domain->n);
            uint32_t index[VOR_PATCH_HEXAGON + 1];
            float distance2[VOR_PATCH_HEXAGON + 1];

            vor_knn_search(domain->knn, &domain->xyz[3 * at], 1, k, index, distance2);
            far2[i] = distance2[k - 1];
        }
        vor_sort_floats(far2, n);
        domain->sparse = sqrt((double)far2[rank_below_gap(far2, n)]);
        domain->usual6 = sqrt((double)far2[n / 2]);
    }
    return status;
}

vor_status vor_domain_move(struct vor_domain *domain, float *xyz, const struct vor_run *run,
                           struct vor_error *err)
{
    vor_knn_free(domain->knn);
    vor_free(domain->memory, domain->xyz);
    domain->knn = NULL;
    domain->xyz = xyz;
    return vor_knn_build_sorted(&domain->knn, domain->xyz, domain->n, run, err);
}

vor_status vor_domain_add(struct vor_domain *domain, const float *xyz, const uint32_t *source,
                          size_t count, const struct vor_run *run, struct vor_error *err)
{
    struct vor_memory *memory = domain->memory;
    size_t before = domain->n, all = before + count;
    float *more = vor_realloc(memory, domain->xyz, all, 3 * sizeof *more), *copy = NULL;
    uint32_t *sources = vor_realloc(memory, domain->source, all, sizeof *sources), *from = NULL;
    uint32_t *order = vor_malloc(memory, all, sizeof *order);
    vor_status status = VOR_E_NOMEM;

    domain->xyz = more != NULL ? more : domain->xyz;
    domain->source = sources != NULL ? sources : domain->source;
    copy = vor_malloc(memory, all, 3 * sizeof *copy);
    from = vor_malloc(memory, all, sizeof *from);
    if (more == NULL || sources == NULL || order == NULL || copy == NULL || from == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", count);
    } else {
        memcpy(copy, domain->xyz, 3 * before * sizeof *copy);
        memcpy(from, domain->source, before * sizeof *from);
        memcpy(&copy[3 * before], xyz, 3 * count * sizeof *copy);
        memcpy(&from[before], source, count * sizeof *from);
        status = vor_morton_order(order, copy, all, run, err);
        domain->n = all;
        if (status == VOR_OK) {
            /* Replaces the points by those of `xyz` in an order. */
            for (size_t i = 0; i < domain->n; i++) {
                memcpy(&domain->xyz[3 * i], &copy[3 * (size_t)order[i]], 3 * sizeof *copy);
                domain->source[i] = from[order[i]];
            }
        }
    }
    VOR_FREE_ALL(memory, from, copy, order);
    vor_knn_free(domain->knn);
    domain->knn = NULL;
    return status == VOR_OK ? vor_domain_index(domain, run, err) : status;
}

vor_status vor_domain_init(struct vor_domain *out, const struct vor_cloud *in,
                           const struct vor_run *run, struct vor_error *err)
{
    struct vor_domain domain = {.memory = run->memory};
    struct vor_box box;
    vor_status status = vor_bounds(&box, in->xyz, in->n, run, err);

    if (status != VOR_OK)
        return status;
    vor_neighbors_fix(&domain.known.neighbors, VOR_NEIGHBORS_FEWEST);
    choose_frame(&domain, &box);
    status = sort_points(&domain, in, run, err);
    VOR_THEN(status, vor_domain_check(&domain, run, err));
    if (status == VOR_E_DEGENERATE)
        vor_remote_tell(in, err);
    VOR_THEN(status, vor_domain_index(&domain, run, err));
    if (status == VOR_OK)
        *out = domain;
    else
        vor_domain_free(&domain);
    return status;
}

vor_status vor_domain_continue(struct vor_domain *domain, const struct vor_cloud *in,
                               const struct vor_cloud *previous, struct vor_error *err)
{
    double middle[3];

    if (previous == NULL)
        return VOR_OK;
    for (int c = 0; c < 3; c++)
        middle[c] = in->origin[c] + domain->shift[c];
    return vor_previous_take(&domain->previous, previous, middle, domain->unit, domain->memory,
                             err);
}

void vor_domain_free(struct vor_domain *domain)
{
    vor_previous_free(&domain->previous);
    vor_tensors_free(&domain->tensors);
    vor_field_free(&domain->field);
    vor_graph_free(&domain->graph);
    vor_knn_free(domain->knn);
    VOR_FREE_ALL(domain->memory, domain->islands.member, domain->islands.first, domain->source,
                 domain->xyz);
    memset(&domain->islands, 0, sizeof domain->islands);
    domain->knn = NULL;
    domain->source = NULL;
    domain->xyz = NULL;
    domain->n = 0;
}
