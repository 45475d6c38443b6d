#include "core/seeds/seeds.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "core/geom/layers.h"
#include "core/input/lists.h"
#include "core/input/neighbors.h"
#include "core/input/sheets.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

/* Rings of the patch of a surface that bends (core/seeds/clip.c). With one / two: triangles a cell
 * on a cow of 300 points 12 / 18, delta 0.10 / 0.09, on a cow upsampled to 11,612 1.7 / 3.3, rms
 * distance to the true surface 1.9e-3 / 1.8e-3. */
enum { RINGS = 1 };

static unsigned at_most_all(const struct vor_seeds *seeds, unsigned k)
{
    return k < seeds->domain->n ? k : (unsigned)seeds->domain->n;
}

unsigned vor_seeds_asked(const struct vor_seeds *seeds, const float x[3])
{
    return at_most_all(seeds, vor_neighbors_at(&seeds->whole->known.neighbors, x));
}

/* Makes room for what is kept of each point of the domain, of which nothing is known yet. Returns
 * whether there is room. */
static int keep_points(struct vor_seeds *seeds)
{
    struct vor_memory *memory = seeds->run.memory;
    size_t n = seeds->domain->n;
    int looks = seeds->sheeted.count > 0 && seeds->n < n, ends = seeds->policy.keep_border;

    vor_free(memory, seeds->way);
    vor_free(memory, seeds->foot);
    seeds->way = looks ? vor_calloc(memory, n, 1) : NULL;
    seeds->foot = ends ? vor_calloc(memory, n, sizeof *seeds->foot) : NULL;
    return (!looks || seeds->way != NULL) && (!ends || seeds->foot != NULL);
}

vor_status vor_seeds_init(struct vor_seeds *out, const struct vor_domain *domain, size_t n,
                          struct vor_seeds_policy policy, const struct vor_run *run,
                          struct vor_error *err)
{
    struct vor_seeds seeds = {.domain = domain, .whole = domain, .n = n, .policy = policy};
    unsigned threads = vor_pool_threads(run->pool), most = domain->known.neighbors.most;
    unsigned sides = policy.planes ? VOR_PATCH_OCTAGON : VOR_PATCH_HEXAGON;
    unsigned listed = vor_stretched_listed(&domain->tensors, VOR_SEEDS_LISTED);
    struct vor_input_lists_of input = {.knn = domain->knn,
                                       .reference = domain->xyz,
                                       .m = domain->n,
                                       .most = at_most_all(&seeds, most),
                                       .still = policy.still};

    assert(n >= 1 && most >= 1 && most <= VOR_NEIGHBORS_MAX);
    seeds.run = vor_run_unstoppable(run);
    seeds.sheets = domain->known.sheets;
    seeds.sheeted = domain->known.sheeted;
    vor_disc_init(&seeds.flat, sides, 0);
    vor_disc_init(&seeds.disc, sides, RINGS);
    seeds.xyz = vor_malloc(run->memory, n, 3 * sizeof *seeds.xyz);
    seeds.last_fit = vor_calloc(run->memory, n, sizeof *seeds.last_fit);
    seeds.scratch = vor_calloc(run->memory, threads, sizeof *seeds.scratch);
    if (!keep_points(&seeds) || seeds.xyz == NULL || seeds.last_fit == NULL ||
        seeds.scratch == NULL ||
        vor_input_lists_init(&seeds.input_lists, n, &input, run->memory, err) != VOR_OK ||
        vor_point_lists_init(&seeds.point_lists, n, n > listed ? listed : (unsigned)n - 1,
                             run->memory, err) != VOR_OK ||
        vor_wanted_init(&seeds.wanted, &domain->field, n, run->memory, err) != VOR_OK ||
        vor_stretched_init(&seeds.stretched, &domain->tensors, n, run->memory, err) != VOR_OK) {
        vor_seeds_free(&seeds);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    }
    *out = seeds;
    return VOR_OK;
}

