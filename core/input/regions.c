#include "core/input/regions.h"

#include "core/base/linalg.h"
#include "core/geom/boundary.h"
#include "core/geom/parting.h"
#include "core/geom/surface.h"
#include "core/geom/through.h"
#include "core/input/adjacency.h"
#include "core/input/sheet_walk.h"
#include "core/input/votes.h"

#include <math.h>
#include <string.h>

/* Figures are points of shell60k (two sheets nearer than the spacing) of which most around in their
 * region lie on the other sheet; 75 of 60,000 would be told wrong though all others were right. */

enum {
    BLOCK = 256,               /* points of one task */
    AROUND = 3 * VOR_ADJACENT, /* nearest points that are looked at for those of one region */
    PAIRED = 2 * VOR_ADJACENT, /* nearest points that a point is paired with: of two sheets */
    BONDS = 24,                /* most pairs of a point that say anything */
    CANDIDATES = 4,            /* regions that a point is asked about */
    ROUNDS = 8                 /* that points are asked in; 97 of them change in the last */
};

_Static_assert((int)PAIRED <= (int)VOR_VOTES_HEARD, "votes of all pairs are heard");
_Static_assert(AROUND * sizeof(uint32_t) <= BONDS * sizeof(struct vor_bond), "lists follow bonds");

#define NONE UINT32_MAX

/* Half of the distances off each other's surface, in spacings, at which a pair in both lists and
 * one in none says half of what it can. Wrong at 0.05 / 0.1 / 0.2 for the first: 283 / 231 / 378;
 * at 0.1 / 0.3 / 0.6 for the second: 380 / 283 / 343, with the other at 0.05, 0.05, 0.2. */
#define JOINED 0.1
#define PARTED 0.3
/* Distance of a point off the surface of another, in spacings, from which on they lie on two
 * sheets: midway. Of pairs whose lists are sure, those on one sheet are less than 0.13 off in 99 of
 * 100 cases (shell60k; 0.22 on arma2), those on two more than 0.24. */
#define ACROSS ((JOINED + PARTED) / 2)
/* Longest way between such two, over that distance: farther away surfaces bend. At 2 / 4 / none
 * 298 / 214 / 231 wrong, 3 / 10 / 15 regions. */
#define STEEP 4.0
/* What a vote counts: those of fits to nearly the same points are not independent. It matters
 * little: at .07 / .1 / .15 / .3 with two fits around each point, .15 of which are .1 of three,
 * arma2_120k to 40,000 across 1.65 / 1.77 / 1.70 / 1.67 %, shell60k to 20,000 196 / 177 / 142 / 136
 * triangles. */
#define VOTES_SHARE 0.1

/* Share of what its own region's surface is off a point at which the point takes another region,
 * whose surface is less than PARTED off. */
#define CLOSER 0.7

/* The surface fitted to the list of a point, in float: 76 bytes. */
struct leaf {
    float axis[2][3], c[6], center[2], reach, spacing; /* spacing 0: none */
    float noise;                                       /* rms of the list off it, in spacings */
};

/* How the region of a point ends at it. */
struct end {
    float to[3];   /* where to; 0: it goes on */
    float lean[3]; /* the normal there, as long as the mean sine over it of ways to others beyond */
};

struct regions {
    const struct vor_domain *domain;
    struct vor_votes votes;
    struct vor_graph *graph;
    struct leaf *leaf;     /* n */
    struct vor_bond *bond; /* n x BONDS */
    uint32_t *nearest;     /* n x AROUND: the points around each, where bonds were */
    unsigned char *bonds;  /* n */
    uint32_t *region;      /* n: number of a point of it, or NONE */
    uint32_t *next;        /* n: in the next round */
    uint32_t *before;      /* n: in the round before */
    unsigned char *mixed;  /* n: others are around */
    struct end *end;       /* n */
};

/* The points around one, nearest first, and the regions that these belong to. */
struct around {
    unsigned count, regions;
    int none, changed; /* one of them is in no region; or in another one than before */
    const uint32_t *index;
    uint32_t region[CANDIDATES];
    unsigned has[CANDIDATES];
};

static const float *point(const struct regions *regions, uint32_t i)
{
    return &regions->domain->xyz[3 * (size_t)i];
}

