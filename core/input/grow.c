#include "core/input/grow.h"

#include "core/base/linalg.h"
#include "core/geom/layers.h"
#include "core/geom/surface.h"
#include "core/input/adjacency.h"

#include <math.h>
#include <string.h>

/* Figures are pairs of a point and one in its list that lie on two sheets, in thousands, on shell
 * (two sheets nearer than the spacing, 60,000 points) and arma2 (two surfaces that cross, 120,000):
 * 42 and 227 before, 17 and 159 grown, 7 and 115 with entries dropped. */

enum {
    BLOCK = 256,  /* points of one task */
    ROUNDS = 4,   /* of growing: a round reaches one neighbourhood further. At 8 no better */
    LEADERS = 16, /* of those that are sure, the nearest, whose surfaces are continued. At 30 no
                     better */
    PASSES = 2    /* times that a surface is fitted to those along it. At 4 no better */
};

/* Distance off a surface up to which a point lies along it, in spacings. At 0.12 / 0.15: 17.0, 159
 * / 18.6, 167; with 0.12 and more for those far away 22.4, 179. */
#define ALONG 0.12
/* What a leader's distance counts beside how far its surface is off the place, both in spacings.
 * At 0.05 the same within 3 %. */
#define FAR 0.02

/* The surface fitted to the list of a point, which is its origin. */
struct leaf {
    float axis[2][3], c[6], center[2], reach, spacing; /* as in vor_surface; spacing 0: none */
};

struct growing {
    const struct vor_domain *domain;
    struct vor_graph *graph;
    unsigned char *sure;  /* n: 1 or 0 */
    unsigned char *grown; /* n: 1 where it is from the next round on */
    struct leaf *leaf;    /* n: set where a list is sure */
};

/* The points around one, nearest first. */
struct around {
    unsigned count;
    uint32_t index[VOR_GROW_AROUND];
    float distance2[VOR_GROW_AROUND];
};

static const float *point(const struct growing *growing, uint32_t i)
{
    return &growing->domain->xyz[3 * (size_t)i];
}

static int fit_to(struct vor_surface *out, const struct growing *growing, const uint32_t *index,
                  unsigned n)
{
    vor_surface_fit_to(out, growing->domain->xyz, index, n);
    return out->kind != VOR_SURFACE_NONE;
}

static int fit_list(struct vor_surface *out, const struct growing *growing, uint32_t i)
{
    const struct vor_graph *graph = growing->graph;
    uint32_t index[VOR_ADJACENT + 1];

    index[0] = i;
    memcpy(&index[1], &graph->list[(size_t)i * graph->most], graph->count[i] * sizeof *index);
    return fit_to(out, growing, index, graph->count[i] + 1u);
}

static void keep(struct leaf *out, const struct vor_surface *surface)
{
    for (int a = 0; a < 2; a++) {
        for (int c = 0; c < 3; c++)
            out->axis[a][c] = (float)surface->axis[a][c];
        out->center[a] = (float)surface->center[a];
    }
    for (int c = 0; c < 6; c++)
        out->c[c] = (float)surface->c[c];
    out->reach = (float)surface->reach;
    out->spacing = (float)surface->spacing;
}

/* The surface that was kept of point i. */
static void recall(struct vor_surface *out, const struct growing *growing, uint32_t i)
{
    const struct leaf *leaf = &growing->leaf[i];

    memset(out, 0, sizeof *out);
    out->kind = VOR_SURFACE_QUADRIC;
    for (int a = 0; a < 2; a++) {
        for (int c = 0; c < 3; c++)
            out->axis[a][c] = (double)leaf->axis[a][c];
        out->center[a] = (double)leaf->center[a];
    }
    vor_cross(out->axis[2], out->axis[0], out->axis[1]);
    for (int c = 0; c < 3; c++)
        out->origin[c] = (double)point(growing, i)[c];
    for (int c = 0; c < 6; c++)
        out->c[c] = (double)leaf->c[c];
    out->reach = (double)leaf->reach;
    out->spacing = (double)leaf->spacing;
}

/* Distance of a point from a surface along its normal, in spacings. */
static double off(const struct vor_surface *surface, const float *p)
{
    return fabs(vor_surface_abovef(surface, p)) / surface->spacing;
}

static void rate_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct growing *growing = ctx;

    for (size_t i = begin; i < end; i++) {
        struct vor_surface own;

        growing->sure[i] = 0;
        if (!growing->graph->own[i] || !fit_list(&own, growing, (uint32_t)i) ||
            !(own.spacing > 0) || vor_layers_possible(&own))
            continue;
        keep(&growing->leaf[i], &own);
        growing->sure[i] = 1;
    }
}

/* Finds the surface of those that are sure which leads nearest to point i. */
static int find_leader(struct vor_surface *lead, const struct growing *growing, uint32_t i,
                       const struct around *around)
{
    double best = VOR_GROW_LED;
    unsigned asked = 0;

    for (unsigned j = 1; j < around->count && asked < LEADERS; j++) {
        struct vor_surface surface;
        double here;

        if (!growing->sure[around->index[j]])
            continue;
        asked++;
        recall(&surface, growing, around->index[j]);
        here = off(&surface, point(growing, i)) +
               FAR * (double)around->distance2[j] / (surface.spacing * surface.spacing);
        if (here < best) {
            best = here;
            *lead = surface;
        }
    }
    return best < VOR_GROW_LED;
}

