#include "core/input/propagate.h"

#include "core/base/linalg.h"
#include "core/geom/flip.h"
#include "core/geom/hinge.h"
#include "core/input/adjacency.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 256 /* points of one task */
};

/* What must be against a point before its neighbours change its side, for each. At 0 / 0.1 of
 * fandisk's with noise (0.2 % of the diagonal) 3 / 0 are wrong for it (three draws), at 0.1 / 0.4
 * of armadillo's 0 / 1. */
#define OUTVOTE 0.1
/* Mean winding number on a surface, or less its sign, beyond which it is closed. Measured: igea,
 * armadillo, cow 0.5, fandisk with noise 0.7; the depth scan office1 0.04. */
#define CLOSED 0.25
/* Mean square of how far winding numbers are from a half, beyond which a surface is not well
 * closed: between clean closed surfaces, 0.0002 to 0.007, with noise of a third of the spacing
 * 0.04, and a wedge of which a face is on the wrong side, 0.11. */
#define APART 0.06
/* What how far the ends of an edge are off each other's planes weighs against the cosine between
 * their normals, where these planes meet between them; 2 is the mirror's. Points facing inward at
 * 10 / 20 / 40, of 126 inputs of 49 sharp shapes 11,672 / 4,882 / 4,158. */
#define PLANES 20.0

/* An edge: the cosine between the normals of its ends, how far each end is above the plane of the
 * other, and its length. */
struct edge {
    double cosine, a, b, length2;
};

static struct edge look(const struct vor_propagation *propagation, size_t i, size_t j)
{
    const struct vor_back *back = &propagation->back;
    double x[3], y[3], m[3], n[3], along[3];
    struct edge edge;

    vor_to_doubles(x, &back->on->xyz[3 * i]);
    vor_to_doubles(y, &back->on->xyz[3 * j]);
    vor_to_doubles(m, &back->normal[3 * i]);
    vor_to_doubles(n, &back->normal[3 * j]);
    for (int c = 0; c < 3; c++)
        along[c] = y[c] - x[c];
    edge.length2 = fmax(vor_dot(along, along), 1e-300);
    edge.a = vor_dot(m, along);
    edge.b = vor_dot(n, along);
    edge.cosine = vor_dot(m, n);
    return edge;
}

/* Cosine between the normal of one end, mirrored at the plane midway, and that of the other. */
static double mirrored(const struct edge *edge)
{
    return edge->cosine - 2 * edge->a * edge->b / edge->length2;
}

/* Below 0 where the signs at both ends differ, by their planes where these meet between them. */
static double by_planes(const struct edge *edge)
{
    double sine2 = 1 - edge->cosine * edge->cosine;

    if (fmax(edge->a * edge->a, edge->b * edge->b) > 2 * edge->length2 * sine2)
        return mirrored(edge);
    return edge->cosine - PLANES * edge->a * edge->b / edge->length2;
}

/* Whether planes contradict the mirror. */
static int is_contradicted(const struct edge *edge)
{
    return (by_planes(edge) < 0) != (mirrored(edge) < 0);
}

/* An edge along a normal weighs as much as one between normals at right angles; at 0 / 1 / 2 of
 * that: armadillo 75, 14, 15 / 30, 16, 15 / 31, 16, 15 points are wrong; fandisk 6569 / 0 / 0. At a
 * fold the mirror is about 0 where planes contradict it, and sure of nothing; planes weigh instead.
 */
unsigned char vor_propagation_edge(const struct vor_propagation *propagation, size_t i, size_t j)
{
    const struct vor_back *back = &propagation->back;
    struct edge edge = look(propagation, i, j);
    double along = mirrored(&edge), more = 0, weight;
    int turns = along < 0;

    weight = fmax(0, 1 - fabs(along) + fmax(edge.a * edge.a, edge.b * edge.b) / edge.length2);
    if ((propagation->planes[i] || propagation->planes[j]) && is_contradicted(&edge)) {
        weight = fmax(0, 1 - fabs(by_planes(&edge)));
        turns = !turns;
    }
    if (propagation->rough_last)
        more = fmin(1, fmax((double)back->rough[i], (double)back->rough[j]));
    else if (back->at[i] == VOR_BACK_BESIDE || back->at[j] == VOR_BACK_BESIDE)
        more = 1;
    return vor_span_edge((weight + more) / (2 + propagation->rough_last), turns);
}

static void edge_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct vor_propagation *propagation = ctx;
    const struct vor_graph *graph = propagation->back.graph;

    for (size_t i = begin; i < end; i++)
        if (propagation->back.at[i] != VOR_BACK || propagation->rough_last)
            for (unsigned a = 0; a < graph->count[i]; a++)
                propagation->edge[i * graph->most + a] =
                    vor_propagation_edge(propagation, i, graph->list[i * graph->most + a]);
}