static void fit_leaf(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct regions *regions = ctx;
    const struct vor_graph *graph = regions->graph;
    const uint32_t *list = &graph->list[i * graph->most];
    struct leaf *leaf = &regions->leaf[i];
    struct vor_surface s;
    float near[3 * (VOR_ADJACENT + 1)];

    memcpy(near, point(regions, (uint32_t)i), 3 * sizeof *near);
    vor_gather(&near[3], regions->domain->xyz, list, graph->count[i]);
    vor_surface_fit(&s, near, graph->count[i] + 1u);
    memset(leaf, 0, sizeof *leaf);
    if (s.kind == VOR_SURFACE_NONE || !(s.spacing > 0))
        return;
    for (int a = 0; a < 2; a++) {
        for (int c = 0; c < 3; c++)
            leaf->axis[a][c] = (float)s.axis[a][c];
        leaf->center[a] = (float)s.center[a];
    }
    for (int c = 0; c < 6; c++)
        leaf->c[c] = (float)s.c[c];
    leaf->reach = (float)s.reach;
    leaf->spacing = (float)s.spacing;
    leaf->noise = (float)(sqrt(s.off2) / s.spacing);
}

/* Distance of point j off the surface of point i, in spacings. */
static double off(const struct regions *regions, uint32_t i, uint32_t j)
{
    const struct leaf *leaf = &regions->leaf[i];
    struct vor_surface s = {.kind = VOR_SURFACE_QUADRIC, .reach = (double)leaf->reach};
    double x[3];

    for (int a = 0; a < 2; a++) {
        vor_to_doubles(s.axis[a], leaf->axis[a]);
        s.center[a] = (double)leaf->center[a];
    }
    vor_cross(s.axis[2], s.axis[0], s.axis[1]);
    vor_to_doubles(s.origin, point(regions, i));
    for (int c = 0; c < 6; c++)
        s.c[c] = (double)leaf->c[c];
    vor_to_doubles(x, point(regions, j));
    return fabs(vor_surface_above(&s, x)) / (double)leaf->spacing;
}

/* What points i and j, so far from each other, say: above 0 that they lie on one sheet, below that
 * on two, 0 nothing. */
static double strength(const struct regions *regions, uint32_t i, uint32_t j, double way)
{
    const struct leaf *a = &regions->leaf[i], *b = &regions->leaf[j];
    double p = off(regions, i, j), q = off(regions, j, i);
    double noise = (double)a->noise + (double)b->noise;
    double over = fmin(p, q) - noise;
    int listed = vor_graph_has(regions->graph, i, j) + vor_graph_has(regions->graph, j, i);

    if (listed == 2)
        return JOINED / (JOINED + fmax(p, q) + noise);
    if (listed == 0 && over > ACROSS && STEEP * fmin(p, q) * (double)a->spacing > way)
        return -over / (over + PARTED);
    return 0;
}

/* The same by the log odds of votes. */
static double by_votes(double odds)
{
    double x = VOTES_SHARE * odds;

    return x / sqrt(1 + x * x);
}

static void bond_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct regions *regions = ctx;
    uint32_t index[PAIRED];
    struct vor_knn_last last = {.k = 0};
    float distance2[PAIRED];
    double odds[PAIRED];

    for (size_t i = begin; i < end; i++) {
        struct vor_bond *bond = &regions->bond[i * BONDS];
        unsigned n = 0;

        vor_knn_search_next(regions->domain->knn, &last, point(regions, (uint32_t)i), PAIRED, index,
                            distance2);
        vor_votes_hear(odds, &regions->votes, (uint32_t)i, index, PAIRED);
        for (unsigned e = 0; e < PAIRED && n < BONDS; e++) {
            uint32_t j = index[e];
            double says;

            if (j <= i || !(regions->leaf[i].spacing > 0) || !(regions->leaf[j].spacing > 0))
                continue;
            says = odds[e] != 0 ? by_votes(odds[e])
                                : strength(regions, (uint32_t)i, j, sqrt((double)distance2[e]));
            if (says != 0)
                bond[n++] = (struct vor_bond){(uint32_t)i, j, (float)says};
        }
        regions->bonds[i] = (unsigned char)n;
    }
}

/* Distance, in spacings, of point i off the surface through the nearest points of a region, itself
 * left out; INFINITY without one. */
