#include "core/input/density.h"

#include "core/base/count.h"
#include "core/base/quote.h"
#include "core/base/stat.h"
#include "core/geom/curvature.h"
#include "core/input/curved.h"
#include "core/input/edges.h"
#include "core/input/grading.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    BLOCK = 256, /* points of one task */
    QUOTED = 64, /* bytes of a name in a message */
    NAMES = 512, /* of all of them */
    /* Most points of the field for each one that a curvature is taken at: their lists have four
     * such then. At 1 / 3: igea34k to 3,000 delta 0.0293 / 0.0301, slope -0.235 / -0.235; CPU over
     * that of an even spread 1.8 / 1.6. */
    STEP_MOST = 3,
    /* Most times that the spacing is made to fit the number of points: grading changes it again. */
    FITTED = 6
};

/* Points of the field for each one of the result; more where fits take more neighbours than the
 * fewest; and curvatures, at least, where only some are taken. At 2 / 2.5 / 5, 200,000 points of
 * armadillo to 10,000 by curvature, mean of three seeds: delta 0.0208 / 0.0213 / 0.0227, CPU s 1.7
 * / 1.9 / 2.3, 1.5 for an even spread. */
#define EACH 2.0

static int is_none(const void *attribute, size_t i)
{
    double value = vor_attribute_scalar(attribute, i);

    return !(value >= 0 && isfinite(value));
}

static int is_positive(const void *attribute, size_t i)
{
    return vor_attribute_scalar(attribute, i) > 0;
}

static vor_status check_values(const struct vor_attribute *attribute, size_t n,
                               const struct vor_run *run, struct vor_error *err)
{
    size_t bad, first, positive = 0; /* cppcheck cannot see that it is set */
    vor_status status = vor_count(&bad, &first, n, is_none, attribute, run, err);

    if (status == VOR_OK && bad > 0)
        return vor_fail_param(err, VOR_E_DENSITY, "density",
                              "attribute %s is %g at point %zu, want 0 or more", attribute->name,
                              vor_attribute_scalar(attribute, first), first);
    VOR_THEN(status, vor_count(&positive, &first, n, is_positive, attribute, run, err));
    if (status != VOR_OK || positive > 0)
        return status;
    return vor_fail_param(
        err, VOR_E_DENSITY, "density",
        "attribute %s is 0 at all %zu points, want a value above 0 at one or more points",
        attribute->name, n);
}

/* Says which attributes could have been named. */
static vor_status refuse_name(const struct vor_cloud *in, const char *name, struct vor_error *err)
{
    const struct vor_attribute *there = vor_cloud_find_name(in, name);
    char quoted[QUOTED], names[NAMES] = "none";
    size_t at = 0;

    for (size_t i = 0; i < in->attribute_count && at + 2 * QUOTED < sizeof names; i++) {
        const struct vor_attribute *attribute = &in->attributes[i];

        if (attribute->components != 1)
            continue;
        vor_quote(quoted, sizeof quoted, attribute->name, strlen(attribute->name));
        at += (size_t)snprintf(names + at, sizeof names - at, "%s%s", at > 0 ? ", " : "", quoted);
    }
    vor_quote(quoted, sizeof quoted, name, strlen(name));
    if (there == NULL)
        return vor_fail_param(err, VOR_E_DENSITY, "density",
                              "the input has no attribute %s; its scalars are %s", quoted, names);
    return vor_fail_param(
        err, VOR_E_DENSITY, "density",
        "attribute %s has %u values per point, want 1; the input's scalars are %s", quoted,
        there->components, names);
}

vor_status vor_density_check(const struct vor_cloud *in, const struct vor_spec *spec,
                             const struct vor_run *run, struct vor_error *err)
{
    const char *name = vor_spec_name(spec, VOR_PARAM_DENSITY);
    const struct vor_attribute *attribute;

    if (name == NULL)
        return VOR_OK;
    attribute = vor_cloud_find_name(in, name);
    if (attribute == NULL || attribute->components != 1)
        return refuse_name(in, name, err);
    return check_values(attribute, in->n, run, err);
}

