#include "core/seeds/seeds.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "core/input/sheets.h"

#include <assert.h>
#include <string.h>

/* Where a patch is nearly flat its tangent plane does, and saves most of the clipping; then one
 * ring of triangles; where it bends more than this over its radius, two keep centroids from
 * straying. */
enum { RINGS = 1, RINGS_FINE = 2 };

enum { MANY = 200000 };   /* seeds */
enum { HOLD_LEAST = 12 }; /* neighbours that tell a hole */

#define BEND_FLAT 0.4
#define BEND_MAX 1.0
#define REGULAR 1.4 /* regularity from which on a gap in the input tells of a hole */
#define INSIDE 0.7  /* spacings from the input: farther than that, it may be in a hole */
#define FAR 0.3     /* spacings that seeds may move before the lists are made anew */
#define FAR_MANY                                                                                   \
    0.5 /* the same of many: new lists cost them more, since they outgrow the caches               \
         */

static unsigned at_most_all(const struct vor_seeds *seeds, unsigned k)
{
    return k < seeds->domain->n ? k : (unsigned)seeds->domain->n;
}

/* How many input points a surface at x is to be fitted to. */
static unsigned asked(const struct vor_seeds *seeds, const float x[3])
{
    return at_most_all(seeds, vor_scale_at(seeds->scale, x));
}

vor_status vor_seeds_init(struct vor_seeds *out, const struct vor_domain *domain, size_t n,
                          const struct vor_scale *scale, const struct vor_run *run,
                          struct vor_error *err)
{
    struct vor_seeds seeds = {.domain = domain,
                              .whole = domain,
                              .scale = scale,
                              .run = run,
                              .n = n,
                              .keep_border = 1,
                              .widen = 1};
    unsigned threads = vor_pool_threads(run->pool);

    assert(n >= 1 && scale->most >= 1 && scale->most <= VOR_NEIGHBORS_MAX);
    vor_disc_init(&seeds.flat, 0);
    vor_disc_init(&seeds.disc, RINGS);
    vor_disc_init(&seeds.fine, RINGS_FINE);
    seeds.xyz = vor_malloc(run->memory, n, 3 * sizeof *seeds.xyz);
    seeds.kept = vor_calloc(run->memory, n, sizeof *seeds.kept);
    seeds.bench = vor_calloc(run->memory, threads, sizeof *seeds.bench);
    if (seeds.xyz == NULL || seeds.kept == NULL || seeds.bench == NULL ||
        vor_near_init(&seeds.near, n, at_most_all(&seeds, scale->most), domain->knn, domain->xyz,
                      domain->n, run->memory, err) != VOR_OK ||
        vor_swarm_init(&seeds.swarm, n, n > VOR_SEEDS_LISTED ? VOR_SEEDS_LISTED : (unsigned)n - 1,
                       run->memory, err) != VOR_OK) {
        vor_seeds_free(&seeds);
        return vor_fail(err, VOR_E_NOMEM, "%zu seeds", n);
    }
    *out = seeds;
    return VOR_OK;
}

void vor_seeds_free(struct vor_seeds *seeds)
{
    struct vor_memory *memory;

    if (seeds->run == NULL)
        return;
    memory = seeds->run->memory;
    vor_free(memory, seeds->bench);
    vor_swarm_free(&seeds->swarm);
    vor_near_free(&seeds->near);
    vor_free(memory, seeds->kept);
    vor_free(memory, seeds->xyz);
    memset(seeds, 0, sizeof *seeds);
}

void vor_seeds_onto(struct vor_seeds *seeds, const struct vor_domain *domain)
{
    vor_near_onto(&seeds->near, domain->knn, domain->xyz, domain->n);
    seeds->domain = domain;
    memset(seeds->kept, 0, seeds->n * sizeof *seeds->kept);
}

vor_status vor_seeds_index(struct vor_seeds *seeds, struct vor_error *err)
{
    double far = seeds->n < MANY ? FAR : FAR_MANY;
    vor_status status;

    if (vor_swarm_look(&seeds->view, &seeds->swarm, seeds->xyz, far))
        return VOR_OK;
    status = vor_swarm_index(&seeds->swarm, seeds->xyz, seeds->run, err);
    if (status == VOR_OK)
        (void)vor_swarm_look(&seeds->view, &seeds->swarm, seeds->xyz, far);
    return status;
}

struct vor_counts vor_seeds_counts(const struct vor_seeds *seeds)
{
    struct vor_counts counts = {.queries = seeds->swarm.indexed * seeds->n};

