#include "core/geom/march.h"

#include "core/base/linalg.h"

#include <math.h>
#include <string.h>

/* Points that are done between two looks at whether to go on: some ms. */
enum { POLL_EVERY = 4096 };

vor_status vor_march_init(struct vor_march *out, const struct vor_graph *graph, const float *xyz,
                          struct vor_error *err)
{
    struct vor_march march = {.graph = graph, .xyz = xyz};

    if (VOR_MAKE_ALL(graph->memory, err, graph->n, VOR_ARRAY(march.front.item, graph->n, 1),
                     VOR_ARRAY(march.front.place, graph->n, 1)) != VOR_OK) {
        vor_march_free(&march);
        return VOR_E_NOMEM;
    }
    *out = march;
    return VOR_OK;
}

void vor_march_free(struct vor_march *march)
{
    if (march->graph == NULL)
        return;
    VOR_FREE_ALL(march->graph->memory, march->front.place, march->front.item);
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
    const struct vor_graph *graph = march->graph;
    double uv[3], best;

    vor_way(uv, &march->xyz[3 * (size_t)u], &march->xyz[3 * (size_t)v]);
    best = (double)march->far[u] + sqrt(vor_dot(uv, uv));
    for (unsigned a = 0; a < graph->count[v]; a++) {
        uint32_t w = graph->list[(size_t)v * graph->most + a];

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
    const struct vor_graph *graph = march->graph;

    for (int step = 0; step < POLL_EVERY && march->front.count > 0; step++) {
        uint32_t u = vor_heap_take(&march->front);
        const uint32_t *list = &graph->list[(size_t)u * graph->most];

        for (unsigned a = 0; a < graph->count[u]; a++)
            if (march->front.place[list[a]] != VOR_HEAP_DONE)
                reach(march, u, list[a]);
    }
}

vor_status vor_march_from(struct vor_march *march, float *far, const uint32_t *source,
                          size_t sources, const struct vor_run *run, struct vor_error *err)
{
    vor_status status = VOR_OK;

    march->far = far;
    march->front.key = far;
    march->front.count = 0;
    for (size_t i = 0; i < march->graph->n; i++) {
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
