#include "core/input/adjacency.h"

#include "core/base/linalg.h"
#include "core/geom/layers.h"
#include "core/geom/plane.h"
#include "core/geom/surface.h"
#include "core/input/noisy.h"
#include "core/input/sheets.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* Figures are delta of a result, and for the cow and the armadillos rms distance to the true
 * surface in 1e-4 of its diagonal: `cow` 20,000 points of white noise to 80,000 (without lists
 * 0.086, 4.9), `room` the depth scan scannet to 10,000 (0.059), `arma2` two armadillos through each
 * other, 120,000 to 480,000, delta to the nearest point of the same one (0.149, 4.6). Other seeds
 * move cow by 0.001 and 0.03. */

enum {
    BLOCK = 256, /* points of one task */
    /* Points of a short list. At 10 / 12: cow 0.059, 3.86 / 0.056, 3.93; without, 0.061, 4.12. Fits
     * to fewer than 10 would follow noise. */
    SHORT = VOR_REFINED_TO,
    /* Times that planes and lists are made, each time from the lists before. At 1 / 2 / 3: cow
     * 0.068 / 0.063 / 0.063, room 0.0474 / 0.0459 / 0.0459; at 1 / 2 arma2 0.134, 3.8 / 0.117, 3.4.
     */
    ROUNDS = 2,
    /* Places that are looked at to find out whether lists pay: so many that cow has nine with the
     * signs below. */
    PLACES = 1024
};

/* An edge between normals whose cosine is more than AGREE joins two sheets if the sine of it over
 * the surface is more than STEEP: on a curved surface the normals of a steep edge turn. Pairs
 * across on four plates 1 x 1 x 0.02 (at their rims) with AGREE 0.8 / 0.9 / none: 4 / 1 / 192; with
 * STEEP 0.5 / 0.7: 1 / 1; cow 0.057, 3.92 / 0.057, 3.92; triangles across of a gear with thin walls
 * 0.0027 / 0.0014. */
#define AGREE 0.9
#define STEEP 0.7
/* Of the cost of a plane: a point keeps its own unless another one is clearly better. */
#define KEEP 0.7

/* The probe's signs of a second sheet, all of them at a place: the nearest points lie so far off
 * one surface that VOR_OWN_SHEET of their variance alone would make layers possible; the list's
 * variance is less than VOR_OWN_SHEET of theirs; its spacing more than PROBE_SPARSER; what the walk
 * left out lies over it (input/sheet_walk.h). Share of the points with these signs, in %:
 * arma2 11.5, room 5.2, shell 4.3, autzen 1.1, cow 0.85; office1 0.16 (depth in steps),
 * armadillo_vox120k 0.07, fandisk 0.04, bunny 0.03, igea 0.01. Without the last fandisk has 9,
 * without PROBE_SPARSER office1 9.7.
 */
#define PROBE_SPARSER 1.2
/* Radius of the list over that of a disc of as many points: scan lines are longer. At 1.3 / 1.5 /
 * none, of 1,024 places: kitti 7 / 16 / 17, cow 9 / 10 / 11, room 39 / 46 / 48, arma2 106 / 118 /
 * 122. On kitti lists raise delta by 3 % (mean of five seeds). */
#define PROBE_ROUND 1.3
/* Share of the places with the signs from which on lists are made: half and double decide
 * differently about kitti (0.7 %) and cow (0.9 %). As many points near places with a second sheet
 * over them make a spot with sheets: two balls one spacing apart, of 500 to 50,000 points each,
 * have 8 and more, armadillo 4, bunny and igea 0. */
#define PROBE_SHARE 0.0075
/* Places of one task; if they are all the points, walks of neighbouring tasks meet the same. */
enum { PROBE_BLOCK = 64, PROBE_BLOCK_ALL = BLOCK };