/* A field on its way. */
struct work {
    const struct vor_curved *curved; /* that the field's points are the places of */
    struct vor_field *field;
    const struct vor_attribute *attribute; /* NULL: curvature, or edges */
    const struct vor_domain *whole;        /* the input */
    struct vor_edges edges;                /* of the input; n is 0: curvature, or the attribute */
    unsigned char *on_edge; /* n: nearest of all to a point on an edge, where asked */
    unsigned step;          /* a curvature is taken at each so manieth point */
    double steepest;        /* largest change of the value over a length */
    struct vor_graph graph; /* the nearest points of each */
    double *rho, *next;     /* n: density; the same after a round */
    float *area;            /* n: share of the surface, in any unit */
    float *given;           /* n: values before grading */
};

static vor_status alloc_work(struct work *work, struct vor_memory *memory, struct vor_error *err)
{
    struct vor_field *field = work->field;
    size_t n = field->n;

    field->memory = memory;
    if (VOR_MAKE_ALL(memory, err, n, VOR_ARRAY(field->xyz, n, 3), VOR_ARRAY(field->value, n, 1),
                     VOR_ARRAY(work->rho, n, 1), VOR_ARRAY(work->next, n, 1),
                     VOR_ARRAY(work->area, n, 1), VOR_ARRAY(work->given, n, 1)) != VOR_OK)
        return VOR_E_NOMEM;
    memcpy(field->xyz, work->curved->domain->xyz, 3 * n * sizeof *field->xyz);
    return vor_graph_init(&work->graph, n,
                          n > VOR_CURVED_LISTED ? VOR_CURVED_LISTED : (unsigned)n - 1, memory, err);
}

/* Of a point that no curvature was taken at. */
#define UNKNOWN (-1.0)

/* Density at point i from the bend of the surface fitted around it. */
static double curvature_at(const struct work *work, size_t i)
{
    double kappa[2], floor = work->curved->floor;
    float near[3 * VOR_NEIGHBORS_MAX];
    struct vor_surface surface;
    unsigned k = vor_curved_fit(&surface, near, work->curved, i);

    vor_curvature_at(kappa, &surface, near, k);
    return fmax(fabs(kappa[0]), floor) + fmax(fabs(kappa[1]), floor);
}

/* Whether a curvature is taken at point i: at each so manieth, and at one that has none of these
 * among its neighbours. */
static int is_taken(const struct work *work, size_t i)
{
    const struct vor_graph *graph = &work->graph;
    int has_none = 1;

    for (unsigned j = 0; j < graph->count[i] && has_none; j++)
        has_none = graph->list[i * graph->most + j] % work->step != 0;
    return i % work->step == 0 || has_none;
}

/* Density of a point, UNKNOWN where no curvature is taken, and its share of the surface. */
static void density_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_graph *graph = &work->graph;
    unsigned count = graph->count[i];
    const float *xyz = work->field->xyz;
    double far = sqrt(
        vor_distance2f(&xyz[3 * i], &xyz[3 * (size_t)graph->list[i * graph->most + count - 1]]));

    work->area[i] = (float)(M_PI * far * far / count);
    if (work->attribute != NULL)
        work->rho[i] = vor_attribute_scalar(work->attribute, work->curved->domain->source[i]);
    else if (work->edges.n > 0)
        work->rho[i] = work->on_edge[i];
    else
        work->rho[i] = is_taken(work, i) ? curvature_at(work, i) : UNKNOWN;
}

/* Mean of each density and those of its neighbours, as far as they are known. */
static void smooth_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_graph *graph = &work->graph;
    double sum = work->rho[i] >= 0 ? work->rho[i] : 0, count = work->rho[i] >= 0;

    for (unsigned j = 0; j < graph->count[i]; j++) {
        double rho = work->rho[graph->list[i * graph->most + j]];

        sum += rho >= 0 ? rho : 0;
        count += rho >= 0;
    }
    work->next[i] = sum / count;
}

