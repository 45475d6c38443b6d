#include "core/input/thin.h"

#include "core/base/linalg.h"
#include "core/input/lists.h"
#include "core/input/neighbors.h"
#include "core/input/sheets.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 1 << 16, /* points of one task */
    MEANS_BLOCK = 1024,
    /* Points taken last that a point is compared with. On armadillo, 300,000 to 4,000, at 8 / 16 /
     * 32: rms distance to the true surface 0.59e-4 / 0.58e-4 / 0.58e-4, delta 0.0228 / 0.0238 /
     * 0.0238. */
    RECENT = 16,
    /* Times the points that are left: an input of fewer is not thinned, as is one of which more
     * than one in so many would stay. Half of the points is the least that repays a second index.
     */
    WORTHWHILE = 2,
    /* Means of the input's points for each one of the result. At 3 / 4 / as many as there are:
     * armadillo, 222,543 points with noise of 0.1 % of the diagonal to 22,000 by ear, rms distance
     * to the true surface 8.1e-4 / 8.1e-4 / 8.6e-4, CPU 0.9 / 1 / 1.8. */
    MEANS_EACH = 3,
    /* Neighbours whose distances say how far the filter thins: Lv 2022, Sec. 3.1. */
    THREE = 3
};

/* A domain on its way into a thinner one. */
struct thinning {
    const struct vor_domain *in;
    struct vor_domain *out;
    double gap2;
    size_t most;         /* more points than that: *out stays empty */
    unsigned char *kept; /* 1 for each point of `in` that is taken */
    size_t *first;       /* where those of each block go in `out` */
};

/* Takes a point that is a gap away from the last ones taken: points near in space are near in the
 * order. */
static void choose_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct thinning *thinning = ctx;
    const float *xyz = thinning->in->xyz;
    size_t recent[RECENT], count = 0;

    for (size_t i = begin; i < end; i++) {
        int keep = 1;

        for (size_t j = 0; j < count && j < RECENT && keep; j++)
            keep = vor_distance2f(&xyz[3 * i], &xyz[3 * recent[j]]) >= thinning->gap2;
        thinning->kept[i] = (unsigned char)keep;
        if (keep)
            recent[count++ % RECENT] = i;
    }
    thinning->first[begin / BLOCK] = count;
}

static void thin_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct thinning *thinning = ctx;
    const struct vor_domain *in = thinning->in;
    struct vor_domain *out = thinning->out;
    size_t at = thinning->first[begin / BLOCK];

    for (size_t i = begin; i < end; i++) {
        if (!thinning->kept[i])
            continue;
        memcpy(&out->xyz[3 * at], &in->xyz[3 * i], 3 * sizeof *out->xyz);
        out->source[at++] = in->source[i];
    }
}

static vor_status thin_points(struct thinning *thinning, const struct vor_run *run,
                              struct vor_error *err)
{
    struct vor_domain *out = thinning->out;
    size_t n = thinning->in->n;
    vor_status status;

    status = VOR_MAKE_ALL(run->memory, err, n, VOR_ARRAY(thinning->kept, n, 1),
                          VOR_ARRAY(thinning->first, vor_blocks_of(n, BLOCK), 1));
    if (status != VOR_OK)
        return status;
    status = vor_run_for(run, n, BLOCK, choose_block, thinning, err);
    if (status != VOR_OK)
        return status;
    out->n = vor_running_sum(thinning->first, vor_blocks_of(n, BLOCK));
    if (out->n > thinning->most) {
        out->n = 0;
        return VOR_OK;
    }
    status = VOR_MAKE_ALL(out->memory, err, n, VOR_ARRAY(out->xyz, out->n, 3),
                          VOR_ARRAY(out->source, out->n, 1));
    if (status != VOR_OK)
        return status;
    return vor_run_for(run, n, BLOCK, thin_block, thinning, err);
}

/* The points of a domain, and the kept one nearest to each. */
struct means {
    const struct vor_domain *in, *out;
    uint32_t *nearest; /* in->n */
    double *sum;       /* out->n x 4: of coordinates, and how many there are */
};

