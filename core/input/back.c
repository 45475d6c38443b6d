#include "core/input/back.h"

#include "core/base/linalg.h"
#include "core/geom/layers.h"

#include <math.h>
#include <string.h>

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

/* Fits to the points nearest to point i and takes its normal from there. Returns whether it did. */
static int take(const struct vor_back *back, size_t i)
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

static void find_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_domain *on = work->back->on;
    struct vor_implicit fit;

    for (size_t i = begin; i < end; i++)
        work->found[i] =
            work->back->at[i] != VOR_BACK_NOT && vor_back_fit(&fit, on, &on->xyz[3 * i]);
}

/* Takes the points of which most neighbours can be fitted likewise. If a third can, of armadillo
 * (12 draws) 137 are wrong for 156; if none need, 2,793 of 12,000 on two balls that nearly touch.
 */
static void take_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_graph *graph = work->back->graph;

    for (size_t i = begin; i < end; i++) {
        unsigned likewise = 0;

        for (unsigned a = 0; a < graph->count[i] && work->found[i]; a++)
            likewise += work->found[graph->list[i * graph->most + a]];
        work->back->at[i] =
            2 * likewise > graph->count[i] && take(work->back, i) ? VOR_BACK : VOR_BACK_NOT;
    }
}

static void grow_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_back *back = work->back;
    const struct vor_graph *graph = back->graph;

    for (size_t i = begin; i < end; i++) {
        int beside = 0;

        for (unsigned a = 0; a < graph->count[i] && back->at[i] == VOR_BACK_NOT; a++)
            beside |= back->at[graph->list[i * graph->most + a]] == VOR_BACK;
        work->found[i] = back->at[i];
        if (beside && take(back, i))
            work->found[i] = VOR_BACK;
        else if (beside && back->rough[i] * back->rough[i] > (float)VOR_LAYERS_POSSIBLE2)
            work->found[i] = VOR_BACK_BESIDE;
    }
}

vor_status vor_back_find(struct vor_back *back, unsigned rounds, const struct vor_run *run,
                         struct vor_error *err)
{
    size_t n = back->on->n;
    struct work work = {back, vor_malloc(run->memory, n, sizeof *work.found), NULL};
    vor_status status;

    if (work.found == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_run_for(run, n, BLOCK, find_block, &work, err);
    VOR_THEN(status, vor_run_for(run, n, BLOCK, take_block, &work, err));
    for (unsigned k = 0; k < rounds && status == VOR_OK; k++) {
        status = vor_run_for(run, n, BLOCK, grow_block, &work, err);
        memcpy(back->at, work.found, n);
    }
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

/* Leaves out the points whose fits those of more than one point around contradict: by one alone it
 * is open which of both is wrong. Left out for one, 53 of 30,000 points on lenses and foils face
 * inward where 6 do; with none left out, of 20,000 on thicker blades with noise of 0.1 spacings
 * 1,101 where 427 do. */
static void doubt_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct vor_back *back = work->back;
    const struct vor_graph *graph = back->graph;

    for (size_t i = begin; i < end; i++) {
        unsigned against = 0;

        for (unsigned a = 0; a < graph->count[i] && back->at[i] == VOR_BACK; a++) {
            size_t j = graph->list[i * graph->most + a];

            for (unsigned b = 0; b < graph->count[j] && back->at[j] == VOR_BACK; b++)
                against += graph->list[j * graph->most + b] == i &&
                           (work->edge[i * graph->most + a] ^ work->edge[j * graph->most + b]) >=
                               VOR_SPAN_TURNS;
        }
        work->found[i] = against > 1 ? VOR_BACK_BESIDE : back->at[i];
    }
}

vor_status vor_back_edges(struct vor_back *back, unsigned char *edge, const struct vor_run *run,
                          struct vor_error *err)
{
    size_t n = back->on->n;
    struct work work = {back, vor_malloc(run->memory, n, sizeof *work.found), edge};
    vor_status status;

    if (work.found == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_run_for(run, n, BLOCK, edge_block, &work, err);
    VOR_THEN(status, vor_run_for(run, n, BLOCK, doubt_block, &work, err));
    memcpy(back->at, work.found, n);
    vor_free(run->memory, work.found);
    return status;
}

vor_status vor_back_drop(size_t *dropped, struct vor_back *back, const struct vor_span *span,
                         double wide, struct vor_error *err)
{
    uint32_t(*count)[2] = vor_calloc(span->memory, span->components, sizeof *count); /* all, bent */

    *dropped = 0;
    if (count == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu parts", span->components);
    for (size_t i = 0; i < span->n; i++) {
        count[span->component[i]][0]++;
        count[span->component[i]][1] += back->at[i] == VOR_BACK;
    }
    for (size_t i = 0; i < span->n; i++) {
        const uint32_t *of = count[span->component[i]];

        if (back->at[i] != VOR_BACK_NOT && of[1] <= wide * sqrt(of[0])) {
            back->at[i] = back->at[i] == VOR_BACK ? VOR_BACK_FEW : VOR_BACK_NOT;
            ++*dropped;
        }
    }
    vor_free(span->memory, count);
    return VOR_OK;
}