void vor_seeds_free(struct vor_seeds *seeds)
{
    struct vor_memory *memory = seeds->run.memory;

    if (memory == NULL)
        return;
    vor_stretched_free(&seeds->stretched, memory);
    vor_wanted_free(&seeds->wanted, memory);
    vor_free(memory, seeds->scratch);
    vor_point_lists_free(&seeds->point_lists);
    vor_input_lists_free(&seeds->input_lists);
    vor_free(memory, seeds->foot);
    vor_free(memory, seeds->way);
    VOR_FREE_ALL(memory, seeds->kept, seeds->last_fit, seeds->track, seeds->normal, seeds->xyz);
    memset(seeds, 0, sizeof *seeds);
}

void vor_seeds_forget_input(struct vor_seeds *seeds)
{
    const struct vor_domain *domain = seeds->domain;

    vor_input_lists_onto(&seeds->input_lists, domain->knn, domain->xyz, domain->n);
    memset(seeds->last_fit, 0, seeds->n * sizeof *seeds->last_fit);
}

vor_status vor_seeds_onto(struct vor_seeds *seeds, const struct vor_domain *domain,
                          struct vor_error *err)
{
    int other = domain != seeds->domain;

    seeds->domain = domain;
    seeds->sheets |= domain->known.sheets;
    if (domain->known.sheeted.count > seeds->sheeted.count)
        seeds->sheeted = domain->known.sheeted;
    vor_seeds_forget_input(seeds);
    return !other || keep_points(seeds) ? VOR_OK
                                        : vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
}

vor_status vor_seeds_index(struct vor_seeds *seeds, const struct vor_run *run,
                           struct vor_error *err)
{
    double far = VOR_POINT_LISTS_FAR * vor_stretched_longest_of_all(&seeds->stretched);
    vor_status status = vor_wanted_renew(&seeds->wanted, seeds->xyz, run, err);

    VOR_THEN(status, vor_stretched_renew(&seeds->stretched, seeds->xyz, run, err));
    if (status != VOR_OK)
        return status;
    if (vor_point_lists_look(&seeds->view, &seeds->point_lists, seeds->xyz, far))
        return VOR_OK;
    status = vor_point_lists_index(&seeds->point_lists, seeds->xyz, run, err);
    if (status == VOR_OK)
        (void)vor_point_lists_look(&seeds->view, &seeds->point_lists, seeds->xyz, far);
    return status;
}

struct vor_counts vor_seeds_counts(const struct vor_seeds *seeds)
{
    struct vor_counts counts = {.queries = seeds->point_lists.indexed * seeds->n};

    for (unsigned i = 0; i < vor_pool_threads(seeds->run.pool); i++) {
        counts.queries += seeds->scratch[i].queries;
        counts.cells += seeds->scratch[i].cells;
        counts.bisectors += seeds->scratch[i].bisectors;
        counts.triangles += seeds->scratch[i].triangles;
    }
    return counts;
}

/* Gathers k points; of `count`, if they are fewer, again and again. */
static void gather(const struct vor_seeds *seeds, struct vor_place *place, const uint32_t *index,
                   unsigned count, unsigned k)
{
    place->k = k;
    vor_gather(place->near, seeds->domain->xyz, index, count);
    for (unsigned j = count; j < k; j++)
        memcpy(&place->near[3 * j], &place->near[3 * (j - count)], 3 * sizeof *place->near);
}

/* Gathers points of a layer. Where seeds are fewer than points, only if the input has layers at one
 * of the first two points of a list: one alone is wrong about them now and then. As the way at a
 * point depends on that point alone, whichever thread finds it first may keep it for all. By one
 * point / two / three / asked of each fit: an office of 254,456 points to 10,000 takes 8.4 / 9.8 /
 * 10.7 / 13.3 CPU s. Of more seeds than points that lie between these, by one point / each: a disc
 * with a wall of 1.9 spacings upsampled fourfold is 0.246 / 0.159 spacings off. */