/* What is known of a point. */
struct known {
    struct vor_plane plane;
    unsigned char layer;  /* the list is that of a layer, and stays */
    unsigned char single; /* the nearest points lie well on one surface */
    unsigned char over;   /* what the last walk left out lies over what it reached */
};

struct make {
    const struct vor_domain *domain;
    struct vor_graph *graph;
    struct known *known;
    unsigned char *noisy; /* n: the list keeps the nearest points */
    int layers;           /* they are looked for, and nothing else */
};

/* Takes n points, of which i is one, as the list of i. */
static void set_list(struct vor_graph *graph, size_t i, const uint32_t *index, unsigned n)
{
    unsigned taken = 0;

    for (unsigned j = 0; j < n && taken < graph->most; j++)
        if (index[j] != i)
            graph->list[i * graph->most + taken++] = index[j];
    graph->count[i] = (unsigned char)taken;
}

static void nearest_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct make *make = ctx;
    struct vor_graph *graph = make->graph;
    uint32_t index[VOR_ADJACENT + 1];
    float distance2[VOR_ADJACENT + 1];
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++) {
        vor_knn_search_next(make->domain->knn, &last, vor_domain_point(make->domain, i),
                            graph->most + 1, index, distance2);
        set_list(graph, i, index, graph->most + 1);
        make->known[i].layer = make->known[i].single = make->known[i].over = 0;
        vor_plane_fit(&make->known[i].plane, make->domain->xyz, index,
                      vor_domain_most(make->domain, VOR_PLANE_POINTS));
    }
}

static void plane_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct make *make = ctx;
    struct vor_graph *graph = make->graph;
    const uint32_t *list = &graph->list[i * graph->most];
    const float *x = vor_domain_point(make->domain, i);
    unsigned last = graph->count[i] < VOR_PLANE_POINTS - 1 ? graph->count[i] : VOR_PLANE_POINTS - 1;
    double r2 = vor_distance2f(x, vor_domain_point(make->domain, list[last - 1]));
    const struct vor_plane *take = &make->known[i].plane;
    double best = KEEP * vor_plane_cost(take, x, r2);

    for (unsigned j = 0; j < last; j++) {
        const struct vor_plane *plane = &make->known[list[j]].plane;
        double here = vor_plane_cost(plane, x, r2);

        if (here < best) {
            best = here;
            take = plane;
        }
    }
    memcpy(&graph->normal[3 * i], take->normal, sizeof take->normal);
}

/* Takes n points as those that fits at i are made to, and their surface's plane as that of i. */
static void set_own(struct make *make, size_t i, const uint32_t *index, unsigned n,
                    const struct vor_surface *surface)
{
    struct vor_plane *plane = &make->known[i].plane;
    double local[3], normal[3], x[3];

    set_list(make->graph, i, index, n);
    make->graph->own[i] = 1;
    for (unsigned c = 0; c < 3; c++)
        x[c] = (double)vor_domain_point(make->domain, i)[c];
    vor_surface_to_local(surface, x, local);
    vor_surface_normal(surface, local, normal);
    for (unsigned c = 0; c < 3; c++) {
        plane->middle[c] = (float)x[c];
        plane->normal[c] = (float)normal[c];
    }
    plane->flatness = (float)(surface->off2 / (surface->reach * surface->reach));
}

static void give_normals(struct vor_walk *walk, const struct make *make)
{
    for (unsigned j = 0; j < walk->most; j++) {
        const float *normal = &make->graph->normal[3 * (size_t)walk->index[j]];

        for (int c = 0; c < 3; c++)
            walk->normal[c][j] = normal[c];
    }
}

/* Cuts a list of n points to the nearest few where a surface fits these far better: lists of thin
 * parts hold points from round the corner. Returns how many are left. Fits to these few beside
 * lists of all n: armadillo's normals on the wrong side, ten draws of 30,000, 118 instead of 68. At
 * 1 / VOR_FINER / 4 times less variance: cow 0.060, 3.88 / 0.056, 3.93 / 0.060, 4.02. */