static vor_status make_edges(struct vor_propagation *propagation, const struct vor_run *run,
                             struct vor_error *err)
{
    return vor_run_for(run, propagation->back.on->n, BLOCK, edge_block, propagation, err);
}

static void contradict_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct vor_propagation *propagation = ctx;
    const struct vor_graph *graph = propagation->back.graph;

    for (size_t i = begin; i < end; i++)
        for (unsigned a = 0; a < graph->count[i] && !propagation->planes[i]; a++) {
            struct edge edge = look(propagation, i, graph->list[i * graph->most + a]);

            propagation->planes[i] = (unsigned char)is_contradicted(&edge);
        }
}

/* Signs spread once more. */
struct anew {
    const struct vor_propagation *propagation;
    struct vor_span span;
    struct vor_winding_found *found; /* of each component */
};

/* What signs spread once more are by. */
enum by { BY_VOTES, BY_ROUGH_LAST, BY_PLANES, BY_HINGES };

/* Every point whose neighbours mostly say so changes its side, in the order of the points. */
static void outvote(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct vor_propagation *propagation = ((struct anew *)ctx)->propagation;
    const struct vor_graph *graph = propagation->back.graph;
    unsigned char *odd = ((struct anew *)ctx)->span.odd;

    for (size_t i = begin; i < end; i++) {
        double vote = 0;

        for (unsigned a = 0; a < graph->count[i]; a++)
            vote += vor_span_vote(propagation->edge[i * graph->most + a],
                                  odd[i] ^ odd[graph->list[i * graph->most + a]]);
        odd[i] ^= vote < -OUTVOTE * graph->count[i];
    }
}

static vor_status outvote_all(struct anew *anew, const struct vor_run *run, struct vor_error *err)
{
    size_t n = anew->span.n;
    vor_status status = VOR_OK;

    for (unsigned k = 0; k < VOR_VOTES && status == VOR_OK; k++)
        status = vor_run_for(run, n, n, outvote, anew, err); /* one task: their order decides */
    return status;
}

/* Gives points beside a rim back the side they had, as seen from the nearest neighbour that is
 * none: lists there have both faces, and most of them say nothing. Facing inward of 150 blades'
 * 1,500,000 points, without / with: 637 / 494; of 75 with noise 9,240 / 7,153 of 750,000. */
static void keep_beside(struct vor_span *span, const struct vor_propagation *propagation)
{
    const struct vor_back *back = &propagation->back;
    const struct vor_graph *graph = back->graph;
    const unsigned char *was = propagation->span.odd;

    for (size_t i = 0; i < span->n; i++)
        for (unsigned a = 0; a < graph->count[i] && back->at[i] == VOR_BACK_BESIDE; a++) {
            uint32_t j = graph->list[i * graph->most + a];

            if (back->at[j] == VOR_BACK_BESIDE)
                continue;
            span->odd[i] = span->odd[j] ^ was[i] ^ was[j];
            break;
        }
}

/* Spreads the signs anew, by votes, and turns what faces the wrong way by itself: patches, then
 * points. */
static vor_status spread_anew(struct anew *anew, const struct vor_run *run, struct vor_error *err)
{
    const struct vor_propagation *propagation = anew->propagation;
    vor_status status =
        vor_span_make(&anew->span, propagation->back.graph, propagation->edge, 1, run, err);

    VOR_THEN(status, vor_winding_turn(&anew->span, &propagation->points, run, err));
    VOR_THEN(status, outvote_all(anew, run, err));
    if (status == VOR_OK && !propagation->rough_last)
        keep_beside(&anew->span, propagation);
    VOR_THEN(status, vor_winding_find(anew->found, &anew->span, &propagation->points, run, err));
    return status;
}

static int is_closed(const struct vor_winding_found *found)
{
    return fabs(found->mean) >= CLOSED;
}

/* Whether a component takes signs spread once more, by how far winding numbers beside the surface
 * are from what a closed one has (of a noisy star 0.016, with two sides of an arm the wrong way
 * 0.034): by votes, which mend single points, unless that closes it worse (141 points of a clean
 * hourglass's side turned inward: 0.0150 for 0.0146); else where that closes it better by a
 * quarter; and by planes, if both leave it open, where the numbers jump less by a quarter over the
 * edges whose ends have other signs than before, and these are no more than a seam. Of sheets with
 * three to six folds of 50 degrees they jump by 0.10 to 0.15 by the mirror, 0.04 to 0.07 by
 * planes. By hinges where it is open, or they close it better. */
