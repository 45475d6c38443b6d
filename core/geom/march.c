#include "core/geom/march.h"

#include "core/base/linalg.h"

#include <math.h>
#include <string.h>

/* Points that are done between two looks at whether to go on: some ms. */
enum { POLL_EVERY = 4096 };

/* Writes the edges; place[i] is how many of point i are written. */
static void fill_edges(struct vor_march *march, const struct vor_graph *graph)
{
    uint32_t *filled = march->front.place;

    memset(filled, 0, graph->n * sizeof *filled);
    for (size_t i = 0; i < graph->n; i++)
        for (unsigned a = 0; a < graph->count[i]; a++) {
            uint32_t j = graph->list[i * graph->most + a];

            march->edge[march->first[i] + filled[i]++] = j;
            if (!vor_graph_has(graph, j, (uint32_t)i))
                march->edge[march->first[j] + filled[j]++] = (uint32_t)i;
        }
}

vor_status vor_march_init(struct vor_march *out, const struct vor_graph *graph, const float *xyz,
                          struct vor_error *err)
{
    struct vor_march march = {.memory = graph->memory, .xyz = xyz, .n = graph->n};

    march.first = vor_calloc(march.memory, march.n + 1, sizeof *march.first);
    march.front.item = vor_malloc(march.memory, march.n, sizeof *march.front.item);
    march.front.place = vor_malloc(march.memory, march.n, sizeof *march.front.place);
    if (march.first != NULL && march.front.item != NULL && march.front.place != NULL) {
        /* A pair that has each other in its lists is two edges, else one each way. */
        for (size_t i = 0; i < graph->n; i++)
            for (unsigned a = 0; a < graph->count[i]; a++) {
                uint32_t j = graph->list[i * graph->most + a];

                march.first[i + 1]++;
                march.first[j + 1] += !vor_graph_has(graph, j, (uint32_t)i);
            }
        for (size_t i = 0; i < graph->n; i++)
            march.first[i + 1] += march.first[i];
        march.edge = vor_malloc(march.memory, march.first[march.n] + 1, sizeof *march.edge);
    }
    if (march.edge == NULL) {
        vor_march_free(&march);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", graph->n);
    }
    fill_edges(&march, graph);
    *out = march;
    return VOR_OK;
}

void vor_march_free(struct vor_march *march)
{
    if (march->memory == NULL)
        return;
    VOR_FREE_ALL(march->memory, march->edge, march->front.place, march->front.item, march->first);
    memset(march, 0, sizeof *march);
}

/* The distance of point v by a plane wave that has passed u and w, which are done; INFINITY unless
 * it comes through between them. In the plane of the three u is at 0, w on the first axis. An
 * obtuse angle at v, as where two waves meet, has none. */
static double through(const struct vor_march *march, uint32_t u, uint32_t w, uint32_t v)
{
    double uv[3], uw[3], length, x, y, slope, up, cut;

    vor_way(uv, &march->xyz[3 * (size_t)u], &march->xyz[3 * (size_t)v]);
    vor_way(uw, &march->xyz[3 * (size_t)u], &march->xyz[3 * (size_t)w]);
    length = sqrt(vor_dot(uw, uw));
    slope = ((double)march->far[w] - (double)march->far[u]) / length;
    if (vor_dot(uv, uv) < vor_dot(uv, uw) || !(fabs(slope) < 1)) /* u and w may coincide */
        return INFINITY;
    x = vor_dot(uv, uw) / length;
    y = sqrt(fmax(0, vor_dot(uv, uv) - x * x));
    up = sqrt(1 - slope * slope);
    cut = x - y * slope / up;
    return cut < 0 || cut > length ? INFINITY : (double)march->far[u] + slope * x + up * y;
}

/* Takes the shortest way to v past u, which is done, if it is shorter than the one known. */
static void reach(struct vor_march *march, uint32_t u, uint32_t v)
{
    double uv[3], best;

    vor_way(uv, &march->xyz[3 * (size_t)u], &march->xyz[3 * (size_t)v]);
    best = (double)march->far[u] + sqrt(vor_dot(uv, uv));
    for (size_t e = march->first[v]; e < march->first[v + 1]; e++) {
        uint32_t w = march->edge[e];

        if (march->front.place[w] == VOR_HEAP_DONE && w != u)
            best = fmin(best, through(march, u, w, v));
    }
    if ((float)best < march->far[v]) {
        march->far[v] = (float)best;
        vor_heap_move(&march->front, v);
    }
}

static void march_on(void *ctx, VOR_UNUSED size_t row, VOR_UNUSED unsigned worker)
{
    struct vor_march *march = ctx;

    for (int step = 0; step < POLL_EVERY && march->front.count > 0; step++) {
        uint32_t u = vor_heap_take(&march->front);

        for (size_t e = march->first[u]; e < march->first[u + 1]; e++)
            if (march->front.place[march->edge[e]] != VOR_HEAP_DONE)
                reach(march, u, march->edge[e]);
    }
}

vor_status vor_march_from(struct vor_march *march, float *far, const uint32_t *source,
                          size_t sources, const struct vor_run *run, struct vor_error *err)
{
    vor_status status = VOR_OK;

    march->far = far;
    march->front.key = far;
    march->front.count = 0;
    for (size_t i = 0; i < march->n; i++) {
        far[i] = INFINITY;
        march->front.place[i] = VOR_HEAP_WAITS;
    }
    for (size_t s = 0; s < sources; s++)
        if (far[source[s]] > 0) {
            far[source[s]] = 0;
            vor_heap_move(&march->front, source[s]);
        }
    while (status == VOR_OK && march->front.count > 0)
        status = vor_run_rows(run, 1, 1, march_on, march, err);
    march->far = NULL;
    return status;
}