    for (unsigned i = 0; i < vor_pool_threads(seeds->run->pool); i++) {
        counts.queries += seeds->bench[i].queries;
        counts.cells += seeds->bench[i].cells;
        counts.bisectors += seeds->bench[i].bisectors;
        counts.triangles += seeds->bench[i].triangles;
    }
    return counts;
}

static void gather(const struct vor_seeds *seeds, struct vor_place *place, const uint32_t *index,
                   unsigned k)
{
    place->k = k;
    for (unsigned j = 0; j < k; j++)
        memcpy(&place->near[3 * j], &seeds->domain->xyz[3 * (size_t)index[j]],
               3 * sizeof *place->near);
}

/* The points for the surface of seed i. How many it asks anew with each new list. */
static enum vor_near_found search(struct vor_seeds *seeds, struct vor_bench *bench, size_t i,
                                  const uint32_t **index)
{
    struct vor_kept *kept = &seeds->kept[i];
    const float *x = &seeds->xyz[3 * i];
    enum vor_near_found found;

    if (kept->k > 0) {
        found = vor_near_search(&seeds->near, i, x, kept->k, index);
        if (found != VOR_NEAR_ANEW)
            return found;
        bench->queries++;
        if (asked(seeds, x) == kept->k)
            return VOR_NEAR_ANEW;
    }
    kept->k = (uint16_t)asked(seeds, x);
    bench->queries++;
    return vor_near_search(&seeds->near, i, x, kept->k, index);
}

enum vor_surface_kind vor_seeds_fit(struct vor_seeds *seeds, struct vor_bench *bench, size_t i)
{
    struct vor_place *here = &bench->here;
    struct vor_kept *kept = &seeds->kept[i];
    const float *x = &seeds->xyz[3 * i];
    const uint32_t *index;
    enum vor_near_found found = search(seeds, bench, i, &index);

    bench->interior = 0;
    gather(seeds, here, index, kept->k);
    /* Of the same points another may be the nearest, and so the sheet another. */
    if (found != VOR_NEAR_SAME || kept->layered || kept->refined) {
        double at[3];

        vor_seeds_position(seeds, i, at);
        kept->layered =
            (unsigned char)vor_sheets_fit(&kept->surface, here->near, seeds->domain, at, kept->k);
    }
    kept->refined = 0;
    kept->interior = 0;
    memcpy(kept->place, x, sizeof kept->place);
    here->surface = kept->surface;
    return here->surface.kind;
}

/* Whether the input goes on around the seed at hand. */
static int far_from_border(const struct vor_seeds *seeds, const struct vor_bench *bench,
                           const double x[3], double radius)
{
    const struct vor_place *here = &bench->here;
    double local[3], side[2], inside = seeds->keep_holes ? INSIDE : 1;

    if (!seeds->keep_border)
        return 1;
    vor_surface_to_local(&here->surface, x, local);
    return vor_boundary_within(here->near, here->k, x,
                               inside * vor_boundary_spacing(here->near, here->k, x)) &&
           isinf(vor_boundary_room(&here->surface, here->near, here->k, local, radius, side));
}

int vor_seeds_refine(const struct vor_seeds *seeds, const struct vor_bench *bench, size_t i,
                     struct vor_surface *surface)
{
    unsigned k = bench->here.k;

    return seeds->refined && k >= VOR_REFINED_MIN && k <= VOR_REFINED_MAX &&
           vor_surface_refine(surface, bench->here.near, k, &seeds->xyz[3 * i]);
}

enum vor_surface_kind vor_seeds_recall(struct vor_seeds *seeds, struct vor_bench *bench, size_t i,
                                       double radius, double slack)
{
    struct vor_kept *kept = &seeds->kept[i];
    double most = slack * kept->surface.spacing, x[3];

    if (kept->interior && (kept->refined || !seeds->refined) &&
        vor_distance2f(&seeds->xyz[3 * i], kept->place) <= most * most) {
        bench->here.surface = bench->onto = kept->surface;
    } else {
        if (vor_seeds_fit(seeds, bench, i) == VOR_SURFACE_NONE)
            return VOR_SURFACE_NONE;
        vor_seeds_position(seeds, i, x);
        kept->interior = (unsigned char)far_from_border(seeds, bench, x, radius);
        bench->onto = bench->here.surface;
        (void)vor_seeds_refine(seeds, bench, i, &bench->onto);
        if (kept->interior) { /* nothing else is asked of it */
            bench->here.surface = kept->surface = bench->onto;
            kept->refined = (unsigned char)seeds->refined;
        }
    }
    bench->interior = kept->interior;
    return bench->here.surface.kind;
}