static int takes(enum by by, const struct vor_winding_found *was,
                 const struct vor_winding_found *now)
{
    if (by == BY_VOTES)
        return is_closed(was) && now->stray <= was->stray;
    if (by == BY_HINGES)
        return !is_closed(was) || (is_closed(now) && now->stray < was->stray);
    if (by == BY_PLANES && !is_closed(was) && !is_closed(now))
        return now->seam <= VOR_SEAM && 4 * now->jump < 3 * was->jump;
    return is_closed(now) && 4 * now->stray < 3 * was->stray;
}

/* Gives those components the signs that take them. */
static void take(struct vor_span *span, struct vor_winding_found *found, const struct anew *anew,
                 enum by by)
{
    for (size_t i = 0; i < span->n; i++)
        if (takes(by, &found[span->component[i]], &anew->found[span->component[i]]))
            span->odd[i] = anew->span.odd[i];
    for (size_t c = 0; c < span->components; c++)
        if (takes(by, &found[c], &anew->found[c]))
            found[c] = anew->found[c];
}

/* Spreads signs anew, over the edges as they weigh now, and takes those that are better. */
static vor_status try_anew(struct vor_propagation *propagation, struct vor_winding_found *found,
                           const struct vor_run *run, struct vor_error *err)
{
    struct anew anew = {.propagation = propagation};
    vor_status status;

    anew.found = vor_malloc(run->memory, propagation->span.components, sizeof *anew.found);
    if (anew.found == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu parts", propagation->span.components);
    status = spread_anew(&anew, run, err);
    if (status == VOR_OK)
        take(&propagation->span, found, &anew, propagation->rough_last ? BY_ROUGH_LAST : BY_VOTES);
    vor_span_free(&anew.span);
    vor_free(run->memory, anew.found);
    return status;
}

/* Tries signs spread across rough points last: faces may be joined there that lie on different
 * sides. */
static vor_status close_up(struct vor_propagation *propagation, struct vor_winding_found *found,
                           const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    propagation->rough_last = 1;
    status = make_edges(propagation, run, err);
    VOR_THEN(status, try_anew(propagation, found, run, err));
    VOR_THEN(status, vor_back_edges(&propagation->back, propagation->edge, run, err));
    propagation->rough_last = 0;
    VOR_THEN(status, make_edges(propagation, run, err));
    return status;
}

/* Mends the signs of components that are closed, or can be. */
static vor_status mend(struct vor_propagation *propagation, const struct vor_run *run,
                       struct vor_error *err)
{
    size_t components = propagation->span.components, closed = 0, apart = 0;
    struct vor_winding_found *found = vor_malloc(run->memory, components, sizeof *found);
    vor_status status;

    if (found == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu parts", components);
    status = vor_winding_find(found, &propagation->span, &propagation->points, run, err);
    for (size_t c = 0; c < components && status == VOR_OK; c++)
        closed += is_closed(&found[c]);
    if (closed > 0 && propagation->vote)
        VOR_THEN(status, try_anew(propagation, found, run, err));
    /* A fourth as for `apart`; the noisy star is spread once more in vain. */
    for (size_t c = 0; c < components && status == VOR_OK; c++)
        apart += found[c].stray >= APART / 4;
    if (apart > 0)
        VOR_THEN(status, close_up(propagation, found, run, err));
    vor_free(run->memory, found);
    return status;
}

/* Spreads signs over the edges, by votes or by the lightest, and mends them. */
static vor_status spread(struct vor_propagation *propagation, int vote, const struct vor_run *run,
                         struct vor_error *err)
{
    const struct vor_graph *graph = propagation->back.graph;
    const struct vor_flip_how how = {.doubt = OUTVOTE,
                                     .margin = VOR_AGREE,
                                     .closed = CLOSED,
                                     .apart = APART,
                                     .clean = APART / 4};
    struct vor_span *span = &propagation->span;
    size_t dropped = 0;
    vor_status status = make_edges(propagation, run, err);

    VOR_THEN(status, vor_span_make(span, graph, propagation->edge, vote, run, err));
    VOR_THEN(status, vor_back_drop(&dropped, &propagation->back, span, VOR_SEAM, err));
    if (dropped > 0) { /* their edges are like all others */
        vor_span_free(span);
        VOR_THEN(status, make_edges(propagation, run, err));
        VOR_THEN(status, vor_span_make(span, graph, propagation->edge, vote, run, err));
    }
    if (vote) {
        struct anew anew = {.propagation = propagation, .span = *span};

        VOR_THEN(status, outvote_all(&anew, run, err));
    }
    VOR_THEN(status, mend(propagation, run, err));
    VOR_THEN(status, vor_flip_regions(span, graph, propagation->edge, &propagation->points, &how,
                                      run, err));
    return status;
}

/* Spreads signs once more, by the planes of edges' ends, and takes those that are better. */
static vor_status try_planes(struct vor_propagation *propagation, const struct vor_run *run,
                             struct vor_error *err)
{
    size_t n = propagation->back.on->n, components = propagation->span.components;
    struct vor_span first = propagation->span;
    struct anew anew = {.propagation = propagation};
    struct vor_winding_found *found = NULL;
    struct vor_winding_points points = propagation->points;
    vor_status status;

    points.graph = propagation->back.graph;
    propagation->span = (struct vor_span){.n = 0};
    status = VOR_MAKE_ALL(run->memory, err, components, VOR_ARRAY(found, components, 1),
                          VOR_ARRAY(anew.found, components, 1));
    VOR_THEN(status, spread(propagation, propagation->vote, run, err));
    anew.span = propagation->span;
    propagation->span = first;
    points.other = propagation->vote ? anew.span.odd : NULL;
    VOR_THEN(status, vor_winding_find(found, &first, &points, run, err));
    points.other = propagation->vote ? first.odd : NULL;
    VOR_THEN(status, vor_winding_find(anew.found, &anew.span, &points, run, err));
    for (size_t i = 0; i < n && status == VOR_OK; i++)
        propagation->planes[i] &= (unsigned char)takes(BY_PLANES, &found[first.component[i]],
                                                       &anew.found[first.component[i]]);
    if (status == VOR_OK)
        take(&propagation->span, found, &anew, BY_PLANES);
    VOR_THEN(status, make_edges(propagation, run, err));
    vor_span_free(&anew.span);
    VOR_FREE_ALL(run->memory, anew.found, found);
    return status;
}

/* Finds signs of faces that meet at creases, and takes those that are better. Results inward of 22
 * inputs (folded, wedge, polyhedron, gear; even and uneven) at 0.05 / 0.1 / 0.2 of `seen` 7 / 15 /
 * 7,428, at 0.015 / 0.03 / 0.06 of `bend` 27 / 15 / 12, at 0.25 / 0.5 / 0.9 of `agree` 15 each. */
static vor_status try_hinges(struct vor_propagation *propagation, const struct vor_run *run,
                             struct vor_error *err)
{
    struct vor_span *span = &propagation->span;
    const struct vor_hinge on = {.span = span,
                                 .graph = propagation->back.graph,
                                 .points = &propagation->points,
                                 .knn = propagation->back.on->knn,
                                 .bend = 1 - VOR_NORMALS_ALIKE,
                                 .seen = OUTVOTE,
                                 .agree = VOR_AGREE};
    struct anew anew = {.propagation = propagation, .span = *span};
    struct vor_winding_found *found = NULL;
    vor_status status;

    anew.span.odd = NULL;
    status = VOR_MAKE_ALL(run->memory, err, span->n, VOR_ARRAY(found, span->components, 1),
                          VOR_ARRAY(anew.found, span->components, 1),
                          VOR_ARRAY(anew.span.odd, span->n, 1));
    VOR_THEN(status, vor_hinge_find(anew.span.odd, &on, run, err));
    if (status == VOR_OK && memcmp(anew.span.odd, span->odd, span->n) != 0) {
        status = vor_winding_find(found, span, &propagation->points, run, err);
        VOR_THEN(status, vor_winding_find(anew.found, &anew.span, &propagation->points, run, err));
        if (status == VOR_OK)
            take(span, found, &anew, BY_HINGES);
    }
    VOR_FREE_ALL(run->memory, anew.span.odd, anew.found, found);
    return status;
}

vor_status vor_propagate(struct vor_propagation *propagation, const struct vor_run *run,
                         struct vor_error *err)
{
    size_t n = propagation->back.on->n;
    vor_status status =
        VOR_MAKE_ALL(run->memory, err, n, VOR_ZEROED(propagation->planes, n, 1),
                     VOR_ARRAY(propagation->edge, n, propagation->back.graph->most));

    VOR_THEN(status, vor_back_edges(&propagation->back, propagation->edge, run, err));
    VOR_THEN(status, spread(propagation, 0, run, err));
    VOR_THEN(status, vor_run_for(run, n, BLOCK, contradict_block, propagation, err));
    if (status != VOR_OK || memchr(propagation->planes, 1, n) == NULL)
        return status;
    status = try_planes(propagation, run, err);
    VOR_THEN(status, try_hinges(propagation, run, err));
    return status;
}

void vor_propagation_free(struct vor_propagation *propagation, struct vor_memory *memory)
{
    vor_span_free(&propagation->span);
    VOR_FREE_ALL(memory, propagation->planes, propagation->edge);
}