static double beside(const struct regions *regions, uint32_t i, uint32_t region,
                     const struct around *around)
{
    float near[3 * VOR_THROUGH_MOST];
    double x[3], at[3], height;
    struct vor_surface frame;
    unsigned n = 0;

    for (unsigned e = 0; e < around->count && n < VOR_THROUGH_MOST; e++)
        if (around->index[e] != i && regions->region[around->index[e]] == region)
            memcpy(&near[3 * (size_t)n++], point(regions, around->index[e]), 3 * sizeof *near);
    if (n < VOR_ADJACENT_FEWEST)
        return INFINITY;
    vor_to_doubles(x, point(regions, i));
    if (!vor_through_fit(&frame, at, &height, near, n, x) || !(frame.spacing > 0))
        return INFINITY;
    return fabs(at[2] - height) / frame.spacing;
}

static void nearest_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct regions *regions = ctx;
    struct vor_knn_last last = {.k = 0};
    float distance2[AROUND];

    for (size_t i = begin; i < end; i++)
        vor_knn_search_next(regions->domain->knn, &last, point(regions, (uint32_t)i), AROUND,
                            &regions->nearest[i * AROUND], distance2);
}

/* Looks around point i, without itself. */
static void look(struct around *out, const struct regions *regions, uint32_t i)
{
    out->count = AROUND;
    out->regions = 0;
    out->none = out->changed = 0;
    out->index = &regions->nearest[(size_t)i * AROUND];
    for (unsigned e = 0; e < AROUND; e++) {
        uint32_t region = regions->region[out->index[e]];
        unsigned c = 0;

        out->none |= region == NONE;
        out->changed |= region != regions->before[out->index[e]];
        if (region == NONE || out->index[e] == i)
            continue;
        while (c < out->regions && out->region[c] != region)
            c++;
        if (c == CANDIDATES)
            continue;
        if (c == out->regions) {
            out->has[c] = 0;
            out->region[out->regions++] = region;
        }
        out->has[c]++;
    }
}

/* The region that point i belongs to, asked anew. */
static uint32_t ask(const struct regions *regions, uint32_t i, const struct around *around)
{
    uint32_t own = regions->region[i], to = own;
    double best = PARTED, mine = INFINITY;

    for (unsigned c = 0; c < around->regions; c++) {
        double here = around->has[c] < VOR_ADJACENT_FEWEST
                          ? INFINITY
                          : beside(regions, i, around->region[c], around);

        if (around->region[c] == own)
            mine = here;
        if (here < best) {
            best = here;
            to = around->region[c];
        }
    }
    return best < CLOSER * mine ? to : own;
}

static void ask_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct regions *regions = ctx;
    struct around around;

    for (size_t i = begin; i < end; i++) {
        uint32_t own = regions->region[i];

        regions->next[i] = own;
        look(&around, regions, (uint32_t)i);
        if (!around.none && !around.changed)
            continue;
        regions->mixed[i] = around.none || around.regions > 1;
        if (around.regions > 1 || (around.regions == 1 && around.region[0] != own))
            regions->next[i] = ask(regions, (uint32_t)i, &around);
    }
}

/* Whether normals of two points are along one line, as of sheets over each other. */
static int is_alike(const struct regions *regions, uint32_t i, uint32_t j)
{
    const uint32_t at[2] = {i, j};
    double axis[2][3], normal[2][3], along;

    for (int e = 0; e < 2; e++) {
        for (int a = 0; a < 2; a++)
            vor_to_doubles(axis[a], regions->leaf[at[e]].axis[a]);
        vor_cross(normal[e], axis[0], axis[1]);
    }
    along = vor_dot(normal[0], normal[1]);
    return along * along > VOR_NORMALS_ALIKE;
}

/* Whether all that lies beyond an end leans steeply to the side that a way, times sign, leads to.
 */
static int leans(const struct end *end, const double way[3], double sign)
{
    const double steep = vor_sheet_arcs[VOR_SHEET_ARCS - 1];
    double lean[3];

    vor_to_doubles(lean, end->lean);
    return sign * vor_dot(lean, way) > 0 && vor_dot(lean, lean) > steep * steep;
}

/* Whether the regions of points i and j, of which each ends towards the other, are one surface
 * there: the faces of a thin part around its rim, which end the same way, or those of a crease:
 * what lies beyond the one leans to the side of the other. Where sheets cross, ends point at each
 * other, and what lies beyond them leans to both sides. */