static int gather_layer(const struct vor_seeds *seeds, struct vor_place *place, const double x[3],
                        const uint32_t *index, struct vor_layer *layer)
{
    const struct vor_domain *domain = seeds->domain;
    unsigned char way = seeds->way != NULL ? VOR_SHEETS_NO_WAY : 0;

    for (unsigned j = 0; j < 2 && way == VOR_SHEETS_NO_WAY; j++) {
        way = atomic_load_explicit(&seeds->way[index[j]], memory_order_relaxed);
        if (way > 0)
            continue;
        way = vor_sheets_way(domain, index[j],
                             vor_seeds_asked(seeds, vor_domain_point(domain, index[j])));
        atomic_store_explicit(&seeds->way[index[j]], way, memory_order_relaxed);
    }
    return way != VOR_SHEETS_NO_WAY &&
           vor_sheets_gather(place->near, domain, x, place->k, layer, way);
}

/* Fits to a list or, where a domain has sheets around x, to a layer. Where only a thinned one has
 * them, this looks on the whole too: its neighbours reach over to another sheet at the border.
 *
 * layer  count is above 0 where the points are of one; else set where there is one */
static struct vor_lists_fitted fit_quadric(const struct vor_seeds *seeds, struct vor_place *place,
                                           struct vor_surface *out, const double x[3],
                                           const uint32_t *index, struct vor_layer *layer)
{
    const struct vor_domain *domain = seeds->domain;
    struct vor_lists_fitted fitted = {1, VOR_LISTS_NO_ROOT};
    int listed;

    /* cppcheck-suppress ctuuninitvar; count is set */
    if (layer->count > 0) {
        vor_surface_fit(out, place->near, place->k);
        return fitted;
    }
    listed = vor_lists_are(domain, place->k);
    if (listed) {
        fitted = vor_lists_fit(out, place->near, domain, x, place->k, index);
    } else {
        vor_surface_fit(out, place->near, place->k);
        fitted.sheet = 0;
    }
    if (!fitted.sheet && !(listed && domain->known.sheets) && vor_layers_possible(out) &&
        vor_sheets_at(&seeds->sheeted, x) && gather_layer(seeds, place, x, index, layer)) {
        vor_surface_fit(out, place->near, place->k);
        fitted.sheet = 1;
    }
    return fitted;
}

/* A quadric, or the plane through the points that one would be fitted to: what tells sheets apart
 * is measured with quadrics. The points of a sheet may be repeated, which does not change the
 * spacing that they were found with. */
static struct vor_lists_fitted fit(const struct vor_seeds *seeds, struct vor_place *place,
                                   struct vor_surface *out, const double x[3],
                                   const uint32_t *index, struct vor_layer *layer)
{
    struct vor_lists_fitted fitted = {.root = VOR_LISTS_NO_ROOT};
    double spacing = 0;

    if (!seeds->policy.planes)
        return fit_quadric(seeds, place, out, x, index, layer);
    if (seeds->sheeted.count > 0 || vor_graph_is(&seeds->domain->graph)) {
        fitted = fit_quadric(seeds, place, out, x, index, layer);
        spacing = out->spacing;
    }
    vor_surface_fit_as(out, place->near, place->k, VOR_SURFACE_PLANE);
    if (fitted.sheet)
        out->spacing = spacing;
    return fitted;
}

/* Finds the input points for the surface of seed i. Their number is looked up with each new list.
 */
static enum vor_input_lists_found search(struct vor_seeds *seeds, struct vor_scratch *scratch,
                                         size_t i, const uint32_t **index)
{
    struct vor_last_fit *last = &seeds->last_fit[i];
    const float *x = &seeds->xyz[3 * i];
    enum vor_input_lists_found found;

    if (last->k > 0) {
        found = vor_input_lists_search(&seeds->input_lists, i, x, last->k, index);
        if (found != VOR_INPUT_LISTS_ANEW)
            return found;
        scratch->queries++;
        if (vor_seeds_asked(seeds, x) == last->k)
            return VOR_INPUT_LISTS_ANEW;
    }
    last->k = (uint16_t)vor_seeds_asked(seeds, x);
    scratch->queries++;
    return vor_input_lists_search(&seeds->input_lists, i, x, last->k, index);
}

