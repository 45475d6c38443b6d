#include "core/input/mls.h"

#include "core/base/linalg.h"
#include "core/geom/layers.h"
#include "core/geom/surface.h"
#include "core/input/neighbors.h"
#include "core/input/sheets.h"

#include <math.h>
#include <string.h>

/* Figures are of bunny as in the header, with noise of 0.33 and 0.66, and how far points move
 * without noise (rms, in the same distances). */

enum {
    BLOCK = 256, /* points of one task */
    /* Each fits to what the one before left. At 1 / 2 / 4: 0.357, 0.373, 0.027 / 0.344, 0.342,
     * 0.031 / 0.336, 0.345, 0.038. */
    PASSES = 2,
    /* Fewest neighbours of a finer fit: twice the coefficients of a quadric. At 6 / 12 / 24:
     * 0.344, 0.342, 0.031 / the same / 0.342, 0.340, 0.041. */
    LEAST = VOR_REFINED_TO
};

/* What a quadric's six coefficients take of the sum of weights (1 - d^2)^3: six times the mean of
 * their squares over their mean on a uniform disc, 6 (1 / 7) / (1 / 4). */
#define TAKEN (VOR_QUADRIC_TERMS * 4.0 / 7)

/* VOR_FINER decides when half of the neighbours replace the wider fit. At 1.4 / 2 / 4: 0.348,
 * 0.346, 0.028 / 0.344, 0.342, 0.031 / 0.339, 0.338, 0.037. And when neighbours that fill space
 * replace the widest fit: igea, 300,000 points, a quarter moved in balls of 0.015 of its diagonal,
 * to 50,000: rms off it 5.8e-4 at each, cells at a border 0 / 0 / 3; without the widest fit 1.79e-3
 * and 1052. Close shells and thin walls, denoised, at 1.5 / 2 / infinity: 3 / 3 / 6 of 12 wrong;
 * without it 3. */

/* One pass over all points. */
struct pass {
    const struct vor_domain *domain;
    float *xyz; /* where they go */
};

/* The neighbours of one point, itself the first of them, and a surface that weighs them. */
struct hood {
    unsigned k;
    float near[3 * VOR_NEIGHBORS_MAX], weight[VOR_NEIGHBORS_MAX];
    double distance2[VOR_NEIGHBORS_MAX]; /* from the point */
    double far2;                         /* the largest of those that the last fit was to */
    struct vor_surface surface;
};

/* The nearest points of x, as listed; if they may lie on several sheets, those on its own. */
static void gather_nearest(struct hood *out, const struct vor_domain *domain, const float *x,
                           const uint32_t *index)
{
    double at[3] = {(double)x[0], (double)x[1], (double)x[2]};

    vor_gather(out->near, domain->xyz, index, out->k);
    if (domain->known.sheets || domain->known.sheeted.count > 0)
        (void)vor_sheets_fit(&out->surface, out->near, domain, at, out->k, NULL);
}

/* How many neighbours of a point are asked for. */
static unsigned wanted(const struct vor_domain *domain, size_t i)
{
    unsigned k =
        VOR_NEIGHBORS_WEIGHTED * vor_neighbors_at(&domain->known.neighbors, &domain->xyz[3 * i]);

    k = k < VOR_NEIGHBORS_MAX ? k : VOR_NEIGHBORS_MAX;
    return k < domain->n ? k : (unsigned)domain->n;
}

/* out->k is what is wanted, and as many are listed where there is no graph. */
static void gather(struct hood *out, const struct vor_domain *domain, size_t i,
                   const uint32_t *listed)
{
    const float *x = &domain->xyz[3 * i];
    uint32_t index[VOR_NEIGHBORS_MAX];

    if (vor_graph_is(&domain->graph)) {
        out->k = vor_graph_around(&domain->graph, (uint32_t)i, index, out->k);
        vor_gather(out->near, domain->xyz, index, out->k);
    } else
        gather_nearest(out, domain, x, listed);
    for (unsigned j = 0; j < out->k; j++)
        out->distance2[j] = vor_distance2f(&out->near[3 * j], x);
}

/* Fits to the first k neighbours with the weight (1 - d^2 / h^2)^3, h the largest distance of any
 * of them. Returns their variance about the surface; infinite if they have none. */
static double fit(struct hood *hood, unsigned k)
{
    double far2 = 0, total = 0;

    for (unsigned j = 0; j < k; j++)
        far2 = hood->distance2[j] > far2 ? hood->distance2[j] : far2; /* fmax is a call */
    hood->far2 = far2;
    for (unsigned j = 0; j < k; j++) {
        double inside = 1 - hood->distance2[j] / (1.001 * far2);

        hood->weight[j] = far2 > 0 ? (float)(inside * inside * inside) : 1;
        total += (double)hood->weight[j];
    }
    vor_surface_fit_weighted(&hood->surface, hood->near, hood->weight, k);
    if (hood->surface.kind != VOR_SURFACE_QUADRIC || !(total > TAKEN))
        return INFINITY;
    return hood->surface.off2 * total / (total - TAKEN);
}