static unsigned shorten(struct vor_surface *own, const struct vor_domain *domain,
                        const uint32_t *index, unsigned n)
{
    struct vor_surface few;

    if (n < SHORT + 3 || !vor_surface_fit_to(&few, domain->xyz, index, SHORT) ||
        VOR_FINER * few.off2 * SHORT / (SHORT - VOR_QUADRIC_TERMS) >
            own->off2 * n / (n - VOR_QUADRIC_TERMS))
        return n;
    *own = few;
    return SHORT;
}

/* Whether layers are looked for around point i. */
static int may_have_layers(const struct vor_domain *domain, size_t i)
{
    const float *p = vor_domain_point(domain, i);

    return domain->known.sheets ||
           vor_sheets_at(&domain->known.sheeted,
                         (double[3]){(double)p[0], (double)p[1], (double)p[2]});
}

/* Finds the sheet of point i: among layers, or by walks. */
static void find_sheet(struct make *make, size_t i, struct vor_sheets_recent *recent,
                       struct vor_knn_last *last)
{
    const struct vor_domain *domain = make->domain;
    struct known *known = &make->known[i];
    struct vor_walk walk;
    struct vor_surface plain, own;
    uint32_t index[VOR_NEIGHBORS_MAX];
    unsigned n;

    if (known->layer || known->single || (!make->layers && make->noisy[i]) ||
        (make->layers && !may_have_layers(domain, i)))
        return;
    known->single = !vor_sheet_walk_begin(&plain, domain, (uint32_t)i, last);
    if (known->single)
        return;
    if (make->layers) {
        const float *p = vor_domain_point(domain, i);

        n = vor_sheets_list(index, domain, (double[3]){(double)p[0], (double)p[1], (double)p[2]},
                            vor_domain_most(domain, VOR_ADJACENT), recent);
        if (n >= VOR_ADJACENT_FEWEST && vor_surface_fit_to(&own, domain->xyz, index, n)) {
            set_own(make, i, index, n, &own);
            known->layer = 1;
        }
        return;
    }
    vor_sheet_walk_gather(&walk, domain, (uint32_t)i);
    n = vor_sheet_walk_carried(&walk, &own, &plain, domain, index);
    if (n == 0) {
        give_normals(&walk, make);
        n = vor_sheet_walk_go(&walk, &own, &plain, domain, index);
    }
    if (n > 0) {
        known->over = domain->known.lists == VOR_LISTS_FEW &&
                      vor_sheet_walk_left_over(&walk, &own, domain, index, n);
        n = shorten(&own, domain, index, n);
        set_own(make, i, index, n, &own);
    }
}

static void sheet_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct vor_sheets_recent recent = {.count = 0};
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++)
        find_sheet(ctx, i, &recent, &last);
}

/* Whether the edge from i to j rises over the plane of i by a larger sine. */
static int rises(const struct make *make, size_t i, size_t j, double sine)
{
    const float *x = vor_domain_point(make->domain, i), *y = vor_domain_point(make->domain, j);
    const float *normal = &make->graph->normal[3 * i];
    double across = 0;

    for (int c = 0; c < 3; c++)
        across += ((double)y[c] - (double)x[c]) * (double)normal[c];
    return across * across > sine * sine * vor_distance2f(x, y);
}

/* Whether an entry of the list of point i lies steeply over it: perhaps on another sheet. */
static int has_steep(const struct make *make, size_t i)
{
    const struct vor_graph *graph = make->graph;

    for (unsigned j = 0; j < graph->count[i]; j++)
        if (rises(make, i, graph->list[i * graph->most + j], vor_sheet_arcs[0]))
            return 1;
    return 0;
}

/* What is left: points without a sheet of their own whose nearest lie badly on one surface, or
 * steeply, as at creases. Fits stay with the nearest points, but the list keeps to what a walk
 * reaches. */
