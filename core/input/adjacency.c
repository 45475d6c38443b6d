#include "core/input/adjacency.h"

#include "core/base/linalg.h"
#include "core/geom/layers.h"
#include "core/geom/surface.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 256,             /* points of one task */
    FLAT = 9,                /* points of a normal */
    WIDE = 3 * VOR_ADJACENT, /* points that a walk may reach */
    FEWEST = 10              /* points that a walk must reach */
};

/* Least cosine between the normals of two points that are joined. */
static const double COS = 0.6;
/* Largest sine between an edge and the tangent plane halfway along it. */
static const double ARC = 0.35;
/* Longest walk to a point, in straight distances to it. */
static const double STRETCH = 1.5;
/* Longest edge, in spacings. */
static const double REACH = 2.2;
/* A walk's points are used if they lie off their fit by less than this much of what the nearest
 * points do: a ratio of squares. */
static const double BETTER = 0.5;

/* A plane through a point's nearest. */
struct plane {
    float middle[3], normal[3], flatness;
};

struct make {
    const struct vor_domain *domain;
    struct vor_graph *graph;
    struct plane *plane;
};

static void search(const struct vor_domain *domain, const float *x, unsigned k, uint32_t *index,
                   float *distance2)
{
    vor_knn_search(domain->knn, x, 1, k, index, distance2);
}

static void fit_plane(struct plane *out, const struct vor_domain *domain, const uint32_t *index,
                      unsigned k)
{
    double mean[3] = {0}, m[6] = {0}, values[3], vectors[3][3], total;

    for (unsigned j = 0; j < k; j++)
        for (unsigned c = 0; c < 3; c++)
            mean[c] += (double)domain->xyz[3 * (size_t)index[j] + c] / k;
    for (unsigned j = 0; j < k; j++) {
        const float *p = &domain->xyz[3 * (size_t)index[j]];
        double x = (double)p[0] - mean[0], y = (double)p[1] - mean[1], z = (double)p[2] - mean[2];

        m[0] += x * x;
        m[1] += x * y;
        m[2] += x * z;
        m[3] += y * y;
        m[4] += y * z;
        m[5] += z * z;
    }
    vor_eigen3(values, vectors, m);
    total = values[0] + values[1] + values[2];
    for (unsigned c = 0; c < 3; c++) {
        out->middle[c] = (float)mean[c];
        out->normal[c] = (float)vectors[0][c];
    }
    out->flatness = (float)(total > 0 ? values[0] / total : 1);
}

static void nearest_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct make *make = ctx;
    struct vor_graph *graph = make->graph;
    unsigned k = graph->most + 1;
    uint32_t index[VOR_ADJACENT + 1];
    float distance2[VOR_ADJACENT + 1];

    (void)worker;
    for (size_t i = begin; i < end; i++) {
        unsigned taken = 0;

        search(make->domain, &make->domain->xyz[3 * i], k, index, distance2);
        for (unsigned j = 0; j < k && taken < graph->most; j++)
            if (index[j] != i)
                graph->list[i * graph->most + taken++] = index[j];
        graph->count[i] = (unsigned char)taken;
        fit_plane(&make->plane[i], make->domain, index, k < FLAT ? k : FLAT);
    }
}

/* Each point takes the plane, of its own and its neighbours', that is flattest and nearest. */
static void plane_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct make *make = ctx;
    struct vor_graph *graph = make->graph;
    const float *xyz = make->domain->xyz;

    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const uint32_t *list = &graph->list[i * graph->most];
        unsigned last = graph->count[i] < FLAT - 1 ? graph->count[i] : FLAT - 1;
        double h2 = vor_distance2f(&xyz[3 * i], &xyz[3 * (size_t)list[last - 1]]), best = 0;
        const struct plane *take = &make->plane[i];

        for (unsigned j = 0; j <= last; j++) {
            const struct plane *plane = &make->plane[j == 0 ? i : list[j - 1]];
            double height = 0, cost;

            for (unsigned c = 0; c < 3; c++)
                height +=
                    ((double)xyz[3 * i + c] - (double)plane->middle[c]) * (double)plane->normal[c];
            cost = (double)plane->flatness + height * height / h2;
            if (j == 0)
                best = 0.7 * cost;
            else if (cost < best) {
                best = cost;
                take = plane;
            }
        }
        memcpy(&graph->normal[3 * i], take->normal, sizeof take->normal);
    }
}

/* A walk from the first of `most` points, which are the nearest of it. */
struct walk {
    unsigned most;
    uint32_t index[WIDE];
    float distance2[WIDE];
    double far[WIDE];
    unsigned char done[WIDE], reached[WIDE];
};

static int edge(const struct make *make, uint32_t a, uint32_t b, double reach, double *length)
{
    const float *p = &make->domain->xyz[3 * (size_t)a], *q = &make->domain->xyz[3 * (size_t)b];
    const float *m = &make->graph->normal[3 * (size_t)a], *n = &make->graph->normal[3 * (size_t)b];
    double l2 = 0, cosine = 0, along = 0, middle2 = 0, sign;

    for (int c = 0; c < 3; c++) {
        double d = (double)q[c] - (double)p[c];

        l2 += d * d;
        cosine += (double)m[c] * (double)n[c];
    }
    *length = sqrt(l2);
    if (*length > reach || fabs(cosine) < COS)
        return 0;
    sign = cosine < 0 ? -1 : 1;
    for (int c = 0; c < 3; c++) {
        double middle = (double)m[c] + sign * (double)n[c];

        along += middle * ((double)q[c] - (double)p[c]);
        middle2 += middle * middle;
    }
    return fabs(along) <= ARC * sqrt(middle2) * *length;
}