/* Fits the widest surface around the point that no finer one is much better than. The last fit was
 * to all of hood->k, which have that variance about it. */
static void fit_best(struct hood *hood, double variance)
{
    struct vor_surface best = hood->surface;

    for (unsigned k = hood->k / 2; k >= LEAST; k /= 2) {
        double finer = fit(hood, k);

        if (!(VOR_FINER * finer < variance) || isinf(variance))
            break;
        variance = finer;
        best = hood->surface;
    }
    hood->surface = best;
}

/* Fits to as many neighbours as a fit can take where those of a point fill space: it lies in the
 * scatter around a surface. Returns 0 where it is not, or those, with that variance, are much
 * better. */
static int fit_scattered(struct hood *hood, double variance, const struct vor_domain *domain,
                         size_t i)
{
    struct hood wide;
    uint32_t index[VOR_NEIGHBORS_MAX];
    float distance2[VOR_NEIGHBORS_MAX];

    if (vor_graph_is(&domain->graph) || isinf(variance) ||
        !(variance > VOR_SURFACE_THICK * VOR_SURFACE_THICK * hood->far2))
        return 0;
    wide.k = domain->n < VOR_NEIGHBORS_MAX ? (unsigned)domain->n : VOR_NEIGHBORS_MAX;
    vor_knn_search_near(
        domain->knn,
        &(struct vor_knn_near){&domain->xyz[3 * i], 1, wide.k, NULL,
                               vor_knn_near_guess((float)hood->far2, hood->k, wide.k)},
        index, distance2);
    /* Around a point in the scatter more points lie for its reach squared: at 1 / 1.5 / 2 times as
     * many, igea as above has 5 / 14 / 759 cells at a border. */
    if (!(hood->far2 * wide.k > hood->k * (double)distance2[wide.k - 1]))
        return 0;
    gather(&wide, domain, i, index);
    if (!(fit(&wide, wide.k) <= VOR_FINER * variance))
        return 0;
    hood->surface = wide.surface;
    return 1;
}

static void project_point(const struct pass *pass, size_t i, unsigned k, const uint32_t *listed)
{
    const float *from = &pass->domain->xyz[3 * i];
    double x[3] = {(double)from[0], (double)from[1], (double)from[2]};
    double variance;
    struct hood hood;

    memset(&hood, 0, sizeof hood); /* analyzers cannot see that k >= 1 */
    hood.k = k;
    gather(&hood, pass->domain, i, listed);
    variance = fit(&hood, hood.k);
    if (!fit_scattered(&hood, variance, pass->domain, i))
        fit_best(&hood, variance);
    if (hood.surface.kind != VOR_SURFACE_NONE)
        vor_surface_put(&hood.surface, x);
    for (size_t c = 0; c < 3; c++)
        pass->xyz[3 * i + c] = (float)fmax(-1, fmin(1, x[c]));
}

/* Points in Morton order are near each other: a search for several finds the most that any wants.
 */
static void project_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct pass *pass = ctx;
    const struct vor_domain *domain = pass->domain;
    uint32_t index[VOR_KNN_NEAR_MAX * VOR_NEIGHBORS_MAX];
    float distance2[VOR_KNN_NEAR_MAX * VOR_NEIGHBORS_MAX];
    struct vor_knn_near near = {.k = 1};

    for (size_t i = begin, count; i < end; i += count) {
        unsigned k[VOR_KNN_NEAR_MAX], most = 0;

        count = end - i < VOR_KNN_NEAR_MAX ? end - i : VOR_KNN_NEAR_MAX;
        near.queries = &domain->xyz[3 * i];
        near.count = count;
        for (size_t j = 0; j < count; j++) {
            k[j] = wanted(domain, i + j);
            most = k[j] > most ? k[j] : most;
        }
        near.guess *= (float)most / (float)near.k;
        near.k = most;
        if (!vor_graph_is(&domain->graph))
            vor_knn_search_near(domain->knn, &near, index, distance2);
        for (size_t j = 0; j < count; j++)
            project_point(pass, i + j, k[j], &index[j * most]);
    }
}

static vor_status project(struct vor_domain *domain, const struct vor_run *run,
                          struct vor_error *err)
{
    struct pass pass = {domain, vor_malloc(run->memory, domain->n, 3 * sizeof *pass.xyz)};
    vor_status status;

    if (pass.xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    status = vor_run_for(run, domain->n, BLOCK, project_block, &pass, err);
    if (status != VOR_OK) {
        vor_free(run->memory, pass.xyz);
        return status;
    }
    return vor_domain_move(domain, pass.xyz, run, err);
}

vor_status vor_mls_project(struct vor_domain *domain, const struct vor_run *run,
                           struct vor_error *err)
{
    vor_status status = VOR_OK;

    for (int pass = 0; pass < PASSES && status == VOR_OK; pass++)
        status = project(domain, run, err);
    return status;
}
