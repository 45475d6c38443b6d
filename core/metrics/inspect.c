#include "core/metrics/inspect.h"

#include "core/base/stat.h"
#include "core/input/edges.h"
#include "core/input/lists.h"
#include "core/input/loops.h"
#include "core/metrics/uniformity.h"
#include "core/metrics/vcm.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    BLOCK = 16, /* places of one task */
    /* Places where noise is estimated, as many as VOR_NEIGHBORS_PLACES. At 256 / 512 / 1024 the
     * noise of eight spheres of 20,000 points, four times as large at one pole as at the other, is
     * told with a spread of 1.1 / 2.1 / 1.9 %, and means within 0.6 % of each other. */
    PLACES = 512,
    /* A component of fewer points than so many times those of a fit is small: as FITS in
     * input/islands.c, so that both documents call the same parts small. */
    SMALL = 2
};

void vor_inspect_cloud(struct vor_inspect *out, const struct vor_cloud *cloud)
{
    const char *word;
    size_t length =
        vor_parameter_choice(vor_parameter_info(VOR_PARAM_FORMAT), cloud->notes.format, &word);
    double x[3];

    (void)snprintf(out->format, sizeof out->format, "%.*s", (int)length, word);
    for (size_t i = 0; i < cloud->n; i++) {
        vor_cloud_position(cloud, i, x);
        for (int c = 0; c < 3; c++) {
            out->bounds.low[c] = i == 0 ? x[c] : fmin(out->bounds.low[c], x[c]);
            out->bounds.high[c] = i == 0 ? x[c] : fmax(out->bounds.high[c], x[c]);
        }
    }
    memcpy(out->origin, cloud->origin, sizeof out->origin);
    for (size_t i = 0; i < cloud->attribute_count; i++) {
        const struct vor_attribute *from = &cloud->attributes[i];
        struct vor_column *to = &out->attributes[out->attributes_count++];

        (void)snprintf(to->name, sizeof to->name, "%s", from->name);
        (void)snprintf(to->type, sizeof to->type, "%s", vor_type_name_sized(from->type));
        to->components = from->components;
    }
    out->points = cloud->n;
    out->invalid = cloud->notes.invalid;
}

static vor_status find_components(struct vor_inspect *out, const struct vor_graph *graph,
                                  const struct vor_run *run, struct vor_error *err)
{
    uint32_t *component = vor_malloc(run->memory, graph->n, sizeof *component), *size = NULL;
    vor_status status = VOR_E_NOMEM;
    size_t count = 0;

    if (component != NULL)
        status = vor_graph_components(component, &count, graph, err);
    if (status == VOR_OK)
        size = vor_calloc(run->memory, count, sizeof *size);
    if (component == NULL || (status == VOR_OK && size == NULL)) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", graph->n);
    } else if (status == VOR_OK) {
        out->components = count;
        for (size_t i = 0; i < graph->n; i++)
            size[component[i]]++;
        for (size_t c = 0; c < out->components; c++) {
            out->largest = size[c] > out->largest ? size[c] : out->largest;
            if (size[c] < SMALL * out->neighbors) {
                out->small++;
                out->small_points += size[c];
            }
        }
    }
    VOR_FREE_ALL(run->memory, size, component);
    return status;
}

static vor_status measure_spacing(struct vor_inspect *out, const struct vor_domain *domain,
                                  const struct vor_run *run, struct vor_error *err)
{
    float *nearest = vor_malloc(run->memory, domain->n, sizeof *nearest);
    double sum = 0;
    vor_status status;

    if (nearest == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    status = vor_nearest_distances(nearest, domain->xyz, domain->n, domain->knn, run, err);
    if (status == VOR_OK) {
        for (size_t i = 0; i < domain->n; i++)
            sum += (double)nearest[i];
        vor_sort_floats(nearest, domain->n);
        out->spacing = sum / (double)domain->n * domain->unit;
        out->spacing_p01 = vor_quantile(nearest, domain->n, 0.01) * domain->unit;
        out->spacing_p50 = vor_quantile(nearest, domain->n, 0.5) * domain->unit;
        out->spacing_p99 = vor_quantile(nearest, domain->n, 0.99) * domain->unit;
    }
    vor_free(run->memory, nearest);
    return status;
}

struct survey {
    const struct vor_domain *domain;
    size_t places;
    unsigned k;
    float off2[PLACES]; /* INFINITY where there is no surface */
};

static void survey_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct survey *survey = ctx;
    const struct vor_domain *domain = survey->domain;
    float near[3 * VOR_NEIGHBORS_MAX];
    struct vor_surface surface;

    for (size_t place = begin; place < end; place++) {
        size_t at = (size_t)(((double)place + 0.5) / (double)survey->places * (double)domain->n);
        const float *p = &domain->xyz[3 * at];
        double x[3] = {(double)p[0], (double)p[1], (double)p[2]};

        unsigned k = vor_lists_fit_at(&surface, near, domain, x, survey->k);

        survey->off2[place] = surface.kind == VOR_SURFACE_NONE
                                  ? INFINITY
                                  : (float)(surface.off2 * k / (k - VOR_QUADRIC_TERMS));
    }
}

