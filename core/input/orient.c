#include "core/input/orient.h"

#include "core/base/linalg.h"
#include "core/geom/flip.h"
#include "core/geom/layers.h"
#include "core/geom/winding.h"
#include "core/input/adjacency.h"
#include "core/input/back.h"
#include "core/input/neighbors.h"
#include "core/input/thin.h"

#include <string.h>

/* Figures are points of white noise with the wrong side: of armadillo, 30,000 (three draws), and of
 * fandisk, 30,000 with noise of 0.2 % of the diagonal. */

enum {
    BLOCK = 256, /* points of one task */
    /* Rounds in which neighbours vote on single points; and in one more those beside a rim are
     * fitted as it is. At 0 / 3: of armadillo (third draw) 27 / 19 points are wrong. With 3 / 4 of
     * those of a rim, of a blade's 10,000 11 / 8. */
    VOTES = 3,
    /* Points that make a component of its own: twice what a list has. Without: nine points of
     * armadillo (fifth draw) that no list has are wrong. */
    SMALL = 2 * VOR_ADJACENT
};

/* Weight below which an edge is sure, of the largest one. Edges that are sure and yet join
 * different sides, over the root of the number of points, at 0.03 / 0.05 / 0.1: two Moebius bands
 * 17 and 6.5 at each; armadillo 0 / 0.04 / 0.19, two armadillos that intersect 0.65 / 2.3 / 4.5. */
#define SURE 0.03
/* Times the root of the number of points: more such edges than that make a surface one-sided, and
 * more points where it bends back a rim. They cross a seam, which is as long as the surface is
 * wide. Measured: above; and the cow, whose tail touches its body, has 1.1 to 2.0, which is no
 * seam. */
#define SEAM 3.0
/* Flux over the sum of the distances from the middle, below which a component has no inside, over
 * the length of the mean normal: that is 0 where a surface is closed. Measured, flux and mean
 * normal: igea 0.87 and 0, a torus knot of tube 0.12 around a ring of 2 0.08 and 0, a plate 1 x 1 x
 * 0.02 0.12 and 0; autzen, a terrain, 0.09 and 0.62; a half sphere 0.88 and 0.5. */
#define INSIDE 0.5
/* Those carried normals of a component that agree less those that do not, over all of them: beyond
 * it they say the side. Not measured: those of one scan agree (1), random signs do not (0). */
#define AGREE 0.5
/* What must be against a point before its neighbours change its side, for each. At 0 / 0.1 of
 * fandisk's with noise 3 / 0 are wrong for it (three draws), at 0.1 / 0.4 of armadillo's 0 / 1. */
#define OUTVOTE 0.1
/* Mean winding number on a surface, or less its sign, beyond which it is closed. Measured: igea,
 * armadillo, cow 0.5, fandisk with noise 0.7; the depth scan office1 0.04. */
#define CLOSED 0.25
/* Mean square of how far winding numbers are from a half, beyond which a surface is not well
 * closed: between clean closed surfaces, 0.0002 to 0.007, with noise of a third of the spacing
 * 0.04, and a wedge of which a face is on the wrong side, 0.11. */
#define APART 0.06
/* Mean square off the surface of a list over that of the nearest, below which they are two sheets.
 */
#define OWN 0.25

/* What edges weigh more for. */
enum shun {
    SHUN_NOTHING,
    SHUN_APART, /* that the planes of their ends lie apart: two sheets */
    SHUN_ROUGH  /* that an end is off one height; `back` says nothing */
};

/* The points to orient and what is found of them. */
struct orient {
    const struct vor_domain *domain; /* all points: normals are fitted to them */
    const struct vor_domain *on;     /* the points to orient */
    const struct vor_graph *graph;   /* of those */
    const struct vor_attribute *carried;
    float *normal;
    unsigned char *edge;
    float *area;          /* that the points stand for */
    float *rough;         /* how far, in spacings, the points are off the surface fitted to them */
    struct vor_back back; /* where the surface bends back on itself */
    enum shun shun;
    int moved; /* signs spread anew were others than those before */
    struct vor_span span;
};

/* What adds up over a component. */
struct component {
    double area, middle[3], flux, span, normal[3];
    size_t points, broken; /* broken: sure edges that join different sides */
    double agree, counted; /* of carried normals */
    double beside;         /* votes of larger components */
};

