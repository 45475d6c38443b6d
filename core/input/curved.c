#include "core/input/curved.h"

#include "core/base/bounds.h"
#include "core/geom/patch.h"
#include "core/input/lists.h"
#include "core/input/neighbors.h"
#include "core/input/thin.h"

#include <string.h>

enum {
    /* Most points that a curvature is taken of: more do not lie within CURVED_WITHIN. */
    CURVED_MOST = 64
};

/* Points of the result within two spacings: curvature is taken over so much of the surface, because
 * points cannot follow what bends within less. */
#define CURVED_WITHIN (4 * VOR_HEXAGON_WITHIN)

/* Length of the diagonal of the box around a domain's points. */
static vor_status diagonal(double *out, const struct vor_domain *domain, const struct vor_run *run,
                           struct vor_error *err)
{
    struct vor_box box;
    vor_status status = vor_bounds(&box, domain->xyz, domain->n, run, err);
    double sum = 0;

    if (status != VOR_OK)
        return status;
    for (int c = 0; c < 3; c++) {
        double side = (double)box.high[c] - (double)box.low[c];

        sum += side * side;
    }
    *out = sqrt(sum);
    return VOR_OK;
}

/* Estimates the area of the surface from the distances of some points, at equal steps along the
 * order, to their neighbours: each counts for the points of its step. */
static double estimate_area(const struct vor_domain *domain)
{
    size_t sampled = domain->n < VOR_DOMAIN_SAMPLED ? domain->n : VOR_DOMAIN_SAMPLED;
    unsigned k = domain->n > VOR_CURVED_LISTED ? VOR_CURVED_LISTED + 1 : (unsigned)domain->n;
    double sum = 0;

    for (size_t i = 0; i < sampled; i++) {
        size_t at = (size_t)((double)i / (double)sampled * (double)domain->n);
        uint32_t index[VOR_CURVED_LISTED + 1];
        float distance2[VOR_CURVED_LISTED + 1];

        vor_knn_search(domain->knn, &domain->xyz[3 * at], 1, k, index, distance2);
        sum += M_PI * (double)distance2[k - 1] / (k - 1);
    }
    return sum / (double)sampled * (double)domain->n;
}

vor_status vor_curved_init(struct vor_curved *out, const struct vor_domain *domain, size_t n,
                           double each, const struct vor_run *run, struct vor_error *err)
{
    struct vor_domain thin = {.n = 0};
    double area = estimate_area(domain), across = 0;
    double wider = fmax(1, (double)domain->known.neighbors.most / VOR_NEIGHBORS_FEWEST);
    vor_status status = VOR_OK;

    if (each > 0 && area > 0)
        status = vor_domain_thin(&thin, domain, sqrt(area / (each * wider * (double)n)), run, err);
    else if (!(each > 0))
        status = vor_domain_thin_for(&thin, domain, n, area, run, err);
    if (status == VOR_OK)
        status = diagonal(&across, thin.n > CURVED_MOST ? &thin : domain, run, err);
    if (status != VOR_OK) {
        vor_domain_free(&thin);
        return status;
    }
    out->thin = thin;
    out->domain = thin.n > CURVED_MOST ? &out->thin : domain;
    out->least = (unsigned)fmin(
        fmax(CURVED_WITHIN * (double)out->domain->n / (double)n, VOR_NEIGHBORS_FEWEST),
        CURVED_MOST);
    out->even = sqrt(area / (VOR_HEXAGON_HEIGHT * (double)n));
    out->floor = VOR_NEGLIGIBLE / across;
    return VOR_OK;
}

void vor_curved_free(struct vor_curved *curved)
{
    vor_domain_free(&curved->thin);
}

unsigned vor_curved_fit(struct vor_surface *out, float *near, const struct vor_curved *curved,
                        size_t i)
{
    const struct vor_domain *domain = curved->domain;
    const float *at = &domain->xyz[3 * i];
    double x[3] = {(double)at[0], (double)at[1], (double)at[2]};
    unsigned k = vor_neighbors_at(&domain->known.neighbors, at);

    if (k < curved->least && !vor_graph_is(&domain->graph))
        k = curved->least;
    return vor_lists_fit_at(out, near, domain, x, k);
}
