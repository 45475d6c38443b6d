#include "core/input/orient.h"

#include "core/base/linalg.h"
#include "core/geom/layers.h"
#include "core/input/adjacency.h"
#include "core/input/neighbors.h"
#include "core/input/propagate.h"
#include "core/input/thin.h"

#include <string.h>

/* Figures are points of white noise with the wrong side: of armadillo, 30,000 (three draws), and of
 * fandisk, 30,000 with noise of 0.2 % of the diagonal. */

enum {
    BLOCK = 256, /* points of one task */
    /* Points that make a component of its own: twice what a list has. Without: nine points of
     * armadillo (fifth draw) that no list has are wrong. */
    SMALL = 2 * VOR_ADJACENT
};

/* Weight below which an edge is sure, of the largest one. Edges that are sure and yet join
 * different sides, over the root of the number of points, at 0.03 / 0.05 / 0.1: two Moebius bands
 * 17 and 6.5 at each; armadillo 0 / 0.04 / 0.19, two armadillos that intersect 0.65 / 2.3 / 4.5. */
#define SURE 0.03
/* Flux over the sum of the distances from the middle, below which a component has no inside, over
 * the length of the mean normal: that is 0 where a surface is closed. Measured, flux and mean
 * normal: igea 0.87 and 0, a torus knot of tube 0.12 around a ring of 2 0.08 and 0, a plate 1 x 1 x
 * 0.02 0.12 and 0; autzen, a terrain, 0.09 and 0.62; a half sphere 0.88 and 0.5. */
#define INSIDE 0.5

/* The points to orient and what is found of them. */
struct orient {
    const struct vor_domain *domain; /* all points: normals are fitted to them */
    const struct vor_domain *on;     /* the points to orient */
    const struct vor_graph *graph;   /* of those */
    const struct vor_attribute *carried;
    float *normal;
    float *rough; /* how far, in spacings, the points are off the surface fitted to them */
    struct vor_propagation signs;
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
    if (list.kind != VOR_SURFACE_NONE && list.off2 < VOR_OWN_SHEET * out->off2)
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
        orient->signs.back.at[i] = vor_layers_possible(&surface) ? VOR_BACK : VOR_BACK_NOT;
        if (surface.kind != VOR_SURFACE_NONE) {
            vor_to_doubles(x, &orient->on->xyz[3 * i]);
            vor_surface_to_local(&surface, x, local);
            vor_surface_normal(&surface, local, normal);
        }
        vor_to_floats(&orient->normal[3 * i], normal);
    }
}

static void turn(struct orient *orient)
{
    for (size_t i = 0; i < orient->on->n; i++)
        for (size_t c = 0; orient->signs.span.odd[i] && c < 3; c++)
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
        unsigned edge = orient->signs.edge[i * graph->most + a];
        uint32_t j = graph->list[i * graph->most + a];

        broken += edge % VOR_SPAN_TURNS < SURE * VOR_SPAN_LEVELS &&
                  (orient->signs.span.odd[i] ^ orient->signs.span.odd[j]) != edge / VOR_SPAN_TURNS;
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
        struct component *of = &components[orient->signs.span.component[i]];
        double area = (double)orient->signs.points.area[i];

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
    return of->counted > 0 && fabs(of->agree) > VOR_AGREE * of->counted;
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
        if (components[orient->signs.span.component[index[a]]].points >= SMALL &&
            (double)distance2[a] <= reach2)
            components[orient->signs.span.component[i]].beside +=
                vor_span_vote(vor_propagation_edge(&orient->signs, i, index[a]), 0);
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
        struct component *of = &components[orient->signs.span.component[i]];
        double area = (double)orient->signs.points.area[i], from[3], normal[3];

        vor_to_doubles(from, &orient->on->xyz[3 * i]);
        vor_to_doubles(normal, &orient->normal[3 * i]);
        for (int c = 0; c < 3 && of->area > 0; c++)
            from[c] -= of->middle[c] / of->area;
        of->flux += area * vor_dot(from, normal);
        of->span += area * sqrt(vor_dot(from, from));
    }
    for (size_t i = 0; i < orient->on->n; i++)
        orient->signs.span.odd[i] =
            (unsigned char)faces_inward(&components[orient->signs.span.component[i]]);
    turn(orient);
    /* Small components are on the side of larger ones beside them: too few points were left of
     * their sheet to be joined to it. */
    for (size_t i = 0; i < orient->on->n; i++)
        if (components[orient->signs.span.component[i]].points < SMALL)
            look_beside(components, orient, i);
    for (size_t i = 0; i < orient->on->n; i++) {
        const struct component *of = &components[orient->signs.span.component[i]];

        orient->signs.span.odd[i] = of->beside < 0 && !carried_say(of);
    }
    turn(orient);
    for (size_t i = 0; i < out->components; i++)
        out->one_sided +=
            (double)components[i].broken > VOR_SEAM * sqrt((double)components[i].points);
    vor_free(run->memory, components);
    return VOR_OK;
}

/* Fits normals and finds their signs. */
static vor_status fit_and_spread(struct vor_orientation *out, struct orient *orient,
                                 const struct vor_run *run, struct vor_error *err)
{
    size_t n = orient->on->n;
    struct vor_propagation *signs = &orient->signs;
    float *area = NULL;
    vor_status status =
        VOR_MAKE_ALL(run->memory, err, n, VOR_ARRAY(orient->rough, n, 1), VOR_ARRAY(area, n, 1),
                     VOR_ARRAY(out->normal, n, 3), VOR_ARRAY(out->back, n, 1));

    orient->normal = out->normal;
    signs->back =
        (struct vor_back){orient->on, orient->graph, out->normal, orient->rough, out->back};
    signs->points = (struct vor_winding_points){
        .xyz = orient->on->xyz, .normal = out->normal, .area = area, .least = SMALL};
    signs->vote = orient->domain->known.neighbors.usual <= orient->graph->most;
    VOR_THEN(status, vor_run_for(run, n, BLOCK, normal_block, orient, err));
    VOR_THEN(status, vor_back_find(&signs->back, VOR_VOTES + 1, run, err));
    for (size_t i = 0; i < n && status == VOR_OK; i++)
        area[i] = (float)area_of(orient, i);
    VOR_THEN(status, vor_propagate(signs, run, err));
    if (status == VOR_OK) {
        out->components = signs->span.components;
        turn(orient);
        status = face_outward(out, orient, run, err);
    }
    vor_propagation_free(signs, run->memory);
    VOR_FREE_ALL(run->memory, area, orient->rough);
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