static void rest_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct make *make = ctx;
    const struct vor_domain *domain = make->domain;
    struct vor_walk walk;
    uint32_t index[VOR_ADJACENT + 1];

    for (size_t i = begin; i < end; i++) {
        unsigned n = 0;

        if (make->graph->own[i] || make->noisy[i] || (make->known[i].single && !has_steep(make, i)))
            continue;
        vor_sheet_walk_gather(&walk, domain, (uint32_t)i);
        give_normals(&walk, make);
        for (unsigned a = 0; a < VOR_SHEET_ARCS && n < VOR_ADJACENT_FEWEST; a++) {
            walk.arc = vor_sheet_arcs[a];
            walk.enough = vor_domain_most(domain, VOR_ADJACENT + 1);
            vor_walk_go(&walk);
            n = vor_sheet_walk_take(&walk, vor_domain_most(domain, VOR_ADJACENT + 1), index);
        }
        if (n >= VOR_ADJACENT_FEWEST)
            set_list(make->graph, i, index, n);
    }
}

/* Gives points their nearest again where no second sheet lies over their list or one near them: at
 * creases. At the edge of a second sheet it lies beside lists. With theirs too, gears with two
 * spots of thin walls have .00132 of their triangles across, without .0007; without those at edges
 * triangles lead across in 17 of 24 draws of two balls one spacing apart, with them in 0. */
static void smooth_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct make *make = ctx;
    struct vor_graph *graph = make->graph;
    uint32_t index[VOR_ADJACENT + 1];
    float distance2[VOR_ADJACENT + 1];

    for (size_t i = begin; i < end; i++) {
        int over = make->known[i].layer;

        if (!graph->own[i])
            continue;
        vor_knn_search(make->domain->knn, vor_domain_point(make->domain, i), 1, graph->most + 1,
                       index, distance2);
        for (unsigned j = 0; j <= graph->most && !over; j++)
            over = make->known[index[j]].over;
        if (over)
            continue;
        set_list(graph, i, index, graph->most + 1);
        graph->own[i] = 0;
    }
}

/* Whether j lies over i and not beside it: their normals agree, and the edge runs along them. */
static int lies_steep(const struct make *make, size_t i, size_t j)
{
    double cosine = vor_dotf(&make->graph->normal[3 * i], &make->graph->normal[3 * j]);

    return cosine * cosine > AGREE * AGREE && rises(make, i, j, STEEP);
}

/* Drops those entries of lists that lie over their point. */
static void drop_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct make *make = ctx;
    struct vor_graph *graph = make->graph;
    uint32_t *list = &graph->list[i * graph->most], stay[VOR_ADJACENT];
    unsigned left = 0;

    for (unsigned j = 0; j < graph->count[i]; j++)
        if (make->noisy[i] || !lies_steep(make, i, list[j]))
            stay[left++] = list[j];
    if (left >= VOR_ADJACENT_FEWEST) {
        memcpy(list, stay, left * sizeof *list);
        graph->count[i] = (unsigned char)left;
    }
}

static vor_status make_lists(struct make *make, const struct vor_run *run, struct vor_error *err)
{
    size_t n = make->domain->n;
    vor_status status = vor_run_for(run, n, BLOCK, nearest_block, make, err);

    /* Where two layers are known, their nearest points are those of one: they are no noise. */
    for (int round = 0; status == VOR_OK && round < ROUNDS; round++) {
        status = vor_run_rows(run, n, BLOCK, plane_row, make, err);
        make->layers =
            round == 0 && (make->domain->known.sheets || make->domain->known.sheeted.count > 0);
        if (status == VOR_OK && make->layers)
            status = vor_run_for(run, n, BLOCK, sheet_block, make, err);
        make->layers = 0;
        if (status == VOR_OK && round == 0)
            status = vor_noisy_find(make->noisy, make->domain, make->graph, run, err);
        VOR_THEN(status, vor_run_for(run, n, BLOCK, sheet_block, make, err));
    }
    if (status == VOR_OK)
        status = vor_run_for(run, n, BLOCK,
                             make->domain->known.lists == VOR_LISTS_FEW ? smooth_block : rest_block,
                             make, err);
    return status == VOR_OK ? vor_run_rows(run, n, BLOCK, drop_row, make, err) : status;
}