enum vor_surface_kind vor_seeds_fit_at(const struct vor_seeds *seeds, struct vor_bench *bench,
                                       struct vor_place *place, const double x[3])
{
    float query[3] = {(float)x[0], (float)x[1], (float)x[2]};
    uint32_t index[VOR_NEIGHBORS_MAX];
    float distance2[VOR_NEIGHBORS_MAX];
    unsigned k = asked(seeds, query);

    vor_knn_search(seeds->domain->knn, query, 1, k, index, distance2);
    bench->queries++;
    gather(seeds, place, index, k);
    (void)vor_sheets_fit(&place->surface, place->near, seeds->domain, x, k);
    return place->surface.kind;
}

void vor_seeds_border(const struct vor_seeds *seeds, struct vor_bench *bench,
                      const struct vor_place *place, struct vor_border *border, const double x[3])
{
    double foot[3] = {(double)place->near[0], (double)place->near[1], (double)place->near[2]};

    double sparse = seeds->domain->sparse;

    *border = (struct vor_border){&place->surface, place->near, place->k,
                                  fmin(place->surface.spacing, sparse)};
    if (vor_boundary_within(place->near, place->k, x, border->spacing))
        return;
    if (vor_seeds_fit_at(seeds, bench, &bench->foot, foot) != VOR_SURFACE_NONE)
        border->spacing = fmin(bench->foot.surface.spacing, sparse);
}

/* Whether the input goes on beyond x, as seen from the input point at `foot`, by what the list of
 * seed i tells of the points around that: false where it does not tell. */
static int goes_on(const struct vor_seeds *seeds, size_t i, const double foot[3], const double x[3],
                   unsigned k)
{
    float at[3] = {(float)foot[0], (float)foot[1], (float)foot[2]};
    struct vor_place around;
    uint32_t index[VOR_NEIGHBORS_MAX];

    memset(index, 0, k * sizeof *index); /* the analysers want it said */
    gather(seeds, &around, index, vor_near_around(&seeds->near, i, at, k, index));
    return vor_boundary_beyond(around.near, around.k, foot, x, INFINITY);
}

int vor_seeds_hold(const struct vor_seeds *seeds, struct vor_bench *bench, size_t i, double x[3])
{
    const struct vor_place *other = &bench->foot;
    const float *near = bench->here.near;
    unsigned k = bench->here.k;
    double foot[3], spacing, length;

    if (k < HOLD_LEAST)
        return 0;
    length = vor_boundary_foot(near, k, x, foot);
    spacing = vor_boundary_spacing(near, k, x);
    /* Mostly the points at hand tell, and save a search. Not of sheets: they may be on another. */
    if (length <= VOR_BORDER_MARGIN * spacing ||
        vor_boundary_beyond(near, k, foot, x, vor_boundary_reach(near, k, x) - length) ||
        (!seeds->domain->sheets && goes_on(seeds, i, foot, x, k)) ||
        vor_seeds_fit_at(seeds, bench, &bench->foot, foot) == VOR_SURFACE_NONE ||
        vor_boundary_beyond(other->near, other->k, foot, x, INFINITY) ||
        vor_boundary_regularity(other->near, other->k, other->surface.spacing) < REGULAR)
        return 0;
    for (int c = 0; c < 3; c++)
        x[c] = foot[c] + (x[c] - foot[c]) * (VOR_BORDER_MARGIN * spacing / length);
    return 1;
}

/* Mean distance to the six nearest seeds; with fewer seeds the patch spans the whole domain. */
static double patch_radius(const struct vor_crowd *crowd)
{
    double sum = 0;

    if (crowd->count < 6)
        return 2;
    for (int j = 0; j < 6; j++)
        sum += sqrt((double)crowd->distance2[j]);
    return sum / 6;
}

/* Coincident seeds get an offset of their own, opposite for the two, so that they part. */
void vor_seeds_part(size_t i, size_t j, double length, double offset[2])
{
    uint64_t low = i < j ? i : j, high = i < j ? j : i;
    double sign = i < j ? 1 : -1;

    offset[0] = sign * length * (0.1 + vor_rng_unit(low, 7, 2 * high));
    offset[1] = sign * length * (vor_rng_unit(low, 7, 2 * high + 1) - 0.5);
}

/* Where seed j lies as seen from seed i, in the surface's axes; never at the same place. */
static void offset_of(const struct vor_seeds *seeds, const struct vor_bench *bench, size_t i,
                      size_t j, double offset[3])
{
    const float *a = &seeds->xyz[3 * i], *b = &seeds->xyz[3 * j];
    double d[3] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                   (double)b[2] - (double)a[2]};

    for (int c = 0; c < 3; c++)
        offset[c] = vor_dot(bench->here.surface.axis[c], d);
    if (vor_dot(offset, offset) > 0)
        return;
    vor_seeds_part(i, j, 1e-6 * bench->radius, offset);
    offset[2] = 0;
}

