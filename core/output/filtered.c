#include "core/output/filtered.h"

#include "core/base/stat.h"
#include "core/geom/surface.h"
#include "core/input/lists.h"
#include "core/input/neighbors.h"
#include "core/input/outliers.h"
#include "core/metrics/uniformity.h"
#include "core/output/order.h"
#include "core/output/output.h"
#include "core/output/sides.h"
#include "core/output/transfer.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { BLOCK = 1024 /* points of one task */ };

#define NONE UINT32_MAX

struct work {
    const struct vor_cloud *in;
    const struct vor_domain *domain;
    const struct vor_spec *spec;
    const struct vor_run *run;
    size_t n;                  /* points of the result */
    uint32_t *place;           /* for each point of the input: its point of the domain, or NONE */
    uint32_t *source;          /* for each point of the result: its point of the input */
    float *was;                /* n x 3: where that was, normalised */
    float *nearest;            /* n: its distance to the nearest other point of the result */
    float *normal;             /* n x 3, or NULL */
    struct vor_sides sides;    /* of these */
    const struct vor_knn *knn; /* over `was` */
    struct vor_sums *block;
};

static int has_filter(const struct vor_spec *spec, unsigned filter)
{
    return vor_list_has(spec->value[VOR_PARAM_FILTERS], filter);
}

/* Where point i of the result is, normalised. */
static const float *is_at(const struct work *work, size_t i)
{
    return &work->domain->xyz[3 * (size_t)work->place[work->source[i]]];
}

/* A domain of every point of the input, to find twins in. */
struct twins {
    struct work *work;
    struct vor_domain all;
};

static void join_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct twins *twins = ctx;
    const struct vor_domain *all = &twins->all;
    struct work *work = twins->work;
    float x[3], distance2;
    uint32_t index;

    if (work->place[i] != NONE)
        return;
    vor_domain_normalise(all, &work->in->xyz[3 * i], x);
    vor_knn_search(all->knn, x, 1, 1, &index, &distance2);
    if (all->source[index] != i && !(distance2 > 0))
        work->place[i] = work->place[all->source[index]];
}

/* Gives points that share the place of another one, which alone is in the domain, the same place
 * there. */
static vor_status join_twins(struct work *work, struct vor_error *err)
{
    struct twins twins = {.work = work};
    struct vor_outliers remote = {.memory = work->run->memory};
    vor_status status = vor_domain_init(&twins.all, work->in, work->run, err);

    if (status == VOR_E_DEGENERATE) /* and yet the input was taken: input/input.c */
        status = vor_outliers_remote(&remote, &twins.all, work->in, work->run, err);
    vor_outliers_free(&remote);
    if (status != VOR_OK)
        return status;
    if (twins.all.n < work->in->n)
        status = vor_run_rows(work->run, work->in->n, BLOCK, join_row, &twins, err);
    vor_domain_free(&twins.all);
    return status;
}

/* Finds the points of the input that are left, in their order. */
static vor_status find_points(struct work *work, struct vor_error *err)
{
    const struct vor_domain *domain = work->domain;
    size_t n = work->in->n;
    vor_status status = VOR_OK;

    work->place = vor_malloc(work->run->memory, n, sizeof *work->place);
    work->source = vor_malloc(work->run->memory, n, sizeof *work->source);
    if (work->place == NULL || work->source == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    for (size_t i = 0; i < n; i++)
        work->place[i] = NONE;
    for (size_t i = 0; i < domain->n; i++)
        work->place[domain->source[i]] = (uint32_t)i;
    if (domain->n < n && !has_filter(work->spec, VOR_FILTER_THIN))
        status = join_twins(work, err);
    for (size_t i = 0; i < n; i++)
        if (work->place[i] != NONE)
            work->source[work->n++] = (uint32_t)i;
    return status;
}

/* The normal of the surface around point i of the result. */
static void surface_normal(const struct work *work, size_t i, double normal[3])
{
    const struct vor_domain *domain = work->domain;
    const float *at = is_at(work, i);
    double x[3] = {(double)at[0], (double)at[1], (double)at[2]}, local[3];
    float near[3 * VOR_NEIGHBORS_MAX];
    struct vor_surface surface;

    (void)vor_lists_fit_at(&surface, near, domain, x,
                           vor_neighbors_at(&domain->known.neighbors, at));
    normal[0] = normal[1] = 0;
    normal[2] = 1;
    if (surface.kind == VOR_SURFACE_NONE)
        return;
    vor_surface_to_local(&surface, x, local);
    vor_surface_normal(&surface, local, normal);
}

static void normal_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct work *work = ctx;
    double fitted[3];

    surface_normal(work, i, fitted);
    vor_sides_normal(&work->normal[3 * i], &work->sides, is_at(work, i), work->source[i], fitted);
}

