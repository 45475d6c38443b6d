#include "core/input/back.h"

#include "core/base/linalg.h"
#include "core/geom/span.h"

enum { BLOCK = 256 }; /* points of one task */

/* Points at work: what is found of each is found of all before it counts. */
struct work {
    struct vor_back *back;
    unsigned char *found, *edge;
};

int vor_back_fit(struct vor_implicit *out, const struct vor_domain *domain, const float x[3])
{
    unsigned k = vor_domain_most(domain, VOR_IMPLICIT_POINTS);
    uint32_t index[VOR_IMPLICIT_POINTS];
    float near[3 * VOR_IMPLICIT_POINTS], distance2[VOR_IMPLICIT_POINTS];

    vor_knn_search(domain->knn, x, 1, k, index, distance2);
    vor_gather(near, domain->xyz, index, k);
    return vor_implicit_fit(out, near, k, x);
}

double vor_back_along(const struct vor_implicit *implicit, const float x[3], const float normal[3])
{
    double own[3], at[3];

    vor_to_doubles(own, normal);
    vor_implicit_normal(implicit, x, at);
    return vor_dot(own, at);
}

int vor_back_take(const struct vor_back *back, size_t i)
{
    const float *x = &back->on->xyz[3 * i];
    struct vor_implicit fit;
    double normal[3];

    if (!vor_back_fit(&fit, back->on, x))
        return 0;
    vor_implicit_normal(&fit, x, normal);
    vor_to_floats(&back->normal[3 * i], normal);
    return 1;
}

static void grow_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_back *back = work->back;
    const struct vor_graph *graph = back->graph;

    for (size_t i = begin; i < end; i++) {
        int beside = 0;

        for (unsigned a = 0; a < graph->count[i] && back->at[i] == 0; a++)
            beside |= back->at[graph->list[i * graph->most + a]] == VOR_BACK;
        work->found[i] = (unsigned char)(!beside                  ? back->at[i]
                                         : vor_back_take(back, i) ? VOR_BACK
                                                                  : VOR_BACK_BESIDE);
    }
}

vor_status vor_back_grow(struct vor_back *back, unsigned rounds, const struct vor_run *run,
                         struct vor_error *err)
{
    size_t n = back->on->n, before, points = 0;
    struct work work = {.back = back};
    vor_status status = VOR_OK;

    for (size_t i = 0; i < n; i++)
        points += back->at[i];
    if (points == 0)
        return VOR_OK;
    work.found = vor_malloc(run->memory, n, sizeof *work.found);
    if (work.found == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    do {
        status = vor_run_for(run, n, BLOCK, grow_block, &work, err);
        before = points;
        points = 0;
        for (size_t i = 0; i < n && status == VOR_OK; i++) {
            back->at[i] = work.found[i];
            points += back->at[i] == VOR_BACK;
        }
    } while (status == VOR_OK && points > before && --rounds > 0);
    back->points = points;
    vor_free(run->memory, work.found);
    return status;
}

static void edge_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_back *back = work->back;
    const struct vor_graph *graph = back->graph;
    struct vor_implicit fit;

    for (size_t i = begin; i < end; i++)
        if (back->at[i] == VOR_BACK && vor_back_fit(&fit, back->on, &back->on->xyz[3 * i]))
            for (unsigned a = 0; a < graph->count[i]; a++) {
                size_t j = graph->list[i * graph->most + a];
                double along = vor_back_along(&fit, &back->on->xyz[3 * j], &back->normal[3 * j]);

                work->edge[i * graph->most + a] = vor_span_edge((1 - fabs(along)) / 2, along < 0);
            }
}

/* Finds the share of the points around whose own fits contradict that at a point. */
static void doubt_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_back *back = work->back;
    const struct vor_graph *graph = back->graph;

    for (size_t i = begin; i < end; i++) {
        unsigned against = 0, all = 0;

        if (back->at[i] != VOR_BACK)
            continue;
        for (unsigned a = 0; a < graph->count[i]; a++) {
            size_t j = graph->list[i * graph->most + a];

            for (unsigned b = 0; b < graph->count[j] && back->at[j] == VOR_BACK; b++)
                if (graph->list[j * graph->most + b] == i) {
                    all++;
                    against += (work->edge[i * graph->most + a] ^
                                work->edge[j * graph->most + b]) >= VOR_SPAN_TURNS;
                }
        }
        back->rough[i] = all > 0 ? (float)against / (float)all : 0;
    }
}

static void dearer_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_back *back = work->back;
    const struct vor_graph *graph = back->graph;

    for (size_t i = begin; i < end; i++)
        for (unsigned a = 0; a < graph->count[i] && back->at[i] == VOR_BACK; a++) {
            unsigned char *edge = &work->edge[i * graph->most + a];
            double doubt =
                fmax((double)back->rough[i], (double)back->rough[graph->list[i * graph->most + a]]);

            *edge = vor_span_edge((double)(*edge % VOR_SPAN_TURNS) / VOR_SPAN_LEVELS + doubt,
                                  *edge >= VOR_SPAN_TURNS);
        }
}

vor_status vor_back_edges(struct vor_back *back, unsigned char *edge, const struct vor_run *run,
                          struct vor_error *err)
{
    struct work work = {.back = back, .edge = edge};
    size_t n = back->points > 0 ? back->on->n : 0;
    vor_status status = vor_run_for(run, n, BLOCK, edge_block, &work, err);

    VOR_THEN(status, vor_run_for(run, n, BLOCK, doubt_block, &work, err));
    VOR_THEN(status, vor_run_for(run, n, BLOCK, dearer_block, &work, err));
    return status;
}
