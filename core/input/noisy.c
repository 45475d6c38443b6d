#include "core/input/noisy.h"

#include "core/base/stat.h"
#include "core/geom/surface.h"
#include "core/input/edges.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 256,              /* points of one task */
    NEAREST = VOR_REFINED_TO, /* points of a surface */
};
/* Rms in spacings of the NEAREST nearest points over the surface fitted to them, which all but a
 * share of a region exceed where there is noise: walks follow that, and lists become aslant. That
 * quantile is 0 to 0.003 on clean shapes, also thin ones and vertices of models, 0.06 to 0.07 on
 * scans with noise of 0.15 spacings along the view, 0.19 with noise of 0.3 spacings. Points facing
 * inward on a knot, bumps, twigs with the latter: by walks 0.9, 1.1 and 3.4 %, without 0, 0.02 and
 * 0; at half and double NOISY the same, but at half scans of a wedge 0.7 instead of 0.5 %. */
#define NOISY 0.1

struct find {
    const struct vor_domain *domain;
    const struct vor_graph *graph;
    float *rough; /* n: rms of the nearest over their surface, in spacings */
    unsigned char *out;
};

static double roughness(const struct find *find, size_t i)
{
    const struct vor_graph *graph = find->graph;
    unsigned n = graph->count[i] < NEAREST - 1 ? graph->count[i] + 1u : NEAREST;
    float near[3 * NEAREST];
    struct vor_surface surface;

    memcpy(near, &find->domain->xyz[3 * i], 3 * sizeof *near);
    for (unsigned j = 1; j < n; j++)
        memcpy(&near[3 * j], &find->domain->xyz[3 * (size_t)graph->list[i * graph->most + j - 1]],
               3 * sizeof *near);
    vor_surface_fit(&surface, near, n);
    if (n <= VOR_QUADRIC_TERMS || surface.kind == VOR_SURFACE_NONE || !(surface.spacing > 0))
        return 0;
    return sqrt(surface.off2 * n / (n - VOR_QUADRIC_TERMS)) / surface.spacing;
}

static void rough_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct find *find = ctx;

    find->rough[i] = (float)roughness(find, i);
}

static void region_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct find *find = ctx;

    if (begin > 0 && end - begin < VOR_NOISY_REGION)
        return; /* a rest: of the region before it */
    if (find->domain->n - end < VOR_NOISY_REGION)
        end = find->domain->n;
    vor_sort_floats(&find->rough[begin], end - begin);
    memset(&find->out[begin],
           (double)find->rough[begin + vor_quantile_rank(VOR_EDGES_NOISE_QUANTILE, end - begin)] >
               NOISY,
           end - begin);
}

vor_status vor_noisy_find(unsigned char *out, const struct vor_domain *domain,
                          const struct vor_graph *graph, const struct vor_run *run,
                          struct vor_error *err)
{
    struct find find = {.domain = domain, .graph = graph, .out = out};
    vor_status status;

    find.rough = vor_malloc(run->memory, domain->n, sizeof *find.rough);
    if (find.rough == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    status = vor_run_rows(run, domain->n, BLOCK, rough_row, &find, err);
    VOR_THEN(status, vor_run_for(run, domain->n, VOR_NOISY_REGION, region_block, &find, err));
    vor_free(run->memory, find.rough);
    return status;
}