/* Fits the surface at point i to its list: points of its own sheet. */
static void fit_list(struct vor_surface *out, const struct orient *orient, size_t i)
{
    const struct vor_graph *graph = orient->graph;
    float near[3 * (VOR_ADJACENT + 1)];

    memcpy(near, &orient->on->xyz[3 * i], 3 * sizeof *near);
    for (unsigned a = 0; a < graph->count[i]; a++)
        memcpy(&near[3 * (a + 1)], &orient->on->xyz[3 * (size_t)graph->list[i * graph->most + a]],
               3 * sizeof *near);
    vor_surface_fit(out, near, graph->count[i] + 1u);
}

/* Fits the surface at point i: to its list where a fit takes as few, else to the nearest of all;
 * unless these are of two sheets: not all of them are in the list, and they lie off their surface
 * where the list does not. */
static void fit_at(struct vor_surface *out, const struct orient *orient, size_t i,
                   struct vor_knn_last *last)
{
    const struct vor_graph *graph = orient->graph;
    const float *x = &orient->on->xyz[3 * i];
    unsigned k = vor_neighbors_at(&orient->domain->known.neighbors, x), count = graph->count[i];
    uint32_t index[VOR_NEIGHBORS_MAX];
    float near[3 * VOR_NEIGHBORS_MAX], distance2[VOR_NEIGHBORS_MAX];
    struct vor_surface list;

    k = k < orient->domain->n ? k : (unsigned)orient->domain->n;
    if (k <= graph->most) {
        fit_list(out, orient, i);
        return;
    }
    vor_knn_search_next(orient->domain->knn, last, x, k, index, distance2);
    memcpy(near, x, 3 * sizeof *near);
    for (unsigned a = 1; a < k; a++)
        memcpy(&near[3 * a], &orient->domain->xyz[3 * (size_t)index[a]], 3 * sizeof *near);
    vor_surface_fit(out, near, k);
    if (count == 0 ||
        vor_distance2f(x, &orient->on->xyz[3 * (size_t)graph->list[i * graph->most + count - 1]]) <=
            (double)distance2[count])
        return;
    fit_list(&list, orient, i);
    if (list.kind != VOR_SURFACE_NONE && list.off2 < OWN * out->off2)
        *out = list;
}

static void normal_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct orient *orient = ctx;
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++) {
        struct vor_surface surface;
        double x[3], local[3], normal[3];

        fit_at(&surface, orient, i, &last);
        vor_to_doubles(normal, &orient->graph->normal[3 * i]);
        orient->rough[i] =
            surface.spacing > 0 ? (float)(sqrt(surface.off2) / surface.spacing) : 1.f;
        orient->back.at[i] = vor_layers_possible(&surface) ? VOR_BACK : VOR_BACK_NOT;
        if (surface.kind != VOR_SURFACE_NONE) {
            vor_to_doubles(x, &orient->on->xyz[3 * i]);
            vor_surface_to_local(&surface, x, local);
            vor_surface_normal(&surface, local, normal);
        }
        vor_to_floats(&orient->normal[3 * i], normal);
    }
}

/* The byte of vor_span_make for the edge from i to j. One along a normal weighs as much as one
 * between normals at right angles; at 0 / 1 / 2 of that: armadillo 75, 14, 15 / 30, 16, 15 / 31,
 * 16, 15; fandisk 6569 / 0 / 0. */
static unsigned char edge_of(const struct orient *orient, size_t i, size_t j)
{
    double x[3], y[3], m[3], n[3], along[3], length2, a, b, mirrored, steep, weight, more = 0;

    vor_to_doubles(x, &orient->on->xyz[3 * i]);
    vor_to_doubles(y, &orient->on->xyz[3 * j]);
    vor_to_doubles(m, &orient->normal[3 * i]);
    vor_to_doubles(n, &orient->normal[3 * j]);
    for (int c = 0; c < 3; c++)
        along[c] = y[c] - x[c];
    length2 = fmax(vor_dot(along, along), 1e-300);
    a = vor_dot(m, along);
    b = vor_dot(n, along);
    /* m - 2 (m along) along / length2 is m, mirrored at the plane midway. */
    mirrored = vor_dot(m, n) - 2 * a * b / length2;
    steep = fmax(a * a, b * b) / length2;
    weight = fmax(0, 1 - fabs(mirrored) + steep);
    if (orient->shun == SHUN_ROUGH)
        more = fmin(1, fmax((double)orient->rough[i], (double)orient->rough[j]));
    else if (orient->back.at[i] == VOR_BACK_BESIDE || orient->back.at[j] == VOR_BACK_BESIDE)
        more = 1;
    else if (orient->shun == SHUN_APART) /* 0 on an arc, and across an edge */
        more = (a * a + b * b + (mirrored < 0 ? -2 : 2) * a * b) / (4 * length2);
    return vor_span_edge((weight + more) / (2 + (orient->shun == SHUN_ROUGH)), mirrored < 0);
}