vor_status vor_adjacency_make(struct vor_graph *out, const struct vor_domain *domain,
                              const struct vor_run *run, struct vor_error *err)
{
    struct vor_graph graph = {.n = 0};
    struct make make = {.domain = domain, .graph = &graph};
    unsigned most = domain->n > VOR_ADJACENT ? VOR_ADJACENT : (unsigned)domain->n - 1;
    vor_status status = vor_graph_init(&graph, domain->n, most, run->memory, err);

    if (status != VOR_OK)
        return status;
    status = VOR_MAKE_ALL(run->memory, err, domain->n, VOR_ARRAY(make.known, domain->n, 1),
                          VOR_ARRAY(make.noisy, domain->n, 1));
    VOR_THEN(status, make_lists(&make, run, err));
    VOR_FREE_ALL(run->memory, make.noisy, make.known);
    if (status == VOR_OK)
        *out = graph;
    else
        vor_graph_free(&graph);
    return status;
}

/* --- the probe ------------------------------------------------------------------------------- */

struct probe {
    const struct vor_domain *domain;
    int nearby; /* points near places that show some of the signs are looked at */
    atomic_uint found, found_nearby;
};

enum shown { SHOWS_NONE, SHOWS_OVER, SHOWS_ALL };

/* The plane of a point that a walk met: in a small cloud the walks of a task meet the same. */
struct seen {
    size_t of; /* the point, from 1 on; 0: none */
    double r2; /* squared distance of the farthest point of the plane */
    struct vor_plane plane;
};

static struct seen see(struct seen *seen, const struct vor_domain *domain, uint32_t i)
{
    struct seen *at = &seen[i % PLACES];
    unsigned k = vor_domain_most(domain, VOR_PLANE_POINTS);
    uint32_t index[VOR_PLANE_POINTS];
    float distance2[VOR_PLANE_POINTS];

    if (at->of == (size_t)i + 1)
        return *at;
    vor_knn_search(domain->knn, vor_domain_point(domain, i), 1, k, index, distance2);
    vor_plane_fit(&at->plane, domain->xyz, index, k);
    at->r2 = vor_distance2f(vor_domain_point(domain, i), vor_domain_point(domain, index[k - 1]));
    at->of = (size_t)i + 1;
    return *at;
}

/* Sets the normals of a walk from planes of its points, as the first round would. */
static void probe_normals(struct vor_walk *walk, const struct vor_domain *domain, struct seen *seen)
{
    struct seen at[VOR_WALK_MOST] = {{.of = 0}};
    double d2[VOR_WALK_MOST];

    for (unsigned j = 0; j < walk->most; j++)
        at[j] = see(seen, domain, walk->index[j]);
    for (unsigned j = 0; j < walk->most; j++) {
        const float *x = vor_domain_point(domain, walk->index[j]);
        double here, best = KEEP * vor_plane_cost(&at[j].plane, x, at[j].r2);
        unsigned take = j;

        for (uint64_t near = vor_walk_near(walk, j, at[j].r2, d2); near > 0; near &= near - 1) {
            unsigned other = vor_walk_first(near);

            here = vor_plane_cost(&at[other].plane, x, at[j].r2);
            take = here < best ? other : take;
            best = here < best ? here : best;
        }
        for (int c = 0; c < 3; c++)
            walk->normal[c][j] = at[take].plane.normal[c];
    }
}

/* Whether a place has all of the signs, or those but for the two of its list's shape, which few
 * have where the second sheet lies over a small part of the first. */