/* Estimates the noise: a fit to k points leaves (k - 6) / k of its variance. */
static vor_status measure_noise(struct vor_inspect *out, const struct vor_domain *domain,
                                const struct vor_run *run, struct vor_error *err)
{
    struct survey survey = {.domain = domain,
                            .places = domain->n < PLACES ? domain->n : PLACES,
                            .k = domain->n < out->neighbors ? (unsigned)domain->n : out->neighbors};
    vor_status status;
    double off2;

    if (survey.k <= VOR_QUADRIC_TERMS)
        return VOR_OK;
    status = vor_run_for(run, survey.places, BLOCK, survey_block, &survey, err);
    if (status != VOR_OK)
        return status;
    vor_sort_floats(survey.off2, survey.places);
    off2 = (double)survey.off2[vor_quantile_rank(0.5, survey.places)];
    out->noise = off2 < INFINITY ? sqrt(off2) * domain->unit : 0;
    return VOR_OK;
}

static vor_status measure_border(struct vor_inspect *out, const struct vor_domain *domain,
                                 const struct vor_run *run, struct vor_error *err)
{
    struct vor_loops loops = {.count = 0};
    vor_status status = vor_loops_find(&loops, domain, run, err);

    for (size_t i = 0; i < loops.count; i++) {
        const struct vor_loop *loop = &loops.loop[i];
        struct vor_loop_told beyond = {.id = 0},
                             *told = i < VOR_LOOPS_TOLD ? &out->loops[i] : &beyond;

        told->length = loop->length * domain->unit;
        told->points = loop->count;
        for (int c = 0; c < 3; c++)
            told->centre[c] = out->origin[c] + (loop->centre[c] * domain->unit + domain->shift[c]);
        told->turns = loop->turns;
        told->kind = loop->turns >= VOR_LOOPS_HOLE_TURNS ? VOR_LOOP_HOLE : VOR_LOOP_RIM;
        told->why = loop->turns >= VOR_LOOPS_HOLE_TURNS    ? VOR_LOOP_AROUND
                    : loop->turns <= -VOR_LOOPS_HOLE_TURNS ? VOR_LOOP_WITHIN
                                                           : VOR_LOOP_ONE_SIDE;
        told->id = (uint32_t)i + 1;
        out->border_length += told->length;
        out->border_holes += told->kind == VOR_LOOP_HOLE;
    }
    out->border_loops = loops.count;
    out->border_open = loops.open;
    out->loops_count = (unsigned)(loops.count < VOR_LOOPS_TOLD ? loops.count : VOR_LOOPS_TOLD);
    vor_loops_free(&loops);
    return status;
}

/* The detector's edges and, if asked for, those by VCM. */
static vor_status find_edges(struct vor_inspect *out, const struct vor_domain *domain, int with_vcm,
                             const struct vor_run *run, struct vor_error *err)
{
    struct vor_edges edges = {.n = 0};
    unsigned char *flag = NULL;
    vor_status status = vor_edges_find(&edges, domain, run, err);

    out->edge_points = edges.flagged;
    out->edge_length = edges.length * domain->unit;
    out->has_vcm = with_vcm;
    if (status == VOR_OK && with_vcm) {
        flag = vor_calloc(run->memory, domain->n, sizeof *flag);
        status = flag != NULL ? vor_vcm_mark(flag, domain, run, err)
                              : vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
        for (size_t i = 0; flag != NULL && i < domain->n; i++) {
            out->vcm_points += flag[i];
            out->vcm_common += flag[i] & edges.flag[i];
        }
    }
    vor_free(run->memory, flag);
    vor_edges_free(&edges);
    return status;
}

vor_status vor_inspect_domain(struct vor_inspect *out, struct vor_domain *domain,
                              const struct vor_spec *spec, const struct vor_run *run,
                              struct vor_error *err)
{
    int plain = spec->value[VOR_PARAM_INTRINSIC] == VOR_INTRINSIC_NONE;
    vor_status status = vor_lists_make_any(domain, plain, run, err);
    size_t owns = 0;

    if (status != VOR_OK)
        return status;
    out->outliers = domain->known.outliers;
    out->distinct = domain->known.distinct;
    out->neighbors = domain->known.neighbors.usual;
    for (int c = 0; c < 3; c++)
        out->lattice[c] = domain->known.lattice.cell[c] * domain->unit;
    out->lattice_matters = domain->known.lattice.matters ? VOR_YES : VOR_NO;
    out->sheets = domain->known.sheets ? VOR_YES : VOR_NO;
    for (size_t i = 0; i < domain->n; i++)
        owns += domain->graph.own[i];
    out->own = (double)owns / (double)domain->n;
    status = measure_spacing(out, domain, run, err);
    VOR_THEN(status, measure_noise(out, domain, run, err));
    VOR_THEN(status, find_edges(out, domain, spec->value[VOR_PARAM_VCM] != 0, run, err));
    VOR_THEN(status, measure_border(out, domain, run, err));
    VOR_THEN(status, vor_graph_keep_mutual(&domain->graph, run, err));
    return status == VOR_OK ? find_components(out, &domain->graph, run, err) : status;
}