static void edge_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct orient *orient = ctx;
    const struct vor_graph *graph = orient->graph;

    for (size_t i = begin; i < end; i++)
        if (orient->back.at[i] != VOR_BACK || orient->shun == SHUN_ROUGH)
            for (unsigned a = 0; a < graph->count[i]; a++)
                orient->edge[i * graph->most + a] =
                    edge_of(orient, i, graph->list[i * graph->most + a]);
}

static void turn(struct orient *orient)
{
    for (size_t i = 0; i < orient->on->n; i++)
        for (size_t c = 0; orient->span.odd[i] && c < 3; c++)
            orient->normal[3 * i + c] = -orient->normal[3 * i + c];
}

/* Area that a point stands for: the disc of its neighbours, shared among them, less of it the fewer
 * of them are near to it in turn: a stray's disc is as wide as it is far. */
static double area_of(const struct orient *orient, size_t i)
{
    const struct vor_graph *graph = orient->graph;
    const uint32_t *list = &graph->list[i * graph->most];
    unsigned count = graph->count[i], mutual = 0;
    const float *xyz = orient->on->xyz;

    for (unsigned a = 0; a < count; a++)
        mutual += (unsigned)vor_graph_has(graph, list[a], (uint32_t)i);
    return mutual == 0 ? 0
                       : M_PI * vor_distance2f(&xyz[3 * i], &xyz[3 * (size_t)list[count - 1]]) *
                             mutual / (count * count);
}

/* Counts the sure edges of point i that join different sides. */
static size_t broken_at(const struct orient *orient, size_t i)
{
    const struct vor_graph *graph = orient->graph;
    size_t broken = 0;

    for (unsigned a = 0; a < graph->count[i]; a++) {
        unsigned edge = orient->edge[i * graph->most + a];
        uint32_t j = graph->list[i * graph->most + a];

        broken += edge % VOR_SPAN_TURNS < SURE * VOR_SPAN_LEVELS &&
                  (orient->span.odd[i] ^ orient->span.odd[j]) != edge / VOR_SPAN_TURNS;
    }
    return broken;
}

/* Counts whether the carried normal of point i agrees. */
static void compare_carried(struct component *of, const struct orient *orient, size_t i)
{
    const struct vor_attribute *carried = orient->carried;
    double normal[3], own[3], along;

    vor_to_doubles(own, &orient->normal[3 * i]);
    for (size_t c = 0; c < 3; c++)
        normal[c] =
            vor_attribute_scalar(carried, orient->on->source[i] * (size_t)carried->components + c);
    along = vor_dot(normal, own);
    if (!isfinite(along) || along == 0)
        return;
    of->counted++;
    of->agree += along > 0 ? 1 : -1;
}

static void add_up(struct component *components, const struct orient *orient)
{
    for (size_t i = 0; i < orient->on->n; i++) {
        struct component *of = &components[orient->span.component[i]];
        double area = (double)orient->area[i];

        of->points++;
        of->area += area;
        of->broken += broken_at(orient, i);
        for (size_t c = 0; c < 3; c++) {
            of->middle[c] += area * (double)orient->on->xyz[3 * i + c];
            of->normal[c] += area * (double)orient->normal[3 * i + c];
        }
        if (orient->carried != NULL)
            compare_carried(of, orient, i);
    }
}

static int carried_say(const struct component *of)
{
    return of->counted > 0 && fabs(of->agree) > AGREE * of->counted;
}

/* Whether a component faces the wrong way. */
static int faces_inward(const struct component *of)
{
    double largest = 0;

    if (carried_say(of))
        return of->agree < 0;
    if (fabs(of->flux) * of->area > INSIDE * of->span * sqrt(vor_dot(of->normal, of->normal)))
        return of->flux < 0;
    for (int c = 2; c >= 0; c--)
        if (fabs(of->normal[c]) > fabs(largest))
            largest = of->normal[c];
    return largest < 0;
}