static int clip_by(const struct vor_seeds *seeds, struct vor_bench *bench, size_t i, size_t j)
{
    double offset[3] = {0};

    offset_of(seeds, bench, i, j, offset);
    if (vor_cell_secure(&bench->cell, vor_dot(offset, offset)))
        return 0;
    vor_cell_clip(&bench->cell, offset);
    return 1;
}

/* Looks farther while what the list is sure of does not secure the cell. Seeds come in no strict
 * order, so that each is judged by itself. */
static void clip_more(const struct vor_seeds *seeds, struct vor_bench *bench, size_t i)
{
    uint32_t index[VOR_SEEDS_MORE_MAX];
    float distance2[VOR_SEEDS_MORE_MAX];
    size_t width = 2 * (seeds->swarm.listed + 1), done = 0;
    double sure = bench->crowd.sure;

    /* Of the jumpers, the crowd has only those nearer than it is sure of. */
    if (!(sure > 0 && vor_cell_secure(&bench->cell, sure * sure)))
        for (unsigned j = 0; j < seeds->view.jumpers; j++)
            if (seeds->view.jumper[j] != i)
                (void)clip_by(seeds, bench, i, seeds->view.jumper[j]);
    while (!(sure > 0 && vor_cell_secure(&bench->cell, sure * sure)) && done < seeds->n &&
           done < VOR_SEEDS_MORE_MAX) {
        width = width < VOR_SEEDS_MORE_MAX ? width : VOR_SEEDS_MORE_MAX;
        width = width < seeds->n ? width : seeds->n;
        sure = vor_swarm_wide(&seeds->swarm, &seeds->view, i, (unsigned)width, index, distance2);
        bench->queries++;
        for (size_t j = done; j < width; j++)
            if (index[j] != i)
                (void)clip_by(seeds, bench, i, index[j]);
        done = width;
        width *= 2;
    }
}

const struct vor_disc *vor_seeds_disc(const struct vor_seeds *seeds, const struct vor_bench *bench)
{
    const double *c = bench->here.surface.c;
    double bend = (fabs(c[3]) + fabs(c[4]) + fabs(c[5])) * bench->radius;

    if (bend > BEND_MAX)
        return &seeds->fine;
    return bend > BEND_FLAT ? &seeds->disc : &seeds->flat;
}

static void end_at_border(const struct vor_seeds *seeds, struct vor_bench *bench)
{
    double side[2], room = vor_boundary_room(&bench->here.surface, bench->here.near, bench->here.k,
                                             bench->cell.seed, bench->radius / seeds->widen, side);

    if (room < bench->radius)
        vor_cell_clip(&bench->cell, (double[3]){2 * room * side[0], 2 * room * side[1], 0});
}

void vor_seeds_crowd(struct vor_seeds *seeds, struct vor_bench *bench, size_t i)
{
    bench->queries += vor_swarm_crowd(&bench->crowd, &seeds->swarm, &seeds->view, i);
}

void vor_seeds_within(struct vor_seeds *seeds, struct vor_bench *bench, size_t i, double distance)
{
    bench->queries += vor_swarm_within(&bench->crowd, &seeds->swarm, &seeds->view, i, distance);
}

void vor_seeds_clip(struct vor_seeds *seeds, struct vor_bench *bench, size_t i, int flat)
{
    const struct vor_crowd *crowd = &bench->crowd;
    double x[3], local[3];
    unsigned j = 0;

    vor_seeds_position(seeds, i, x);
    vor_surface_to_local(&bench->here.surface, x, local);
    bench->radius = seeds->widen * patch_radius(crowd);
    vor_cell_begin(&bench->cell, flat ? &seeds->flat : vor_seeds_disc(seeds, bench),
                   &bench->here.surface, local, bench->radius);
    bench->triangles += bench->cell.count;
    if (seeds->keep_border && !bench->interior)
        end_at_border(seeds, bench);
    while (j < crowd->count && clip_by(seeds, bench, i, crowd->index[j]))
        j++;
    clip_more(seeds, bench, i);
    bench->cells++;
    bench->bisectors += bench->cell.bisectors;
}

enum vor_surface_kind vor_seeds_cell(struct vor_seeds *seeds, struct vor_bench *bench, size_t i)
{
    enum vor_surface_kind kind = vor_seeds_fit(seeds, bench, i);

    if (kind == VOR_SURFACE_NONE)
        return VOR_SURFACE_NONE;
    vor_seeds_crowd(seeds, bench, i);
    vor_seeds_clip(seeds, bench, i, 0);
    return kind;
}