/* Takes those of the points around that lie along a surface; how many they are. */
static unsigned take_along(uint32_t index[VOR_ADJACENT + 1], const struct growing *growing,
                           const struct around *around, const struct vor_surface *surface)
{
    unsigned taken = 1;

    index[0] = around->index[0];
    for (unsigned j = 1; j < around->count && taken <= VOR_ADJACENT; j++)
        if (off(surface, point(growing, around->index[j])) < ALONG)
            index[taken++] = around->index[j];
    return taken;
}

/* Takes n points, the first of which is i, as the list of i, and their surface as its own. */
static void take_list(struct growing *growing, uint32_t i, const uint32_t *index, unsigned n,
                      const struct vor_surface *surface)
{
    struct vor_graph *graph = growing->graph;
    const float *p = point(growing, i);
    double x[3] = {(double)p[0], (double)p[1], (double)p[2]}, local[3], normal[3];
    unsigned count = n - 1 < graph->most ? n - 1 : graph->most;

    graph->count[i] = (unsigned char)count;
    graph->own[i] = 1;
    memcpy(&graph->list[(size_t)i * graph->most], &index[1], count * sizeof *index);
    vor_surface_to_local(surface, x, local);
    vor_surface_normal(surface, local, normal);
    vor_to_floats(&graph->normal[3 * (size_t)i], normal);
    keep(&growing->leaf[i], surface);
    growing->grown[i] = 1;
}

static void grow_point(struct growing *growing, uint32_t i)
{
    const struct vor_domain *domain = growing->domain;
    struct around around = {.count = domain->n < VOR_GROW_AROUND ? (unsigned)domain->n
                                                                 : VOR_GROW_AROUND};
    struct vor_surface before, surface = {.kind = VOR_SURFACE_NONE};
    uint32_t index[VOR_ADJACENT + 1];
    unsigned n = 0;

    if (!fit_list(&before, growing, i) || !vor_layers_possible(&before))
        return;
    vor_knn_search(domain->knn, point(growing, i), 1, around.count, around.index, around.distance2);
    around.index[0] = i; /* which may share its place with another */
    if (!find_leader(&surface, growing, i, &around))
        return;
    for (int pass = 0; pass < PASSES; pass++) {
        n = take_along(index, growing, &around, &surface);
        if (n < VOR_ADJACENT_FEWEST || !fit_to(&surface, growing, index, n) ||
            !(surface.spacing > 0))
            return;
    }
    if (!vor_layers_possible(&surface) && VOR_FINER * surface.off2 <= before.off2)
        take_list(growing, i, index, n, &surface);
}

static void grow_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct growing *growing = ctx;

    for (size_t i = begin; i < end; i++)
        if (!growing->sure[i])
            grow_point(growing, (uint32_t)i);
}

/* Drops those of a list whose own surfaces pass the point by. */
static void drop_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct growing *growing = ctx;
    struct vor_graph *graph = growing->graph;

    for (size_t i = begin; i < end; i++) {
        uint32_t *list = &graph->list[i * graph->most], stay[VOR_ADJACENT];
        unsigned left = 0;

        for (unsigned j = 0; graph->own[i] && j < graph->count[i]; j++) {
            struct vor_surface surface;

            if (growing->sure[list[j]]) {
                recall(&surface, growing, list[j]);
                if (off(&surface, point(growing, (uint32_t)i)) > VOR_GROW_ACROSS)
                    continue;
            }
            stay[left++] = list[j];
        }
        if (left >= VOR_ADJACENT_FEWEST) {
            memcpy(list, stay, left * sizeof *list);
            graph->count[i] = (unsigned char)left;
        }
    }
}

vor_status vor_grow(struct vor_graph *graph, const struct vor_domain *domain,
                    const struct vor_run *run, struct vor_error *err)
{
    struct growing growing = {.domain = domain,
                              .graph = graph,
                              .sure = vor_malloc(run->memory, domain->n, 1),
                              .grown = vor_malloc(run->memory, domain->n, 1),
                              .leaf = vor_malloc(run->memory, domain->n, sizeof *growing.leaf)};
    vor_status status;

    if (growing.sure == NULL || growing.grown == NULL || growing.leaf == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    } else {
        memset(growing.grown, 0, domain->n);
        status = vor_run_for(run, domain->n, BLOCK, rate_block, &growing, err);
    }
    for (int round = 0; round < ROUNDS && status == VOR_OK; round++) {
        status = vor_run_for(run, domain->n, BLOCK, grow_block, &growing, err);
        for (size_t i = 0; i < domain->n; i++) {
            growing.sure[i] |= growing.grown[i];
            growing.grown[i] = 0;
        }
    }
    if (status == VOR_OK)
        status = vor_run_for(run, domain->n, BLOCK, drop_block, &growing, err);
    VOR_FREE_ALL(run->memory, growing.leaf, growing.grown, growing.sure);
    return status;
}