enum vor_surface_kind vor_seeds_fit(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i)
{
    struct vor_place *here = &scratch->here;
    struct vor_last_fit *last = &seeds->last_fit[i];
    const float *x = &seeds->xyz[3 * i];
    const uint32_t *index;
    enum vor_input_lists_found found = search(seeds, scratch, i, &index);

    scratch->interior = 0;
    gather(seeds, here, index, vor_input_lists_count(&seeds->input_lists, i), last->k);
    /* A seed keeps its sheet until the points are others: else seeds between two sheets change from
     * one to the other again and again. Kept / not: shell60k to 240,000 delta_sheet 0.078 / 0.080,
     * arma2 0.097 / 0.100, 6 % less CPU. */
    if (found != VOR_INPUT_LISTS_SAME || last->refined) {
        struct vor_lists_fitted fitted;
        struct vor_layer layer;
        int kept = found != VOR_INPUT_LISTS_ANEW && last->narrow;
        double at[3];

        layer.count = kept ? last->k : 0;
        vor_seeds_position(seeds, i, at);
        fitted = fit(seeds, here, &last->surface, at, index, &layer);
        if (!kept && layer.count > 0)
            vor_input_lists_narrow(&seeds->input_lists, i, x, layer.index, layer.count,
                                   layer.reach);
        last->narrow = layer.count > 0;
        last->layered = (unsigned char)fitted.sheet;
        last->root = fitted.root;
    } else if (last->layered && last->root != VOR_LISTS_NO_ROOT)
        vor_lists_points(here->near, seeds->domain, last->root, last->k);
    last->refined = 0;
    last->interior = last->inside = 0;
    memcpy(last->place, x, sizeof last->place);
    here->surface = last->surface;
    return here->surface.kind;
}

uint32_t vor_seeds_nearest(const struct vor_seeds *seeds, size_t i)
{
    uint32_t index = vor_input_lists_first(&seeds->input_lists, i);
    float distance2;

    if (seeds->last_fit[i].narrow)
        vor_knn_search(seeds->domain->knn, &seeds->xyz[3 * i], 1, 1, &index, &distance2);
    return index;
}

int vor_seeds_surrounded(const struct vor_scratch *scratch, const double x[3])
{
    const struct vor_place *here = &scratch->here;
    const struct vor_surface *surface = &here->surface;
    double local[3], side[2];

    vor_surface_to_local(surface, x, local);
    return isinf(vor_boundary_room(surface, here->near, here->k, local, surface->reach, side));
}

enum vor_surface_kind vor_seeds_fit_at(const struct vor_seeds *seeds, struct vor_scratch *scratch,
                                       struct vor_place *place, const double x[3])
{
    float query[3] = {(float)x[0], (float)x[1], (float)x[2]};
    uint32_t index[VOR_NEIGHBORS_MAX];
    float distance2[VOR_NEIGHBORS_MAX];
    struct vor_layer layer;
    unsigned k = vor_seeds_asked(seeds, query);

    vor_input_lists_nearest(&seeds->input_lists, query, k, index, distance2);
    scratch->queries++;
    gather(seeds, place, index, k, k);
    layer.count = 0;
    (void)fit(seeds, place, &place->surface, x, index, &layer);
    return place->surface.kind;
}

/* Spacing of the surface at an input point, negative where the points around it are irregular;
 * -INFINITY: there is no surface. It depends on the point alone, so that whichever thread finds it
 * first may keep it for all. To ask counts as one search whether it is known or not, so that their
 * number does not depend on the threads. */
static double spacing_at(const struct vor_seeds *seeds, struct vor_scratch *scratch, uint32_t point,
                         const double foot[3])
{
    const struct vor_place *place = &scratch->foot;
    double spacing = atomic_load_explicit(&seeds->foot[point], memory_order_relaxed);

    if (spacing < 0 || spacing > 0) {
        scratch->queries++;
        return spacing;
    }
    spacing = -INFINITY;
    if (vor_seeds_fit_at(seeds, scratch, &scratch->foot, foot) != VOR_SURFACE_NONE) {
        spacing = place->surface.spacing;
        if (vor_boundary_regularity(place->near, place->k, spacing) < VOR_HOLE_REGULAR)
            spacing = -spacing;
    }
    atomic_store_explicit(&seeds->foot[point], spacing, memory_order_relaxed);
    return spacing;
}