static int are_joined(const struct regions *regions, uint32_t i, uint32_t j)
{
    const struct end *a = &regions->end[i], *b = &regions->end[j];
    double end_i[3], end_j[3], way[3];

    vor_to_doubles(end_i, a->to);
    vor_to_doubles(end_j, b->to);
    vor_way(way, point(regions, i), point(regions, j));
    return vor_dot(way, end_i) > 0 && vor_dot(way, end_j) < 0 &&
           (vor_dot(end_i, end_j) > VOR_SAME_WAY || (leans(a, way, 1) && leans(b, way, -1))) &&
           !is_alike(regions, i, j);
}

/* Takes point i and the nearest of its region, and of others that it is joined with where `joined`,
 * and fits a surface to them. Returns how many; 0 where they are too few. */
static unsigned take_nearest(const struct regions *regions, uint32_t i, int joined,
                             uint32_t taken[VOR_ADJACENT + 1], struct vor_surface *surface)
{
    const uint32_t *index = &regions->nearest[(size_t)i * AROUND];
    unsigned n = 1;

    taken[0] = i;
    for (unsigned e = 0; e < AROUND && n <= regions->graph->most; e++)
        if (index[e] != i && (regions->region[index[e]] == regions->region[i] ||
                              (joined && are_joined(regions, i, index[e]))))
            taken[n++] = index[e];
    (void)vor_surface_fit_to(surface, regions->domain->xyz, taken, n);
    return n < VOR_ADJACENT_FEWEST || surface->kind == VOR_SURFACE_NONE ? 0 : n;
}

/* Finds how what lies beyond the end of point i's region leans. Asked only where its points lie
 * within JOINED of their surface: elsewhere other sheets are among them. Pairs in one body / in two
 * that are joined on arma2_120k: by ends alone 854 / 194; by leaning by the steep sine or more,
 * everywhere, 1,731 / 102 more. Triangles across by ends alone / everywhere / where asked, two
 * draws: arma2_120k to 40,000 624, 550 / 547, 565 / 535, 520; shell60k to 20,000 54, 58 / 110, 122
 * / 65, 67, open edges 455, 431 / 422, 396 / 417, 408. */
static void find_lean(const struct regions *regions, size_t i, const double normal[3])
{
    const uint32_t *index = &regions->nearest[i * AROUND];
    struct end *end = &regions->end[i];
    double to[3], d[3], sines = 0;
    unsigned beyond = 0;

    vor_to_doubles(to, end->to);
    for (unsigned e = 0; e < AROUND; e++) {
        vor_way(d, point(regions, (uint32_t)i), point(regions, index[e]));
        if (regions->region[index[e]] == regions->region[i] || !(vor_dot(d, to) > 0))
            continue;
        sines += vor_dot(d, normal) / sqrt(vor_dot(d, d));
        beyond++;
    }
    for (int c = 0; c < 3 && beyond > 0; c++)
        end->lean[c] = (float)(sines / beyond * normal[c]);
}

/* Finds where to the region of a point ends at it: into an angle of 120 degrees, as a missing
 * neighbour leaves. With the lists that go around rims then, five bowls whose walls are 1.55 or 1.8
 * spacings thick have 0 open edges instead of 639. Of shell60k and arma2_120k, which have no rims,
 * 33 and 1,368 pairs are listed; 527 and 18,168 if ends may point at each other. */
static void end_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct regions *regions = ctx;
    uint32_t taken[VOR_ADJACENT + 1];
    struct vor_surface surface;
    double direction[VOR_ADJACENT][2], side[2], d[3];
    unsigned n, count = 0;

    memset(&regions->end[i], 0, sizeof *regions->end);
    if (!regions->mixed[i] || regions->region[i] == NONE)
        return;
    n = take_nearest(regions, (uint32_t)i, 0, taken, &surface);
    for (unsigned k = 1; k < n; k++) {
        double u, v, length;

        vor_way(d, point(regions, (uint32_t)i), point(regions, taken[k]));
        u = vor_dot(surface.axis[0], d);
        v = vor_dot(surface.axis[1], d);
        length = sqrt(u * u + v * v);
        if (!(length > 0))
            continue;
        direction[count][0] = u / length;
        direction[count++][1] = v / length;
    }
    if (!vor_boundary_free_side(direction, count, -VOR_SAME_WAY, side))
        return;
    for (int a = 0; a < 2; a++)
        vor_to_floats(regions->leaf[i].axis[a], surface.axis[a]);
    for (int c = 0; c < 3; c++)
        regions->end[i].to[c] =
            (float)(side[0] * surface.axis[0][c] + side[1] * surface.axis[1][c]);
    if (surface.off2 < JOINED * JOINED * surface.spacing * surface.spacing)
        find_lean(regions, i, surface.axis[2]);
}