static vor_status find_densities(struct work *work, const struct vor_run *run,
                                 struct vor_error *err)
{
    size_t n = work->field->n;
    vor_status status = vor_run_rows(run, n, BLOCK, density_row, work, err);

    /* Curvatures are evened out among neighbours, once. Twice, armadillo, 1,000,000 to 20,000:
     * delta 0.0208 for 0.0223, slope -0.2444 for -0.2428, but span of the density followed 5.2
     * for 5.8. */
    if (status == VOR_OK && work->attribute == NULL && work->edges.n == 0) { /* by curvature */
        double *before = work->rho;

        status = vor_run_rows(run, n, BLOCK, smooth_row, work, err);
        work->rho = work->next;
        work->next = before;
    }
    return status;
}

/* The highest density that is told apart, of `count` sorted ones that are not 0: where they span
 * more than `most`, as many are cut off at the top as at the bottom. */
static double highest(const double *sorted, size_t count, double most)
{
    size_t cut = 0;

    while (cut < count / 2 && sorted[count - 1 - cut] > most * sorted[cut])
        cut++;
    return count > 0 ? sorted[count - 1 - cut] : 1;
}

/* Turns densities into relative spacings, at most `contrast` apart. */
static void take_contrast(struct work *work, double contrast)
{
    size_t n = work->field->n, count = 0;
    double most = contrast * contrast * contrast * contrast, high;

    for (size_t i = 0; i < n; i++)
        if (work->rho[i] > 0)
            work->next[count++] = work->rho[i];
    vor_sort_doubles(work->next, count);
    high = highest(work->next, count, most);
    for (size_t i = 0; i < n; i++) {
        double rho = fmin(fmax(work->rho[i] / high, 1 / most), 1);

        work->given[i] = (float)(1 / sqrt(sqrt(rho)));
    }
}

/* A point's density and its share of the surface. */
struct share {
    double rho, area;
};

static int lower_first(const void *a, const void *b)
{
    const struct share *x = a, *y = b;
    int order = (x->rho > y->rho) - (x->rho < y->rho);

    return order != 0 ? order : (x->area > y->area) - (x->area < y->area);
}

/* The lowest density of each group but the first, so that all have the same share of the surface.
 */
