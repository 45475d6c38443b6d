#include "core/geom/graph.h"

#include "core/base/union.h"

#include <assert.h>
#include <string.h>

vor_status vor_graph_init(struct vor_graph *out, size_t n, unsigned most, struct vor_memory *memory,
                          struct vor_error *err)
{
    struct vor_graph graph = {.memory = memory, .n = n, .most = most};

    assert(most >= 1 && most <= 255);
    if (VOR_MAKE_ALL(memory, err, n, VOR_ARRAY(graph.list, n, most), VOR_ZEROED(graph.count, n, 1),
                     VOR_ZEROED(graph.own, n, 1), VOR_ZEROED(graph.normal, n, 3)) != VOR_OK) {
        vor_graph_free(&graph);
        return VOR_E_NOMEM;
    }
    *out = graph;
    return VOR_OK;
}

void vor_graph_free(struct vor_graph *graph)
{
    VOR_FREE_ALL(graph->memory, graph->surface, graph->normal, graph->own, graph->count,
                 graph->list);
    memset(graph, 0, sizeof *graph);
}

enum { BLOCK = 256 }; /* points of one task */

struct nearest {
    struct vor_graph *graph;
    const struct vor_knn *knn;
    const float *xyz;
    unsigned k;
};

static void nearest_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct nearest *nearest = ctx;
    struct vor_graph *graph = nearest->graph;
    uint32_t index[256];
    float distance2[256];
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++) {
        unsigned taken = 0;

        vor_knn_search_next(nearest->knn, &last, &nearest->xyz[3 * i], nearest->k + 1, index,
                            distance2);
        for (unsigned j = 0; j <= nearest->k && taken < nearest->k; j++)
            if (index[j] != i)
                graph->list[i * graph->most + taken++] = index[j];
        graph->count[i] = (unsigned char)taken;
    }
}

vor_status vor_graph_nearest(struct vor_graph *graph, const struct vor_knn *knn, const float *xyz,
                             unsigned k, const struct vor_run *run, struct vor_error *err)
{
    struct nearest nearest = {graph, knn, xyz, k};

    assert(k >= 1 && k <= graph->most && k < graph->n);
    return vor_run_for(run, graph->n, BLOCK, nearest_block, &nearest, err);
}

int vor_graph_has(const struct vor_graph *graph, uint32_t i, uint32_t j)
{
    const uint32_t *list = &graph->list[(size_t)i * graph->most];

    for (unsigned a = 0; a < graph->count[i]; a++)
        if (list[a] == j)
            return 1;
    return 0;
}

int vor_graph_joins(const struct vor_graph *graph, uint32_t i, uint32_t j)
{
    return vor_graph_has(graph, i, j) || vor_graph_has(graph, j, i);
}

int vor_graph_leads(const struct vor_graph *graph, uint32_t from, uint32_t to)
{
    const uint32_t *out = &graph->list[(size_t)from * graph->most];
    const uint32_t *in = &graph->list[(size_t)to * graph->most];

    if (vor_graph_joins(graph, from, to))
        return 1;
    for (unsigned k = 0; k < graph->count[from]; k++) {
        if (vor_graph_joins(graph, out[k], to))
            return 1;
        for (unsigned m = 0; m < graph->count[to]; m++)
            if (vor_graph_joins(graph, out[k], in[m]))
                return 1;
    }
    return 0;
}

/* A graph, and for each point which entries of its list stay: bit a for entry a. */
struct mutual {
    struct vor_graph *graph;
    uint32_t *stay;
};

static void mutual_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct mutual *mutual = ctx;
    const struct vor_graph *graph = mutual->graph;

    for (size_t i = begin; i < end; i++) {
        mutual->stay[i] = 0;
        for (unsigned a = 0; a < graph->count[i]; a++)
            if (vor_graph_has(graph, graph->list[i * graph->most + a], (uint32_t)i))
                mutual->stay[i] |= (uint32_t)1 << a;
    }
}

static void drop_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct mutual *mutual = ctx;
    struct vor_graph *graph = mutual->graph;

    for (size_t i = begin; i < end; i++) {
        uint32_t *list = &graph->list[i * graph->most];
        unsigned taken = 0;

        for (unsigned a = 0; a < graph->count[i]; a++)
            if (mutual->stay[i] & (uint32_t)1 << a)
                list[taken++] = list[a];
        graph->count[i] = (unsigned char)taken;
    }
}

vor_status vor_graph_keep_mutual(struct vor_graph *graph, const struct vor_run *run,
                                 struct vor_error *err)
{
    struct mutual mutual = {graph, vor_malloc(graph->memory, graph->n, sizeof *mutual.stay)};
    vor_status status;

    assert(graph->most <= 32);
    if (mutual.stay == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", graph->n);
    status = vor_run_for(run, graph->n, BLOCK, mutual_block, &mutual, err);
    VOR_THEN(status, vor_run_for(run, graph->n, BLOCK, drop_block, &mutual, err));
    vor_free(graph->memory, mutual.stay);
    return status;
}

/* Points that were found, by a hash of twice as many places: 0 or a point's number plus 1. */
enum { FOUND = 2 * VOR_GRAPH_AROUND };
_Static_assert(FOUND == 1024, "the hash has ten bits");

/* Adds a point. Returns whether it is new. */
static int add_new(uint32_t *found, uint32_t i)
{
    uint32_t at = i * 2654435761U >> 22; /* Knuth's multiplier; ten bits, as FOUND has places */

    while (found[at] != 0 && found[at] != i + 1)
        at = (at + 1) % FOUND;
    if (found[at] != 0)
        return 0;
    found[at] = i + 1;
    return 1;
}

unsigned vor_graph_around(const struct vor_graph *graph, uint32_t i, uint32_t *out, unsigned wanted)
{
    uint32_t found[FOUND] = {0};
    unsigned count = 1;

    assert(wanted >= 1 && wanted <= VOR_GRAPH_AROUND);
    (void)add_new(found, i);
    out[0] = i;
    for (unsigned next = 0; next < count && count < wanted; next++) {
        const uint32_t *list = &graph->list[(size_t)out[next] * graph->most];

        for (unsigned a = 0; a < graph->count[out[next]] && count < wanted; a++)
            if (add_new(found, list[a]))
                out[count++] = list[a];
    }
    return count;
}

vor_status vor_graph_components(uint32_t *component, size_t *count, const struct vor_graph *graph,
                                struct vor_error *err)
{
    uint32_t *parent = vor_malloc(graph->memory, graph->n, sizeof *parent);

    if (parent == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", graph->n);
    for (size_t i = 0; i < graph->n; i++)
        parent[i] = (uint32_t)i;
    for (size_t i = 0; i < graph->n; i++)
        for (unsigned a = 0; a < graph->count[i]; a++)
            vor_union_join(parent, (uint32_t)i, graph->list[i * graph->most + a]);
    *count = 0;
    for (size_t i = 0; i < graph->n; i++) {
        uint32_t first = vor_union_root(parent, (uint32_t)i);

        component[i] = first == i ? (uint32_t)(*count)++ : component[first];
    }
    vor_free(graph->memory, parent);
    return VOR_OK;
}
