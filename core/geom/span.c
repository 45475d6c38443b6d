#include "core/geom/span.h"

#include <math.h>
#include <string.h>

enum {
    /* Fewest points of a patch that is remembered: the numbers on fewer are noise. At 8, seven
     * points of fandisk with noise are turned to the wrong side. */
    PATCH = 12,
    NONE = UINT32_MAX
};
/* Doubt about a patch on which no edge disagreed, for each of its points. It ranks those among
 * themselves by size. At 0: the cow the same. */
#define SURE 0.01

/* Trees on their way into one tree a component. Trees are known by the point that they grew from.
 */
struct grow {
    struct vor_span *span; /* component: the tree of each point */
    const struct vor_graph *graph;
    const unsigned char *edge;
    uint32_t *last, *size; /* of a tree: the end of its chain, and how many points it has */
    uint64_t *levels;      /* of a point: those that its edges have, a bit each */
    unsigned level;
    int vote;
};

/* What the edges from the points of one tree to another one say. */
struct vote {
    double sum, total;
};

static void add_vote(struct vote *vote, const struct grow *grow, uint32_t i, unsigned a)
{
    size_t at = (size_t)i * grow->graph->most + a;
    const unsigned char *odd = grow->span->odd;
    double one = vor_span_vote(grow->edge[at], odd[i] ^ odd[grow->graph->list[at]]);

    vote->sum += one;
    vote->total += fabs(one);
}

static struct vote vote_of(const struct grow *grow, uint32_t small, uint32_t large)
{
    const struct vor_graph *graph = grow->graph;
    struct vote vote = {0, 0};

    for (uint32_t i = small; i != NONE; i = grow->span->next[i])
        for (unsigned a = 0; a < graph->count[i]; a++)
            if (grow->span->component[graph->list[(size_t)i * graph->most + a]] == large)
                add_vote(&vote, grow, i, a);
    return vote;
}

/* What it is worth to look at a patch again. */
static double doubt(const struct vor_span_join *join)
{
    return join->count * (1 - join->support + SURE);
}

/* Remembers a patch, in place of the least doubtful one if there are enough. */
static void remember(struct vor_span *span, const struct vor_span_join *join)
{
    unsigned least = 0;

    if (span->joins == VOR_SPAN_JOINS) {
        for (unsigned k = 1; k < span->joins; k++)
            if (doubt(&span->join[k]) < doubt(&span->join[least]))
                least = k;
        if (doubt(join) <= doubt(&span->join[least]))
            return;
        span->joins--;
        memmove(&span->join[least], &span->join[least + 1],
                (span->joins - least) * sizeof *span->join);
    }
    span->join[span->joins++] = *join;
}

/* Joins the trees of point i and of its a-th neighbour. */
static void join(struct grow *grow, uint32_t i, unsigned a)
{
    struct vor_span *span = grow->span;
    uint32_t j = grow->graph->list[(size_t)i * grow->graph->most + a];
    uint32_t large = span->component[i], small = span->component[j];
    struct vote vote;

    if (large == small)
        return;
    if (grow->size[large] < grow->size[small]) {
        small = large;
        large = span->component[j];
    }
    vote = grow->vote ? vote_of(grow, small, large) : (struct vote){0, 0};
    add_vote(&vote, grow, i, a);
    if (grow->size[small] >= PATCH)
        remember(span,
                 &(struct vor_span_join){small, grow->size[small], fabs(vote.sum) / vote.total});
    for (uint32_t k = small; k != NONE; k = span->next[k]) {
        span->component[k] = large;
        span->odd[k] ^= vote.sum < 0;
    }
    span->next[grow->last[large]] = small;
    grow->last[large] = grow->last[small];
    grow->size[large] += grow->size[small];
}

/* All edges of one level: a single task, because their order decides. */
static void join_level(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct grow *grow = ctx;
    const struct vor_graph *graph = grow->graph;

    (void)begin, (void)end, (void)worker;
    for (size_t i = 0; i < graph->n; i++)
        for (unsigned a = 0; grow->levels[i] >> grow->level & 1 && a < graph->count[i]; a++)
            if (grow->edge[i * graph->most + a] % VOR_SPAN_TURNS == grow->level)
                join(grow, (uint32_t)i, a);
}

static vor_status run_levels(struct grow *grow, const struct vor_run *run, struct vor_error *err)
{
    vor_status status = VOR_OK;

    memset(grow->span->odd, 0, grow->graph->n);
    for (size_t i = 0; i < grow->graph->n; i++) {
        grow->span->component[i] = grow->last[i] = (uint32_t)i;
        grow->span->next[i] = NONE;
        grow->size[i] = 1;
        grow->levels[i] = 0;
        for (unsigned a = 0; a < grow->graph->count[i]; a++)
            grow->levels[i] |= 1ULL << grow->edge[i * grow->graph->most + a] % VOR_SPAN_LEVELS;
    }
    for (; grow->level < VOR_SPAN_LEVELS && status == VOR_OK; grow->level++)
        status = vor_run_for(run, 1, 1, join_level, grow, err);
    if (status == VOR_OK) {
        for (size_t i = 0; i < grow->graph->n; i++)
            grow->last[i] = NONE;
        for (size_t i = 0; i < grow->graph->n; i++) {
            uint32_t *of = &grow->last[grow->span->component[i]];

            if (*of == NONE)
                *of = (uint32_t)grow->span->components++;
            grow->span->component[i] = *of;
        }
    }
    return status;
}

vor_status vor_span_make(struct vor_span *out, const struct vor_graph *graph,
                         const unsigned char *edge, int vote, const struct vor_run *run,
                         struct vor_error *err)
{
    struct vor_span span = {.memory = run->memory, .n = graph->n};
    struct grow grow = {.span = &span, .graph = graph, .edge = edge, .vote = vote};
    vor_status status;

    status = VOR_MAKE_ALL(run->memory, err, graph->n, VOR_ARRAY(span.component, graph->n, 1),
                          VOR_ARRAY(span.next, graph->n, 1), VOR_ARRAY(span.odd, graph->n, 1),
                          VOR_ARRAY(grow.last, graph->n, 1), VOR_ARRAY(grow.size, graph->n, 1),
                          VOR_ARRAY(grow.levels, graph->n, 1));
    VOR_THEN(status, run_levels(&grow, run, err));
    VOR_FREE_ALL(run->memory, grow.levels, grow.size, grow.last);
    if (status == VOR_OK)
        *out = span;
    else
        vor_span_free(&span);
    return status;
}

void vor_span_free(struct vor_span *span)
{
    VOR_FREE_ALL(span->memory, span->odd, span->next, span->component);
    memset(span, 0, sizeof *span);
}