static vor_status make_normals(struct work *work, struct vor_error *err)
{
    struct vor_sides_of of = {work->in, work->domain, work->spec, work->n, 0};
    vor_status status;

    if (!vor_sides_asked(work->spec))
        return VOR_OK;
    work->normal = vor_malloc(work->run->memory, work->n, 3 * sizeof *work->normal);
    if (work->normal == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", work->n);
    status = vor_sides_find(&work->sides, &of, work->run, err);
    if (status != VOR_OK)
        return status;
    return vor_run_rows(work->run, work->n, BLOCK, normal_row, work, err);
}

/* Fills an empty cloud. */
static vor_status make_cloud(struct vor_cloud *out, struct work *work, struct vor_error *err)
{
    vor_status status = vor_cloud_resize(out, work->n, err);

    if (status != VOR_OK)
        return status;
    work->was = vor_malloc(work->run->memory, work->n, 3 * sizeof *work->was);
    if (work->was == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", work->n);
    if (work->in->exact != NULL) {
        out->exact = vor_malloc(out->memory, work->n, 3 * sizeof *out->exact);
        if (out->exact == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu points", work->n);
    }
    out->position_type = work->in->position_type;
    memcpy(out->origin, work->in->origin, sizeof out->origin);
    for (size_t i = 0; i < work->n; i++) {
        const float *from = &work->in->xyz[3 * (size_t)work->source[i]], *to = is_at(work, i);
        float *was = &work->was[3 * i];

        vor_domain_normalise(work->domain, from, was);
        for (size_t c = 0; c < 3; c++) {
            int is_moved = to[c] != was[c];
            float x = is_moved
                          ? (float)((double)to[c] * work->domain->unit + work->domain->shift[c])
                          : from[c];

            out->xyz[3 * i + c] = x;
            if (out->exact != NULL && work->in->exact != NULL)
                out->exact[3 * i + c] = is_moved ? out->origin[c] + (double)x
                                                 : work->in->exact[3 * (size_t)work->source[i] + c];
        }
    }
    status = make_normals(work, err);
    if (status != VOR_OK)
        return status;
    return vor_transfer_attributes(out, work->in, work->source, work->normal, work->spec, err);
}

/* Distances to the nearest other point. */
static vor_status find_nearest(struct work *work, struct vor_error *err)
{
    const struct vor_domain *domain = work->domain;
    float *own = vor_malloc(work->run->memory, domain->n, sizeof *own);
    unsigned char *held = vor_calloc(work->run->memory, domain->n, sizeof *held);
    vor_status status;

    work->nearest = vor_malloc(work->run->memory, work->n, sizeof *work->nearest);
    if (own == NULL || held == NULL || work->nearest == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", work->n);
    } else {
        status = vor_nearest_distances(own, domain->xyz, domain->n, domain->knn, work->run, err);
        if (status == VOR_OK) { /* 0 where points share a place */
            for (size_t i = 0; i < work->n; i++) {
                unsigned char *count = &held[work->place[work->source[i]]];

                *count = *count < 2 ? (unsigned char)(*count + 1) : 2;
            }
            for (size_t i = 0; i < work->n; i++) {
                uint32_t at = work->place[work->source[i]];

                work->nearest[i] = held[at] > 1 ? 0 : own[at];
            }
        }
    }
    VOR_FREE_ALL(work->run->memory, held, own);
    return status;
}

static void apart_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    struct vor_sums sums[2] = {{0}};

    for (size_t i = begin; i < end; i++) {
        uint32_t index;
        float distance2;

        vor_knn_search(work->domain->knn, &work->was[3 * i], 1, 1, &index, &distance2);
        vor_sums_add(&sums[0], sqrt((double)distance2), (double)distance2);
        vor_knn_search(work->knn, is_at(work, i), 1, 1, &index, &distance2);
        vor_sums_add(&sums[1], sqrt((double)distance2), (double)distance2);
    }
    memcpy(&work->block[2 * (begin / BLOCK)], sums, sizeof sums);
}

static struct vor_apart in_unit(const struct vor_sums *sums, size_t n, double unit)
{
    struct vor_stat stat = vor_sums_stat(sums, n);

    return (struct vor_apart){stat.mean * unit, stat.rms * unit, stat.max * unit, n};
}

/* Reports how far the result and the points that it was made of are from each other. */
static vor_status report_apart(struct vor_report *report, struct work *work, struct vor_error *err)
{
    struct vor_sums all[2] = {{0}};
    size_t blocks = vor_blocks_of(work->n, BLOCK);
    struct vor_knn *knn = NULL;
    vor_status status = vor_knn_build(&knn, work->was, work->n, work->run->memory, err);

    if (status != VOR_OK)
        return status;
    work->knn = knn;
    work->block = vor_malloc(work->run->memory, blocks, 2 * sizeof *work->block);
    if (work->block == NULL) {
        vor_knn_free(knn);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", work->n);
    }
    status = vor_run_for(work->run, work->n, BLOCK, apart_block, work, err);
    if (status == VOR_OK) {
        for (size_t b = 0; b < 2 * blocks; b++)
            vor_sums_merge(&all[b % 2], &work->block[b]);
        report->ref_to_out = in_unit(&all[0], work->n, work->domain->unit);
        report->out_to_ref = in_unit(&all[1], work->n, work->domain->unit);
    }
    vor_knn_free(knn);
    return status;
}

static vor_status reorder(struct vor_cloud *out, struct work *work, double spacing,
                          struct vor_error *err)
{
    uint32_t *order;
    vor_status status;

    if (work->spec->value[VOR_PARAM_ORDER] != VOR_ORDER_PROGRESSIVE)
        return VOR_OK;
    for (size_t i = 0; i < work->n; i++) /* `was` is not needed any more */
        memcpy(&work->was[3 * i], is_at(work, i), 3 * sizeof *work->was);
    order = vor_malloc(work->run->memory, work->n, sizeof *order);
    if (order == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", work->n);
    status = vor_order_progressive(order, work->was, work->n, spacing, work->run, err);
    VOR_THEN(status, vor_cloud_reorder(out, order, err));
    vor_free(work->run->memory, order);
    return status;
}

static vor_status make(struct vor_cloud *out, struct vor_report *report, struct work *work,
                       struct vor_error *err)
{
    struct vor_uniformity even;
    vor_status status = find_points(work, err);

    VOR_THEN(status, make_cloud(out, work, err));
    VOR_THEN(status, find_nearest(work, err));
    VOR_THEN(status, report_apart(report, work, err));
    if (status != VOR_OK)
        return status;
    vor_uniformity_from(&even, work->nearest, work->n);
    vor_output_report_uniformity(report, &even, work->domain->unit);
    vor_output_report_input(report, work->domain);
    report->points_in = work->in->n;
    report->points_out = work->n;
    vor_sides_report(report, &work->sides);
    if (work->n < work->in->n && !has_filter(work->spec, VOR_FILTER_THIN))
        report->outliers = work->in->n - work->n;
    return reorder(out, work, even.mean, err);
}

vor_status vor_output_filtered(struct vor_cloud *out, struct vor_report *report,
                               const struct vor_filtered *filtered, const struct vor_run *run,
                               struct vor_error *err)
{
    struct work work = {
        .in = filtered->in, .domain = filtered->domain, .spec = filtered->spec, .run = run};
    struct vor_cloud cloud;
    vor_status status;

    vor_cloud_init(&cloud, run->memory);
    status = make(&cloud, report, &work, err);
    if (status == VOR_OK)
        *out = cloud;
    else
        vor_cloud_free(&cloud);
    VOR_FREE_ALL(run->memory, work.block, work.nearest);
    vor_sides_free(&work.sides, run->memory);
    VOR_FREE_ALL(run->memory, work.normal, work.was, work.source, work.place);
    return status;
}