static enum shown shows_sheets(const struct vor_domain *domain, uint32_t i, struct seen *seen,
                               struct vor_knn_last *last)
{
    struct vor_walk walk;
    struct vor_surface plain, own;
    uint32_t index[VOR_ADJACENT];
    double better2;
    unsigned n;

    if (!vor_sheet_walk_begin(&plain, domain, i, last))
        return SHOWS_NONE;
    better2 = VOR_OWN_SHEET * plain.off2;
    if (better2 < VOR_LAYERS_POSSIBLE2 * plain.spacing * plain.spacing)
        return SHOWS_NONE;
    vor_sheet_walk_gather(&walk, domain, i);
    n = vor_sheet_walk_carried(&walk, &own, &plain, domain, index);
    if (n == 0) {
        probe_normals(&walk, domain, seen);
        n = vor_sheet_walk_go(&walk, &own, &plain, domain, index);
    }
    if (n == 0 || own.off2 >= better2 || !vor_sheet_walk_left_over(&walk, &own, domain, index, n))
        return SHOWS_NONE;
    return own.spacing > PROBE_SPARSER * plain.spacing &&
                   M_PI * own.reach * own.reach < /* in a disc, and not along a few scan lines */
                       PROBE_ROUND * PROBE_ROUND * n * own.spacing * own.spacing
               ? SHOWS_ALL
               : SHOWS_OVER;
}

/* How many of the points nearest to point i, itself among them, have all signs. */
static unsigned look_nearby(const struct vor_domain *domain, uint32_t i, struct seen *seen)
{
    uint32_t index[VOR_ADJACENT];
    float distance2[VOR_ADJACENT];
    struct vor_knn_last last = {.k = 0};
    unsigned found = 0;

    vor_knn_search(domain->knn, vor_domain_point(domain, i), 1, VOR_ADJACENT, index, distance2);
    for (unsigned j = 0; j < VOR_ADJACENT; j++)
        found += shows_sheets(domain, index[j], seen, &last) == SHOWS_ALL;
    return found;
}

static void probe_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct probe *probe = ctx;
    const struct vor_domain *domain = probe->domain;
    double n = (double)domain->n, places = n < PLACES ? n : PLACES, least = PROBE_SHARE * places;
    struct seen seen[PLACES] = {{.of = 0}};
    struct vor_knn_last last = {.k = 0};

    for (size_t place = begin; place < end && atomic_load(&probe->found) < least; place++) {
        uint32_t i = (uint32_t)(((double)place + 0.5) / places * n);
        enum shown shown = shows_sheets(domain, i, seen, &last);

        atomic_fetch_add(&probe->found, shown == SHOWS_ALL);
        if (shown != SHOWS_NONE && probe->nearby && atomic_load(&probe->found_nearby) < least)
            atomic_fetch_add(&probe->found_nearby, look_nearby(domain, i, seen));
    }
}

vor_status vor_adjacency_probe(enum vor_lists *lists, const struct vor_domain *domain, int nearby,
                               const struct vor_run *run, struct vor_error *err)
{
    struct probe probe = {.domain = domain, .nearby = nearby};
    size_t places = domain->n < PLACES ? domain->n : PLACES;
    vor_status status;

    *lists = VOR_LISTS_NONE;
    if (domain->n < VOR_WALK_MOST)
        return VOR_OK;
    status = vor_run_for(run, places, domain->n > PLACES ? PROBE_BLOCK : PROBE_BLOCK_ALL,
                         probe_block, &probe, err);
    if (status == VOR_OK && atomic_load(&probe.found) >= PROBE_SHARE * (double)places)
        *lists = VOR_LISTS_LOCAL;
    else if (status == VOR_OK && atomic_load(&probe.found_nearby) >= PROBE_SHARE * (double)places)
        *lists = VOR_LISTS_FEW;
    return status;
}
