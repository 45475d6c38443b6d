#include "tests/support/vt_lists.h"

#include "core/geom/march.h"
#include "core/input/adjacency.h"

#include <math.h>

#define FAR 10 /* spacings: over less, the grain of the lists shows */

void vt_lists_start(struct vt_lists *lists, unsigned threads, int shape, int seed, size_t n,
                    double gap)
{
    lists->metric = &vt_metrics[shape];
    lists->gap = gap;
    vt_engine_open(&lists->engine, threads);
    lists->metric->make(&lists->cloud, (uint64_t)seed, n, gap);
    vt_assert_ok(vor_domain_init(&lists->domain, &lists->cloud, &lists->engine.run, &vt_err));
}

void vt_lists_start_waves(struct vt_lists *lists, unsigned threads, int seed, size_t n,
                          double waves)
{
    const double apart = 0.4, high = 0.03;

    vt_engine_open(&lists->engine, threads);
    lists->metric = &vt_metrics[VT_SHEETS];
    lists->gap = apart * vt_spacing(lists->metric, n);
    lists->metric->make(&lists->cloud, (uint64_t)seed, n, lists->gap);
    for (size_t i = 0; i < n; i++) {
        float *x = &lists->cloud.xyz[3 * i];

        x[2] += (float)(high * sin(waves * (double)x[0]) * sin(waves * (double)x[1]));
    }
    vt_assert_ok(vor_domain_init(&lists->domain, &lists->cloud, &lists->engine.run, &vt_err));
    lists->domain.known.sheets = 1;
    vt_assert_ok(vor_adjacency_make(&lists->graph, &lists->domain, &lists->engine.run, &vt_err));
}

size_t vt_lists_astray(const struct vt_lists *lists)
{
    const struct vor_graph *graph = &lists->graph;
    const uint32_t *source = lists->domain.source;
    size_t pairs = 0;

    for (size_t i = 0; i < graph->n; i++)
        for (unsigned j = 0; j < graph->count[i]; j++)
            pairs += (source[i] ^ source[graph->list[i * graph->most + j]]) & 1;
    return pairs;
}

void vt_lists_end(struct vt_lists *lists)
{
    vor_graph_free(&lists->graph);
    vor_domain_free(&lists->domain);
    vor_cloud_free(&lists->cloud);
    vt_engine_close(&lists->engine);
    vt_assert_no_leak();
}

static void position(const struct vt_lists *lists, size_t i, double x[3])
{
    vor_cloud_position(&lists->cloud, lists->domain.source[i], x);
}

static double straight(const double a[3], const double b[3])
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

size_t vt_lists_across(const struct vt_lists *lists)
{
    const struct vor_graph *graph = &lists->graph;
    size_t pairs = 0;

    for (size_t i = 0; i < graph->n; i++)
        for (unsigned a = 0; a < graph->count[i]; a++) {
            double x[3], y[3];

            position(lists, i, x);
            position(lists, graph->list[i * graph->most + a], y);
            pairs += lists->metric->along(x, y, lists->gap) > 2 * straight(x, y);
        }
    return pairs;
}

struct vt_way vt_lists_way(const struct vt_lists *lists, int seed)
{
    size_t n = lists->domain.n;
    double spacing = vt_spacing(lists->metric, n), from[3], to[3];
    uint32_t source = (uint32_t)(vt_unit(77, (uint64_t)seed) * (double)n);
    float *far = vor_malloc(&vt_memory, n, sizeof *far);
    struct vor_march march;
    struct vt_way way = {0, 0};

    vt_assert_ok(vor_march_init(&march, &lists->graph, lists->domain.xyz, &vt_err));
    vt_assert_ok(vor_march_from(&march, far, &source, 1, &lists->engine.run, &vt_err));
    position(lists, source, from);
    for (size_t i = 0; i < n; i++) {
        double exact, off;

        position(lists, i, to);
        exact = lists->metric->along(from, to, lists->gap);
        if (exact < FAR * spacing)
            continue;
        off = fabs((double)far[i] * lists->domain.unit / exact - 1);
        way.worst = fmax(way.worst, off);
        way.mean += off / (double)n;
    }
    vor_march_free(&march);
    vor_free(&vt_memory, far);
    return way;
}

uint64_t vt_lists_hash(const struct vor_graph *graph)
{
    uint64_t hash = 0;

    for (size_t i = 0; i < graph->n; i++)
        hash = hash * 31 +
               vt_hash(&graph->list[i * graph->most], graph->count[i] * sizeof *graph->list);
    return hash * 31 + vt_hash(graph->normal, 3 * graph->n * sizeof *graph->normal);
}