static void nearest_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct means *means = ctx;
    struct vor_knn_last last = {.k = 0};
    float distance2;

    for (size_t i = begin; i < end; i++) {
        const float *x = &means->in->xyz[3 * i];

        vor_knn_search_next(means->out->knn, &last, x, 1, &means->nearest[i], &distance2);
    }
}

static vor_status take_means(struct vor_domain *domain, const struct vor_domain *in,
                             const struct vor_run *run, struct vor_error *err)
{
    struct means means = {.in = in, .out = domain};
    vor_status status = vor_domain_index(domain, run, err);

    if (status != VOR_OK)
        return status;
    status = VOR_MAKE_ALL(run->memory, err, in->n, VOR_ARRAY(means.nearest, in->n, 1),
                          VOR_ZEROED(means.sum, domain->n, 4));
    if (status == VOR_OK) {
        status = vor_run_for(run, in->n, MEANS_BLOCK, nearest_block, &means, err);
        if (status == VOR_OK) {
            /* Moves each kept point to the mean of the points nearest to it. */
            for (size_t i = 0; i < means.in->n; i++) {
                double *sum = means.sum + 4 * (size_t)means.nearest[i];

                for (size_t c = 0; c < 3; c++)
                    sum[c] += (double)means.in->xyz[3 * i + c];
                sum[3]++;
            }
            for (size_t i = 0; i < means.out->n; i++)
                for (size_t c = 0; c < 3 && means.sum[4 * i + 3] > 0; c++)
                    domain->xyz[3 * i + c] = (float)(means.sum[4 * i + c] / means.sum[4 * i + 3]);
        }
    }
    VOR_FREE_ALL(run->memory, means.sum, means.nearest);
    vor_knn_free(domain->knn);
    domain->knn = NULL;
    return status;
}

/* Indexes what is left, and looks for sheets there if the whole shows none: on 80,000 points of two
 * squares four spacings apart a fit sees one square, on 15,000 of them it sees both. Lists suffice:
 * with them and layers, arma2 of 400,000 points (input/adjacency.c) to 10,000 takes 31 CPU s
 * instead of 25, rms distance to the true surface 1.5e-4 both. Whether lists pay is not asked
 * again: with lists made here, a cow of 200,000 points to 5,000 takes 2.0 CPU s instead of 1.1, rms
 * 0.95e-4 instead of 0.79e-4. */
static vor_status know(struct vor_domain *domain, const struct vor_run *run, struct vor_error *err)
{
    struct vor_conditioning *known = &domain->known;
    vor_status status = vor_domain_index(domain, run, err);

    if (status == VOR_OK && known->seek_sheets && !known->sheets && known->lists == VOR_LISTS_NONE)
        status = vor_sheets_find(known, domain, run, err);
    return status == VOR_OK ? vor_lists_make(domain, run, err) : status;
}

/* How a domain is thinned. */
struct how {
    double gap;
    size_t most; /* more points than that would stay: nothing is done */
    int means;   /* those that stay are means */
};

static vor_status thin(struct vor_domain *out, const struct vor_domain *in, struct how how,
                       const struct vor_run *run, struct vor_error *err)
{
    struct vor_domain domain = {.memory = run->memory, .unit = in->unit, .known = in->known};
    struct thinning thinning = {
        .in = in, .out = &domain, .gap2 = how.gap * how.gap, .most = how.most};
    vor_status status;

    memcpy(domain.shift, in->shift, sizeof domain.shift);
    status = thin_points(&thinning, run, err);
    VOR_FREE_ALL(run->memory, thinning.first, thinning.kept);
    if (status == VOR_OK && domain.n > 0 && how.means) {
        vor_neighbors_fewer(&domain.known.neighbors, (double)domain.n / (double)in->n);
        status = take_means(&domain, in, run, err);
    }
    if (status == VOR_OK && domain.n > 0)
        status = know(&domain, run, err);
    if (status == VOR_OK)
        *out = domain;
    else
        vor_domain_free(&domain);
    return status;
}