/* Adds up what points of larger components around say of the side of point i. */
static void look_beside(struct component *components, const struct orient *orient, size_t i)
{
    const struct vor_domain *on = orient->on;
    const struct vor_graph *graph = orient->graph;
    const float *x = &on->xyz[3 * i];
    unsigned k = on->n < SMALL ? (unsigned)on->n : SMALL, count = graph->count[i];
    uint32_t index[SMALL];
    float distance2[SMALL];
    double reach2;

    if (count == 0)
        return;
    reach2 = vor_distance2f(x, &on->xyz[3 * (size_t)graph->list[i * graph->most + count - 1]]);
    vor_knn_search(on->knn, x, 1, k, index, distance2);
    for (unsigned a = 0; a < k; a++)
        if (components[orient->span.component[index[a]]].points >= SMALL &&
            (double)distance2[a] <= reach2)
            components[orient->span.component[i]].beside +=
                vor_span_vote(edge_of(orient, i, index[a]), 0);
}

/* Turns the components outward and counts those with one side. */
static vor_status face_outward(struct vor_orientation *out, struct orient *orient,
                               const struct vor_run *run, struct vor_error *err)
{
    struct component *components = vor_calloc(run->memory, out->components, sizeof *components);

    if (components == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu parts", out->components);
    add_up(components, orient);
    /* Adds up what needs the middles. */
    for (size_t i = 0; i < orient->on->n; i++) {
        struct component *of = &components[orient->span.component[i]];
        double area = (double)orient->area[i], from[3], normal[3];

        vor_to_doubles(from, &orient->on->xyz[3 * i]);
        vor_to_doubles(normal, &orient->normal[3 * i]);
        for (int c = 0; c < 3 && of->area > 0; c++)
            from[c] -= of->middle[c] / of->area;
        of->flux += area * vor_dot(from, normal);
        of->span += area * sqrt(vor_dot(from, from));
    }
    for (size_t i = 0; i < orient->on->n; i++)
        orient->span.odd[i] = (unsigned char)faces_inward(&components[orient->span.component[i]]);
    turn(orient);
    /* Small components are on the side of larger ones beside them: too few points were left of
     * their sheet to be joined to it. */
    for (size_t i = 0; i < orient->on->n; i++)
        if (components[orient->span.component[i]].points < SMALL)
            look_beside(components, orient, i);
    for (size_t i = 0; i < orient->on->n; i++) {
        const struct component *of = &components[orient->span.component[i]];

        orient->span.odd[i] = of->beside < 0 && !carried_say(of);
    }
    turn(orient);
    for (size_t i = 0; i < out->components; i++)
        out->one_sided += (double)components[i].broken > SEAM * sqrt((double)components[i].points);
    vor_free(run->memory, components);
    return VOR_OK;
}

/* Signs spread once more. */
struct anew {
    const struct orient *orient;
    struct vor_span span;
    struct vor_winding_found *found; /* of each component */
};

/* Every point whose neighbours mostly say so changes its side, in the order of the points. */
static void outvote(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct orient *orient = ((struct anew *)ctx)->orient;
    const struct vor_graph *graph = orient->graph;
    unsigned char *odd = ((struct anew *)ctx)->span.odd;

    for (size_t i = begin; i < end; i++) {
        double vote = 0;

        for (unsigned a = 0; a < graph->count[i]; a++)
            vote += vor_span_vote(orient->edge[i * graph->most + a],
                                  odd[i] ^ odd[graph->list[i * graph->most + a]]);
        odd[i] ^= vote < -OUTVOTE * graph->count[i];
    }
}

/* Spreads the signs anew, by votes, and turns what faces the wrong way by itself: patches, then
 * points. */
static vor_status spread_anew(struct anew *anew, const struct vor_winding_points *points,
                              const struct vor_run *run, struct vor_error *err)
{
    const struct orient *orient = anew->orient;
    size_t n = orient->on->n;
    vor_status status = vor_span_make(&anew->span, orient->graph, orient->edge, 1, run, err);

    VOR_THEN(status, vor_winding_turn(&anew->span, points, run, err));
    for (unsigned k = 0; k < VOTES && status == VOR_OK; k++)
        status = vor_run_for(run, n, n, outvote, anew, err); /* one task: their order decides */
    VOR_THEN(status, vor_winding_find(anew->found, &anew->span, points, run, err));
    return status;
}

static int is_closed(const struct vor_winding_found *found)
{
    return fabs(found->mean) >= CLOSED;
}

/* Whether a component takes signs spread anew: by votes, unless the first ones close it far better;
 * across some edges last, where that closes it far better. */
static int takes(enum shun shun, const struct vor_winding_found *was,
                 const struct vor_winding_found *now)
{
    if (shun == SHUN_NOTHING)
        return is_closed(was) && now->apart < 2 * was->apart;
    return (shun == SHUN_APART || was->apart >= APART) && is_closed(now) &&
           now->apart <= was->apart / 2;
}

/* Spreads signs anew, over the edges as they weigh now, and takes those that are better. */
static vor_status try_anew(struct orient *orient, struct vor_winding_found *found,
                           const struct vor_winding_points *points, const struct vor_run *run,
                           struct vor_error *err)
{
    struct anew anew = {.orient = orient};
    vor_status status;

    anew.found = vor_malloc(run->memory, orient->span.components, sizeof *anew.found);
    if (anew.found == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu parts", orient->span.components);
    status = spread_anew(&anew, points, run, err);
    for (size_t i = 0; i < orient->on->n && status == VOR_OK; i++) {
        uint32_t c = orient->span.component[i];

        if (takes(orient->shun, &found[c], &anew.found[c]))
            orient->span.odd[i] = anew.span.odd[i];
    }
    for (size_t c = 0; c < orient->span.components && status == VOR_OK; c++) {
        orient->moved |=
            found[c].apart < anew.found[c].apart || found[c].apart > anew.found[c].apart;
        if (takes(orient->shun, &found[c], &anew.found[c]))
            found[c] = anew.found[c];
    }
    vor_span_free(&anew.span);
    vor_free(run->memory, anew.found);
    return status;
}

/* Tries signs spread across some edges last: faces may be joined that lie on different sides. */
static vor_status close_up(struct orient *orient, enum shun shun, struct vor_winding_found *found,
                           const struct vor_winding_points *points, const struct vor_run *run,
                           struct vor_error *err)
{
    vor_status status;

    orient->shun = shun;
    status = vor_run_for(run, orient->on->n, BLOCK, edge_block, orient, err);
    VOR_THEN(status, try_anew(orient, found, points, run, err));
    if (shun == SHUN_ROUGH)
        VOR_THEN(status, vor_back_edges(&orient->back, orient->edge, run, err));
    orient->shun = SHUN_NOTHING;
    VOR_THEN(status, vor_run_for(run, orient->on->n, BLOCK, edge_block, orient, err));
    return status;
}

/* Mends the signs of components that are closed, or can be. */
static vor_status mend(struct orient *orient, const struct vor_winding_points *points,
                       const struct vor_run *run, struct vor_error *err)
{
    size_t components = orient->span.components, closed = 0, apart = 0;
    struct vor_winding_found *found = vor_malloc(run->memory, components, sizeof *found);
    vor_status status;

    if (found == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu parts", components);
    status = vor_winding_find(found, &orient->span, points, run, err);
    for (size_t c = 0; c < components && status == VOR_OK; c++)
        closed += is_closed(&found[c]);
    if (status == VOR_OK && closed > 0 &&
        orient->domain->known.neighbors.usual <=
            orient->graph->most) { /* else noise: lists are too short */
        status = try_anew(orient, found, points, run, err);
        if (status == VOR_OK && orient->moved) /* else no sign is in doubt */
            status = close_up(orient, SHUN_APART, found, points, run, err);
    }
    for (size_t c = 0; c < components && status == VOR_OK; c++)
        apart += found[c].apart >= APART;
    if (status == VOR_OK && apart > 0)
        status = close_up(orient, SHUN_ROUGH, found, points, run, err);
    vor_free(run->memory, found);
    return status;
}

/* Spreads signs over the graph, and turns components outward. */
static vor_status spread(struct vor_orientation *out, struct orient *orient,
                         const struct vor_run *run, struct vor_error *err)
{
    float *area = vor_malloc(run->memory, orient->on->n, sizeof *area);
    struct vor_winding_points points = {orient->on->xyz, orient->normal, area, SMALL};
    const struct vor_flip_how how = {
        .doubt = OUTVOTE, .margin = AGREE, .closed = CLOSED, .apart = APART, .clean = APART / 4};
    size_t dropped = 0;
    vor_status status;

    if (area == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", orient->on->n);
    for (size_t i = 0; i < orient->on->n; i++)
        area[i] = (float)area_of(orient, i);
    orient->area = area;
    status = vor_span_make(&orient->span, orient->graph, orient->edge, 0, run, err);
    VOR_THEN(status, vor_back_drop(&dropped, &orient->back, &orient->span, SEAM, err));
    if (dropped > 0) { /* their edges are like all others */
        vor_span_free(&orient->span);
        VOR_THEN(status, vor_run_for(run, orient->on->n, BLOCK, edge_block, orient, err));
        VOR_THEN(status, vor_span_make(&orient->span, orient->graph, orient->edge, 0, run, err));
    }
    VOR_THEN(status, mend(orient, &points, run, err));
    if (status == VOR_OK)
        status =
            vor_flip_regions(&orient->span, orient->graph, orient->edge, &points, &how, run, err);
    if (status == VOR_OK) {
        out->components = orient->span.components;
        turn(orient);
        status = face_outward(out, orient, run, err);
    }
    vor_free(run->memory, area);
    vor_span_free(&orient->span);
    return status;
}

/* Fits normals and finds their signs. */
static vor_status fit_and_spread(struct vor_orientation *out, struct orient *orient,
                                 const struct vor_run *run, struct vor_error *err)
{
    size_t n = orient->on->n;
    vor_status status = VOR_MAKE_ALL(run->memory, err, n, VOR_ARRAY(orient->rough, n, 1),
                                     VOR_ARRAY(orient->edge, n, orient->graph->most),
                                     VOR_ARRAY(out->normal, n, 3), VOR_ARRAY(out->back, n, 1));

    orient->normal = out->normal;
    orient->back =
        (struct vor_back){orient->on, orient->graph, out->normal, orient->rough, out->back};
    VOR_THEN(status, vor_run_for(run, n, BLOCK, normal_block, orient, err));
    VOR_THEN(status, vor_back_find(&orient->back, VOTES + 1, run, err));
    VOR_THEN(status, vor_back_edges(&orient->back, orient->edge, run, err));
    VOR_THEN(status, vor_run_for(run, n, BLOCK, edge_block, orient, err));
    VOR_THEN(status, spread(out, orient, run, err));
    VOR_FREE_ALL(run->memory, orient->rough, orient->edge);
    return status;
}

/* Thins the domain if it has many points for each one of the result. */
static vor_status thin_out(struct vor_domain *out, const struct vor_domain *domain,
                           const struct vor_orient_how *how, const struct vor_run *run,
                           struct vor_error *err)
{
    double fewer = (double)VOR_NEIGHBORS_FEWEST / domain->known.neighbors.most;
    double wanted = fmin(VOR_THIN_EACH * (double)how->points, fmin(1, fewer) * (double)domain->n);

    wanted = fmax(wanted, VOR_THIN_LEAST);
    if ((double)domain->n < 2 * wanted || !(how->area > 0))
        return VOR_OK;
    return vor_domain_thin(out, domain, sqrt(how->area / wanted), run, err);
}

/* The lists of the points to orient. */
static vor_status make_lists(struct vor_graph *out, const struct vor_domain *on, int plain,
                             const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    if (!plain || on->n <= VOR_ADJACENT)
        return vor_adjacency_make(out, on, run, err);
    status = vor_graph_init(out, on->n, VOR_ADJACENT, run->memory, err);
    VOR_THEN(status, vor_graph_nearest(out, on->knn, on->xyz, VOR_ADJACENT, run, err));
    return status;
}

vor_status vor_orient(struct vor_orientation *out, const struct vor_domain *domain,
                      const struct vor_orient_how *how, const struct vor_run *run,
                      struct vor_error *err)
{
    struct vor_orientation made = {.components = 0};
    struct orient orient = {.domain = domain, .on = domain, .carried = how->carried};
    struct vor_graph own = {.n = 0};
    vor_status status = thin_out(&made.thin, domain, how, run, err);

    if (status == VOR_OK && made.thin.n > 0)
        orient.on = &made.thin;
    orient.graph = orient.on == domain && vor_graph_is(&domain->graph) ? &domain->graph : &own;
    if (orient.graph == &own)
        VOR_THEN(status, make_lists(&own, orient.on, how->plain, run, err));
    VOR_THEN(status, fit_and_spread(&made, &orient, run, err));
    vor_graph_free(&own);
    if (status == VOR_OK)
        *out = made;
    else
        vor_orientation_free(&made, run->memory);
    return status;
}
