#include "core/input/lists.h"

#include "core/base/linalg.h"
#include "core/input/adjacency.h"
#include "core/input/regions.h"
#include "core/input/satellites.h"
#include "core/input/sheets.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 256,         /* points of one task */
    KEPT_SIZE = 1 << 11, /* points of a domain whose surfaces are kept, in 400 kB */
};

static vor_status make_local(struct vor_domain *domain, const struct vor_run *run,
                             struct vor_error *err)
{
    vor_status status = vor_adjacency_make(&domain->graph, domain, run, err);

    /* Where few places have sheets they are mostly the faces of thin parts, joined around a rim:
     * cow20k to 5,000 has delta 0.096 with regions, 0.076 without. */
    return status == VOR_OK && domain->known.parted && domain->known.sheets
               ? vor_regions_make(&domain->graph, domain, run, err)
               : status;
}

vor_status vor_lists_make(struct vor_domain *domain, const struct vor_run *run,
                          struct vor_error *err)
{
    if (domain->n == 0 || vor_graph_is(&domain->graph))
        return VOR_OK;
    switch (domain->known.lists) {
    case VOR_LISTS_LOCAL:
    case VOR_LISTS_FEW:
        return make_local(domain, run, err);
    case VOR_LISTS_SATELLITES:
        return vor_satellites_make(&domain->graph, domain, run, err);
    default:
        return VOR_OK;
    }
}

vor_status vor_lists_make_any(struct vor_domain *domain, int plain, const struct vor_run *run,
                              struct vor_error *err)
{
    unsigned most = domain->n > VOR_ADJACENT ? VOR_ADJACENT : (unsigned)domain->n - 1;
    vor_status status;

    if (vor_graph_is(&domain->graph))
        return VOR_OK;
    if (!plain && domain->n > VOR_ADJACENT)
        return vor_adjacency_make(&domain->graph, domain, run, err);
    status = vor_graph_init(&domain->graph, domain->n, most, run->memory, err);
    VOR_THEN(status, vor_graph_nearest(&domain->graph, domain->knn, domain->xyz, most, run, err));
    return status;
}

/* Copies the point at root and its neighbours, at most k in all; returns how many. */
static unsigned copy_list(float *near, const struct vor_domain *domain, uint32_t root, unsigned k)
{
    const struct vor_graph *graph = &domain->graph;
    const uint32_t *list = &graph->list[(size_t)root * graph->most];
    unsigned count = graph->count[root] + 1u < k ? graph->count[root] + 1u : k;

    memcpy(near, &domain->xyz[3 * (size_t)root], 3 * sizeof *near);
    vor_gather(&near[3], domain->xyz, list, count - 1);
    return count;
}

/* The point of index[0 .. k - 1] nearest to x that is on another sheet than the first; the first if
 * none is. */
static uint32_t other_sheet(const struct vor_domain *domain, const uint32_t *index, unsigned k,
                            const double x[3])
{
    float at[3] = {(float)x[0], (float)x[1], (float)x[2]};
    double best = INFINITY;
    uint32_t root = index[0], found = root;

    for (unsigned j = 1; j < k; j++) {
        double d2 = vor_distance2f(at, &domain->xyz[3 * (size_t)index[j]]);

        if (d2 < best && !vor_graph_has(&domain->graph, root, index[j]) &&
            !vor_graph_has(&domain->graph, index[j], root)) {
            best = d2;
            found = index[j];
        }
    }
    return found;
}

/* Whether two points' normals are along one line, as on both faces of a wall, and not beside a
 * crease. */
static int is_alike(const struct vor_graph *graph, uint32_t i, uint32_t j)
{
    double m[3], n[3], along;

    vor_to_doubles(m, &graph->normal[3 * (size_t)i]);
    vor_to_doubles(n, &graph->normal[3 * (size_t)j]);
    along = vor_dot(m, n);
    return along * along > VOR_NORMALS_ALIKE;
}

/* Distance of x from a surface, along its normal. */
static double off(const struct vor_surface *s, const double x[3])
{
    return s->kind == VOR_SURFACE_NONE ? INFINITY : fabs(vor_surface_above(s, x));
}