vor_status vor_domain_thin(struct vor_domain *out, const struct vor_domain *in, double gap,
                           const struct vor_run *run, struct vor_error *err)
{
    return thin(out, in, (struct how){gap, in->n / WORTHWHILE, 0}, run, err);
}

vor_status vor_domain_thin_for(struct vor_domain *out, const struct vor_domain *in, size_t n,
                               double area, const struct vor_run *run, struct vor_error *err)
{
    double wider = fmax(1, (double)in->known.neighbors.most / VOR_NEIGHBORS_FEWEST);
    double wanted = fmax(VOR_THIN_EACH * wider * (double)n, VOR_THIN_LEAST);

    memset(out, 0, sizeof *out);
    if ((double)in->n < WORTHWHILE * wanted || !(area > 0))
        return VOR_OK;
    return vor_domain_thin(out, in, sqrt(area / wanted), run, err);
}

vor_status vor_domain_means_for(struct vor_domain *out, const struct vor_domain *in, size_t n,
                                double area, const struct vor_run *run, struct vor_error *err)
{
    const struct vor_conditioning *known = &in->known;
    double wanted = fmax(MEANS_EACH * (double)n, VOR_THIN_LEAST);

    memset(out, 0, sizeof *out);
    if ((double)in->n < WORTHWHILE * wanted || !(area > 0) || known->sheets ||
        known->sheeted.count > 0 || known->lists != VOR_LISTS_NONE ||
        known->neighbors.usual <= VOR_NEIGHBORS_FEWEST)
        return VOR_OK;
    return thin(out, in, (struct how){sqrt(area / wanted), in->n / WORTHWHILE, 1}, run, err);
}

/* Distances of a domain's points to their nearest others. */
struct apart {
    const struct vor_domain *domain;
    double *sum; /* of each block */
};

static void apart_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct apart *apart = ctx;
    const struct vor_domain *domain = apart->domain;
    unsigned k = domain->n > THREE ? THREE + 1 : (unsigned)domain->n;
    struct vor_knn_last last = {.k = 0};
    double sum = 0;

    for (size_t i = begin; i < end; i++) {
        uint32_t index[THREE + 1];
        float distance2[THREE + 1];
        double own = 0;

        vor_knn_search_next(domain->knn, &last, &domain->xyz[3 * i], k, index, distance2);
        for (unsigned j = 1; j < k; j++)
            own += sqrt((double)distance2[j]);
        sum += own / THREE;
    }
    apart->sum[begin / BLOCK] = sum;
}

/* The mean distance of the points to their three nearest others. */
static vor_status mean_distance(double *out, const struct vor_domain *domain,
                                const struct vor_run *run, struct vor_error *err)
{
    size_t blocks = vor_blocks_of(domain->n, BLOCK);
    struct apart apart = {domain, vor_malloc(run->memory, blocks, sizeof *apart.sum)};
    vor_status status;

    *out = 0;
    if (apart.sum == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    status = vor_run_for(run, domain->n, BLOCK, apart_block, &apart, err);
    for (size_t b = 0; status == VOR_OK && b < blocks; b++)
        *out += apart.sum[b] / (double)domain->n;
    vor_free(run->memory, apart.sum);
    return status;
}

vor_status vor_thin_filter(struct vor_domain *domain, const struct vor_run *run,
                           struct vor_error *err)
{
    struct vor_domain thinned;
    double gap;
    vor_status status = mean_distance(&gap, domain, run, err);

    if (status == VOR_OK)
        status = thin(&thinned, domain, (struct how){gap, domain->n, 0}, run, err);
    if (status != VOR_OK)
        return status;
    if (thinned.n < VOR_NEIGHBORS_FEWEST) {
        vor_domain_free(&thinned);
        return VOR_OK;
    }
    vor_domain_free(domain);
    *domain = thinned;
    return VOR_OK;
}