/* Makes the list of point i of the nearest of its region, and of one that it is joined with. */
static void take_list(struct regions *regions, uint32_t i)
{
    struct vor_graph *graph = regions->graph;
    uint32_t taken[VOR_ADJACENT + 1];
    struct vor_surface surface;
    double x[3], local[3], normal[3];
    unsigned n = take_nearest(regions, i, 1, taken, &surface);

    if (n == 0)
        return;
    memcpy(&graph->list[(size_t)i * graph->most], &taken[1], (n - 1) * sizeof *taken);
    graph->count[i] = (unsigned char)(n - 1);
    graph->own[i] = 1;
    vor_to_doubles(x, point(regions, i));
    vor_surface_to_local(&surface, x, local);
    vor_surface_normal(&surface, local, normal);
    vor_to_floats(&graph->normal[3 * (size_t)i], normal);
}

static void list_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct regions *regions = ctx;

    if (regions->mixed[i] && regions->region[i] != NONE)
        take_list(regions, (uint32_t)i);
}

/* Takes the regions that have a list of points, by pairs of these; those in smaller ones are asked
 * where they belong. regions->next counts. */
static vor_status decide(struct regions *regions, const struct vor_run *run, struct vor_error *err)
{
    size_t n = regions->domain->n, count = 0;
    vor_status status;

    for (size_t i = 0; i < n; i++)
        for (unsigned e = 0; e < regions->bonds[i]; e++)
            regions->bond[count++] = regions->bond[i * BONDS + e];
    status = vor_parting_make(regions->region, n, regions->bond, count, run, err);
    if (status != VOR_OK)
        return status;
    memset(regions->next, 0, n * sizeof *regions->next);
    for (size_t i = 0; i < n; i++)
        regions->next[regions->region[i]]++;
    for (size_t i = 0; i < n; i++)
        if (regions->next[regions->region[i]] < VOR_ADJACENT_FEWEST)
            regions->region[i] = NONE;
    return VOR_OK;
}

static vor_status make(struct regions *regions, const struct vor_run *run, struct vor_error *err)
{
    size_t n = regions->domain->n;
    vor_status status = vor_run_rows(run, n, BLOCK, fit_leaf, regions, err);

    VOR_THEN(status, vor_votes_make(&regions->votes, regions->domain, regions->graph, run, err));
    VOR_THEN(status, vor_run_for(run, n, BLOCK, bond_block, regions, err));
    vor_votes_free(&regions->votes);
    VOR_THEN(status, decide(regions, run, err));
    regions->nearest = (uint32_t *)(void *)regions->bond;
    VOR_THEN(status, vor_run_for(run, n, BLOCK, nearest_block, regions, err));
    memset(regions->before, 0xff, n * sizeof *regions->before);
    for (int round = 0; round < ROUNDS && status == VOR_OK; round++) {
        uint32_t *held = regions->before;

        status = vor_run_for(run, n, BLOCK, ask_block, regions, err);
        regions->before = regions->region;
        regions->region = regions->next;
        regions->next = held;
    }
    VOR_THEN(status, vor_run_rows(run, n, BLOCK, end_row, regions, err));
    return status == VOR_OK ? vor_run_rows(run, n, BLOCK, list_row, regions, err) : status;
}

vor_status vor_regions_make(struct vor_graph *graph, const struct vor_domain *domain,
                            const struct vor_run *run, struct vor_error *err)
{
    struct vor_memory *memory = run->memory;
    struct regions regions = {.domain = domain, .graph = graph};
    size_t n = domain->n;
    vor_status status;

    if (n < AROUND)
        return VOR_OK;
    status = VOR_MAKE_ALL(memory, err, n, VOR_ARRAY(regions.leaf, n, 1),
                          VOR_ARRAY(regions.bond, n, BONDS), VOR_ARRAY(regions.bonds, n, 1),
                          VOR_ARRAY(regions.mixed, n, 1), VOR_ARRAY(regions.before, n, 1),
                          VOR_ARRAY(regions.region, n, 1), VOR_ARRAY(regions.next, n, 1),
                          VOR_ARRAY(regions.end, n, 1));
    VOR_THEN(status, make(&regions, run, err));
    VOR_FREE_ALL(memory, regions.end, regions.next, regions.region, regions.before, regions.mixed,
                 regions.bonds, regions.bond, regions.leaf);
    return status;
}