void vor_lists_points(float *near, const struct vor_domain *domain, uint32_t root, unsigned k)
{
    unsigned count = copy_list(near, domain, root, k);

    for (unsigned j = count; j < k; j++)
        memcpy(&near[3 * j], &near[3 * (j - count)], 3 * sizeof *near);
}

int vor_lists_are(const struct vor_domain *domain, unsigned k)
{
    return domain->known.lists != VOR_LISTS_NONE && vor_graph_is(&domain->graph) &&
           k <= VOR_ADJACENT;
}

/* Fits to the list of a point, or takes what is kept of that. */
static void fit_to(struct vor_surface *out, const struct vor_domain *domain, uint32_t root,
                   unsigned k)
{
    float near[3 * VOR_ADJACENT];

    if (k == VOR_ADJACENT && domain->graph.surface != NULL)
        *out = domain->graph.surface[root];
    else
        vor_surface_fit(out, near, copy_list(near, domain, root, k));
}

static void keep_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct vor_domain *domain = ctx;
    float near[3 * VOR_ADJACENT];

    vor_surface_fit(&domain->graph.surface[i], near,
                    copy_list(near, domain, (uint32_t)i, VOR_ADJACENT));
}

vor_status vor_lists_keep(struct vor_domain *domain, const struct vor_run *run,
                          struct vor_error *err)
{
    struct vor_graph *graph = &domain->graph;
    struct vor_surface *surface;

    if (!vor_lists_are(domain, VOR_ADJACENT) || graph->surface != NULL || domain->n > KEPT_SIZE)
        return VOR_OK;
    surface = vor_malloc(run->memory, domain->n, sizeof *surface);
    if (surface == NULL)
        return vor_fail(err, VOR_E_NOMEM, "surfaces of %zu points", domain->n);
    graph->surface = surface;
    return vor_run_rows(run, domain->n, BLOCK, keep_row, domain, err);
}

struct vor_lists_fitted vor_lists_fit(struct vor_surface *out, float *near,
                                      const struct vor_domain *domain, const double x[3],
                                      unsigned k, const uint32_t *index)
{
    struct vor_lists_fitted fitted = {.root = VOR_LISTS_NO_ROOT};
    struct vor_surface second;
    uint32_t other;

    if (!vor_lists_are(domain, k)) {
        fitted.sheet = vor_sheets_fit(out, near, domain, x, k, NULL);
        return fitted;
    }
    if (!domain->graph.own[index[0]]) {
        vor_surface_fit(out, near, k);
        if (!vor_layers_possible(out))
            return fitted;
        /* Those nearest to x may reach over to another sheet where those nearest to its input point
         * do not. Whatever the normals: points of a block 1.16 spacings off for 0.73. */
        fit_to(&second, domain, index[0], k);
        if (vor_layers_possible(&second) || second.off2 > VOR_LAYERS_POSSIBLE2 * out->off2 ||
            !is_alike(&domain->graph, index[0], other_sheet(domain, index, k, x)))
            return fitted;
    }
    fitted.sheet = 1;
    fitted.root = index[0];
    fit_to(out, domain, fitted.root, k);
    other = other_sheet(domain, index, k, x);
    if (other != fitted.root) {
        fit_to(&second, domain, other, k);
        if (off(&second, x) < off(out, x)) {
            *out = second;
            fitted.root = other;
        }
    }
    vor_lists_points(near, domain, fitted.root, k);
    return fitted;
}

unsigned vor_lists_fit_at(struct vor_surface *out, float *near, const struct vor_domain *domain,
                          const double x[3], unsigned k)
{
    const float at[3] = {(float)x[0], (float)x[1], (float)x[2]};
    uint32_t index[VOR_NEIGHBORS_MAX];
    float distance2[VOR_NEIGHBORS_MAX];

    k = k < domain->n ? k : (unsigned)domain->n;
    vor_knn_search(domain->knn, at, 1, k, index, distance2);
    vor_gather(near, domain->xyz, index, k);
    (void)vor_lists_fit(out, near, domain, x, k, index);
    return k;
}