void vor_seeds_border(const struct vor_seeds *seeds, struct vor_scratch *scratch,
                      const struct vor_place *place, struct vor_border *border, const double x[3])
{
    double foot[3] = {(double)place->near[0], (double)place->near[1], (double)place->near[2]};
    double sparse = seeds->domain->sparse, spacing;
    float distance2;
    uint32_t point;

    *border = (struct vor_border){&place->surface, place->near, place->k,
                                  fmin(place->surface.spacing, sparse)};
    if (vor_boundary_within(place->near, place->k, x, border->spacing))
        return;
    vor_knn_search(seeds->domain->knn, place->near, 1, 1, &point, &distance2);
    spacing = fabs(spacing_at(seeds, scratch, point, foot));
    if (!isinf(spacing))
        border->spacing = fmin(spacing, sparse);
}

/* Whether the input goes on from its point at `foot` along `way`, judged by those points around it
 * that the list of seed i holds for certain: false when they do not show it. */
static int goes_on(const struct vor_seeds *seeds, size_t i, const double foot[3],
                   const double way[3], unsigned k)
{
    float at[3] = {(float)foot[0], (float)foot[1], (float)foot[2]};
    struct vor_place around;
    uint32_t index[VOR_NEIGHBORS_MAX];

    memset(index, 0, k * sizeof *index); /* clang-analyzer cannot see that k >= 1 */
    k = vor_input_lists_around(&seeds->input_lists, i, at, k, index);
    gather(seeds, &around, index, k, k);
    return vor_boundary_goes_on(around.near, around.k, foot, way, INFINITY);
}

int vor_seeds_hold(const struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i,
                   double x[3])
{
    const struct vor_place *other = &scratch->foot;
    const float *near = scratch->here.near;
    unsigned k = scratch->here.k;
    int lines;
    double foot[3], way[3], length = vor_boundary_foot(near, k, x, foot, way), spacing;

    /* Mostly the points at hand decide, which saves a search. With sheets the list does not: its
     * points may be on another one. */
    if (k < VOR_HOLE_NEIGHBORS_MIN ||
        vor_boundary_goes_on(near, k, foot, way, vor_boundary_reach(near, k, x) - length))
        return 0;
    spacing = vor_boundary_spacing(near, k, x);
    if (length <= VOR_HOLE_MARGIN * spacing ||
        spacing_at(seeds, scratch, vor_input_lists_at(&seeds->input_lists, i, foot), foot) < 0 ||
        (!seeds->sheets && goes_on(seeds, i, foot, way, k)) ||
        vor_seeds_fit_at(seeds, scratch, &scratch->foot, foot) == VOR_SURFACE_NONE ||
        vor_boundary_goes_on(other->near, other->k, foot, way, INFINITY))
        return 0;
    lines = seeds->n > seeds->domain->n && !vor_seeds_surrounded(scratch, x);
    return vor_boundary_pull(other->near, lines ? other->k : 0, foot, spacing, x);
}

void vor_seeds_part(size_t i, size_t j, double length, double offset[2])
{
    uint64_t low = i < j ? i : j, high = i < j ? j : i;
    double sign = i < j ? 1 : -1;

    offset[0] = sign * length * (0.1 + vor_rng_unit(low, 7, 2 * high));
    offset[1] = sign * length * (vor_rng_unit(low, 7, 2 * high + 1) - 0.5);
}

void vor_seeds_crowd(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i)
{
    scratch->queries +=
        vor_point_lists_crowd(&scratch->crowd, &seeds->point_lists, &seeds->view, i);
}

void vor_seeds_within(struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i,
                      double distance)
{
    distance *= vor_stretched_longest(&seeds->stretched, i);
    scratch->queries +=
        vor_point_lists_within(&scratch->crowd, &seeds->point_lists, &seeds->view, i, distance);
}