static vor_status find_bounds(double *bound, unsigned groups, const struct work *work,
                              const struct vor_run *run, struct vor_error *err)
{
    size_t n = work->field->n;
    struct share *share = vor_malloc(run->memory, n, sizeof *share);
    double total = 0, below = 0;
    unsigned group = 1;

    if (share == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    for (size_t i = 0; i < n; i++) {
        share[i] = (struct share){work->rho[i], (double)work->area[i]};
        total += share[i].area;
    }
    qsort(share, n, sizeof *share, lower_first);
    for (size_t i = 0; i < n; i++) {
        for (; group < groups && below >= group * total / groups; group++)
            bound[group] = share[i].rho;
        below += share[i].area;
    }
    for (; group < groups; group++)
        bound[group] = share[n - 1].rho;
    vor_free(run->memory, share);
    return VOR_OK;
}

/* Turns densities into relative spacings, one for each group. If contrast is less than the ratio of
 * the paper's, their distances from 1 shrink. */
static vor_status take_groups(struct work *work, double asked_groups, double contrast,
                              const struct vor_run *run, struct vor_error *err)
{
    static const double of3[] = {VOR_GROUPS_OF_3}, of5[] = {VOR_GROUPS_OF_5};
    int five = asked_groups == VOR_GROUPS_5;
    const double *spacing = five ? of5 : of3;
    unsigned last = (unsigned)((five ? sizeof of5 : sizeof of3) / sizeof *of5) - 1;
    double bound[sizeof of5 / sizeof *of5] = {0}; /* clang-analyzer cannot see that all are set */
    double share;
    vor_status status = find_bounds(bound, last + 1, work, run, err);

    share = fmin((contrast - 1) / (spacing[0] - 1 + contrast * (1 - spacing[last])), 1);
    for (size_t i = 0; i < work->field->n && status == VOR_OK; i++) {
        unsigned group = 0;

        while (group < last && work->rho[i] >= bound[group + 1])
            group++;
        work->given[i] = (float)(1 + share * (spacing[group] - 1));
    }
    return status;
}

/* How many points the values ask for over how many there are: the mean of their power -2 over the
 * area. */
static double asked(const struct work *work)
{
    double sum = 0, area = 0;

    for (size_t i = 0; i < work->field->n; i++) {
        double value = (double)work->field->value[i];

        sum += (double)work->area[i] / (value * value);
        area += (double)work->area[i];
    }
    return sum / area;
}

/* Sets the values so that they are graded and ask for as many points as there are. */
static vor_status fit_values(struct work *work, const struct vor_grading *grading,
                             const struct vor_run *run, struct vor_error *err)
{
    struct vor_field *field = work->field;
    double scale;

    memcpy(field->value, work->given, field->n * sizeof *field->value);
    scale = sqrt(asked(work));
    for (int round = 0; round < FITTED; round++) {
        vor_status status;
        double over;

        for (size_t i = 0; i < field->n; i++)
            field->value[i] = (float)(scale * (double)work->given[i]);
        status = vor_grading_apply(grading, field->value, work->steepest, run, err);
        if (status != VOR_OK)
            return status;
        over = asked(work);
        if (fabs(over - 1) <= VOR_NEGLIGIBLE || vor_run_is_late(run))
            break;
        scale *= sqrt(over);
    }
    return VOR_OK;
}

/* Grades the field. Lists and densities have served, and make room. */
static vor_status grade(struct work *work, const struct vor_run *run, struct vor_error *err)
{
    struct vor_grading grading;
    vor_status status;

    VOR_FREE_ALL(run->memory, work->next, work->rho);
    work->next = work->rho = NULL;
    status = vor_grading_init(&grading, &work->graph, work->field->xyz, err);
    vor_graph_free(&work->graph);
    if (status != VOR_OK)
        return status;
    status = fit_values(work, &grading, run, err);
    vor_grading_free(&grading);
    return status;
}

/* Notes the range of the values, and the span of the densities they stand for. They take the room
 * of those given. */
static void note_range(struct work *work)
{
    struct vor_field *field = work->field;
    double low, high;

    memcpy(work->given, field->value, field->n * sizeof *field->value);
    vor_sort_floats(work->given, field->n);
    field->least = (double)work->given[0];
    field->most = (double)work->given[field->n - 1];
    low = vor_quantile(work->given, field->n, 0.05);
    high = vor_quantile(work->given, field->n, 0.95);
    field->span = high / low * (high / low) * (high / low) * (high / low);
}

/* Marks the points of the field nearest to those of the input that lie on edges. Edges are found in
 * the input, as inspect does: in a few points of it bends would be taken for them. */
static vor_status mark_edges(struct work *work, const struct vor_run *run, struct vor_error *err)
{
    size_t n = work->field->n;

    if (work->edges.n == 0)
        return VOR_OK;
    work->on_edge = vor_malloc(run->memory, n, 1);
    if (work->on_edge == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    memset(work->on_edge, 0, n);
    for (size_t i = 0; i < work->edges.n; i++) {
        uint32_t nearest;
        float distance2;

        if (!work->edges.flag[i])
            continue;
        vor_knn_search(work->field->knn, &work->whole->xyz[3 * i], 1, 1, &nearest, &distance2);
        work->on_edge[nearest] = 1;
    }
    return VOR_OK;
}

/* Makes the densities of edges those of the distance to the nearest one along the points. */
static vor_status measure_edges(struct work *work, const struct vor_run *run, struct vor_error *err)
{
    size_t n = work->field->n;
    struct vor_grading grading;
    vor_status status = vor_grading_init(&grading, &work->graph, work->field->xyz, err);

    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < n; i++)
        work->given[i] = work->on_edge[i] ? 0 : INFINITY;
    status = vor_grading_apply(&grading, work->given, 1, run, err);
    for (size_t i = 0; i < n; i++)
        work->rho[i] = -(double)work->given[i];
    vor_grading_free(&grading);
    return status;
}

/* Fills the field, of which n and even are set. */
static vor_status fill(struct work *work, const struct vor_spec *spec, const struct vor_run *run,
                       struct vor_error *err)
{
    struct vor_field *field = work->field;
    double groups = spec->value[VOR_PARAM_GROUPS];
    vor_status status = alloc_work(work, run->memory, err);

    VOR_THEN(status, vor_knn_build_sorted(&field->knn, field->xyz, field->n, run, err));
    VOR_THEN(status,
             vor_graph_nearest(&work->graph, field->knn, field->xyz, work->graph.most, run, err));
    VOR_THEN(status, mark_edges(work, run, err));
    if (status != VOR_OK)
        return status;
    work->steepest = spec->value[VOR_PARAM_GRADING] / field->even;
    status = find_densities(work, run, err);
    if (status != VOR_OK)
        return status;
    if (groups == VOR_GROUPS_NONE)
        take_contrast(work, spec->value[VOR_PARAM_CONTRAST]);
    else if (work->edges.n > 0)
        status = measure_edges(work, run, err);
    if (status == VOR_OK && groups != VOR_GROUPS_NONE)
        status = take_groups(work, groups, spec->value[VOR_PARAM_CONTRAST], run, err);
    VOR_THEN(status, grade(work, run, err));
    if (status == VOR_OK)
        note_range(work);
    return status;
}

/* Sets what the density is taken of. */
static vor_status choose(struct work *work, const struct vor_cloud *in, const struct vor_spec *spec,
                         const struct vor_run *run, struct vor_error *err)
{
    double density = spec->value[VOR_PARAM_DENSITY];
    vor_status status;

    if (density == VOR_DENSITY_ATTRIBUTE)
        work->attribute = vor_cloud_find_name(in, vor_spec_name(spec, VOR_PARAM_DENSITY));
    if (density != VOR_DENSITY_EDGES)
        return VOR_OK;
    status = vor_edges_find(&work->edges, work->whole, run, err);
    if (status == VOR_OK && work->edges.flagged == 0)
        status = vor_fail_param(err, VOR_E_DENSITY, "density",
                                "density=edges needs sharp edges, but none of the input's %zu "
                                "points lies on one: use uniform, curvature or attribute:NAME",
                                in->n);
    return status;
}

vor_status vor_density_make(struct vor_domain *domain, const struct vor_cloud *in, size_t n,
                            const struct vor_spec *spec, const struct vor_run *run,
                            struct vor_error *err)
{
    struct vor_curved curved;
    struct vor_field field = {.n = 0};
    struct work work = {.curved = &curved, .field = &field, .whole = domain};
    vor_status status;

    if (spec->value[VOR_PARAM_DENSITY] == VOR_DENSITY_UNIFORM)
        return VOR_OK;
    status = vor_curved_init(&curved, domain, n, EACH, run, err);
    if (status != VOR_OK)
        return status;
    field.even = curved.even;
    field.n = curved.domain->n;
    work.step = (unsigned)fmin(fmax((double)field.n / (EACH * (double)n), 1), STEP_MOST);
    status = choose(&work, in, spec, run, err);
    VOR_THEN(status, fill(&work, spec, run, err));
    vor_free(run->memory, work.on_edge);
    vor_edges_free(&work.edges);
    vor_graph_free(&work.graph);
    VOR_FREE_ALL(run->memory, work.given, work.area, work.next, work.rho);
    vor_curved_free(&curved);
    if (status != VOR_OK) {
        vor_field_free(&field);
        return status;
    }
    domain->field = field;
    return VOR_OK;
}