static void walk(struct walk *w, const struct make *make)
{
    double spacing = sqrt((double)w->distance2[w->most - 1] * 3.14159265358979 / w->most);
    double reach = REACH * spacing;

    for (unsigned j = 0; j < w->most; j++) {
        w->far[j] = INFINITY;
        w->done[j] = w->reached[j] = 0;
    }
    w->far[0] = 0;
    for (;;) {
        unsigned u = w->most;

        for (unsigned j = 0; j < w->most; j++)
            if (!w->done[j] && w->far[j] < INFINITY && (u == w->most || w->far[j] < w->far[u]))
                u = j;
        if (u == w->most)
            return;
        w->done[u] = 1;
        if (w->far[u] <= STRETCH * sqrt((double)w->distance2[u]) + 1e-12)
            w->reached[u] = 1;
        for (unsigned j = 0; j < w->most; j++) {
            double length;

            if (!w->done[j] && edge(make, w->index[u], w->index[j], reach, &length) &&
                w->far[u] + length < w->far[j])
                w->far[j] = w->far[u] + length;
        }
    }
}

static unsigned take(const struct make *make, const struct walk *w, unsigned k, uint32_t *index,
                     float *near)
{
    unsigned taken = 0;

    for (unsigned j = 0; j < w->most && taken < k; j++) {
        if (!w->reached[j])
            continue;
        index[taken] = w->index[j];
        memcpy(&near[3 * taken++], &make->domain->xyz[3 * (size_t)w->index[j]], 3 * sizeof *near);
    }
    return taken;
}

static void use(struct vor_graph *graph, size_t i, const uint32_t *index, unsigned n)
{
    unsigned taken = 0;

    for (unsigned j = 0; j < n && taken < graph->most; j++)
        if (index[j] != i)
            graph->list[i * graph->most + taken++] = index[j];
    graph->count[i] = (unsigned char)taken;
    graph->own[i] = 1;
}

/* Fits a point and its nearest, as many as the lists have. */
static void fit_nearest(struct vor_surface *out, const struct make *make, size_t i)
{
    const struct vor_graph *graph = make->graph;
    const float *xyz = make->domain->xyz;
    unsigned k = graph->count[i] < VOR_ADJACENT - 1 ? graph->count[i] : VOR_ADJACENT - 1;
    float near[3 * VOR_ADJACENT];

    memcpy(near, &xyz[3 * i], 3 * sizeof *near);
    for (unsigned j = 0; j < k; j++)
        memcpy(&near[3 * (j + 1)], &xyz[3 * (size_t)graph->list[i * graph->most + j]],
               3 * sizeof *near);
    vor_surface_fit(out, near, k + 1);
}

static void own_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct make *make = ctx;
    const struct vor_domain *domain = make->domain;
    struct walk w = {.most = domain->n < WIDE ? (unsigned)domain->n : WIDE};

    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct vor_surface plain, own;
        float near[3 * VOR_ADJACENT];
        uint32_t index[VOR_ADJACENT];
        unsigned taken;

        fit_nearest(&plain, make, i);
        if (!vor_layers_possible(&plain))
            continue;
        search(domain, &domain->xyz[3 * i], w.most, w.index, w.distance2);
        walk(&w, make);
        taken = take(make, &w, VOR_ADJACENT, index, near);
        if (taken < FEWEST)
            continue;
        vor_surface_fit(&own, near, taken);
        if (own.off2 < BETTER * plain.off2)
            use(make->graph, i, index, taken);
    }
}

vor_status vor_adjacency_make(struct vor_graph *out, const struct vor_domain *domain,
                              const struct vor_run *run, struct vor_error *err)
{
    struct make make = {.domain = domain};
    struct vor_graph graph = {.n = 0};
    unsigned most = domain->n > VOR_ADJACENT ? VOR_ADJACENT : (unsigned)domain->n - 1;
    vor_status status = vor_graph_init(&graph, domain->n, most, run->memory, err);

    if (status != VOR_OK)
        return status;
    make.graph = &graph;
    make.plane = vor_malloc(run->memory, domain->n, sizeof *make.plane);
    if (make.plane == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "planes of %zu points", domain->n);
    if (status == VOR_OK)
        status = vor_run_for(run, domain->n, BLOCK, nearest_block, &make, err);
    if (status == VOR_OK)
        status = vor_run_for(run, domain->n, BLOCK, plane_block, &make, err);
    if (status == VOR_OK)
        status = vor_run_for(run, domain->n, BLOCK, own_block, &make, err);
    vor_free(run->memory, make.plane);
    if (status != VOR_OK) {
        vor_graph_free(&graph);
        return status;
    }
    *out = graph;
    return VOR_OK;
}
