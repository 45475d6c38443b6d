#include "core/method/seeds.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"

#include <assert.h>
#include <string.h>

/* One ring of triangles does where the patch is nearly flat, and saves a third of the time; where
 * it bends more than this over its radius, two keep centroids from straying. */
enum { RINGS = 1, RINGS_FINE = 2 };

#define BEND_MAX 0.25

static void free_bench(struct vor_bench *bench, struct vor_memory *memory)
{
    vor_free(memory, bench->near_index);
    vor_free(memory, bench->seed_index);
    vor_free(memory, bench->seed_distance2);
}

static int alloc_bench(struct vor_bench *bench, const struct vor_seeds *seeds)
{
    struct vor_memory *memory = seeds->run->memory;
    size_t near = (size_t)VOR_SEEDS_BLOCK * seeds->k;
    size_t listed = (size_t)VOR_SEEDS_BLOCK * (seeds->listed + 1);

    bench->near_index = vor_malloc(memory, near, sizeof *bench->near_index);
    bench->seed_index = vor_malloc(memory, listed, sizeof *bench->seed_index);
    bench->seed_distance2 = vor_malloc(memory, listed, sizeof *bench->seed_distance2);
    return bench->near_index != NULL && bench->seed_index != NULL && bench->seed_distance2 != NULL;
}

vor_status vor_seeds_init(struct vor_seeds *out, const struct vor_domain *domain, size_t n,
                          unsigned k, const struct vor_run *run, struct vor_error *err)
{
    struct vor_seeds seeds = {.domain = domain, .run = run, .n = n, .keep_border = 1, .widen = 1};
    unsigned threads = vor_pool_threads(run->pool);
    int ok;

    assert(n >= 1 && k >= 1 && k <= VOR_NEIGHBORS_MAX);
    seeds.k = k < domain->n ? k : (unsigned)domain->n;
    seeds.listed = n > VOR_SEEDS_LISTED ? VOR_SEEDS_LISTED : (unsigned)n - 1;
    vor_disc_init(&seeds.disc, RINGS);
    vor_disc_init(&seeds.fine, RINGS_FINE);
    seeds.xyz = vor_malloc(run->memory, n, 3 * sizeof *seeds.xyz);
    seeds.list = vor_malloc(run->memory, n, seeds.listed * sizeof *seeds.list);
    seeds.distance = vor_malloc(run->memory, n, seeds.listed * sizeof *seeds.distance);
    seeds.bench = vor_calloc(run->memory, threads, sizeof *seeds.bench);
    ok = seeds.xyz != NULL && seeds.list != NULL && seeds.distance != NULL && seeds.bench != NULL;
    for (unsigned i = 0; ok && i < threads; i++)
        ok = alloc_bench(&seeds.bench[i], &seeds);
    if (!ok || vor_near_init(&seeds.near, n, seeds.k, domain->knn, domain->xyz, domain->n,
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
    for (unsigned i = 0; seeds->bench != NULL && i < vor_pool_threads(seeds->run->pool); i++)
        free_bench(&seeds->bench[i], memory);
    vor_free(memory, seeds->bench);
    vor_knn_free(seeds->knn);
    vor_near_free(&seeds->near);
    vor_free(memory, seeds->distance);
    vor_free(memory, seeds->list);
    vor_free(memory, seeds->xyz);
    memset(seeds, 0, sizeof *seeds);
}

vor_status vor_seeds_index(struct vor_seeds *seeds, struct vor_error *err)
{
    vor_knn_free(seeds->knn);
    seeds->knn = NULL;
    return vor_knn_build(&seeds->knn, seeds->xyz, seeds->n, seeds->run->memory, err);
}

/* One search result without the seed itself; among many coincident seeds it may be missing. */
static void list_row(struct vor_seeds *seeds, size_t i, const uint32_t *index,
                     const float *distance2)
{
    uint32_t *list = &seeds->list[i * seeds->listed];
    float *distance = &seeds->distance[i * seeds->listed];
    unsigned at = 0;

    for (unsigned j = 0; j <= seeds->listed && at < seeds->listed; j++) {
        if (index[j] == i)
            continue;
        list[at] = index[j];
        distance[at++] = sqrtf(distance2[j]);
    }
}

void vor_seeds_search(struct vor_seeds *seeds, struct vor_bench *bench, size_t begin, size_t end)
{
    unsigned width = seeds->listed + 1;

    for (size_t i = begin; i < end; i++)
        (void)vor_near_search(&seeds->near, i, &seeds->xyz[3 * i],
                              &bench->near_index[(i - begin) * seeds->k]);
    vor_knn_search(seeds->knn, &seeds->xyz[3 * begin], end - begin, width, bench->seed_index,
                   bench->seed_distance2);
    for (size_t i = begin; i < end; i++)
        list_row(seeds, i, &bench->seed_index[(i - begin) * width],
                 &bench->seed_distance2[(i - begin) * width]);
}

static enum vor_surface_kind fit(const struct vor_seeds *seeds, struct vor_place *place,
                                 const uint32_t *index)
{
    for (unsigned j = 0; j < seeds->k; j++)
        memcpy(&place->near[3 * j], &seeds->domain->xyz[3 * (size_t)index[j]],
               3 * sizeof *place->near);
    vor_surface_fit(&place->surface, place->near, seeds->k);
    return place->surface.kind;
}

enum vor_surface_kind vor_seeds_fit(const struct vor_seeds *seeds, struct vor_bench *bench,
                                    size_t row)
{
    return fit(seeds, &bench->here, &bench->near_index[row * seeds->k]);
}

enum vor_surface_kind vor_seeds_fit_at(const struct vor_seeds *seeds, struct vor_place *place,
                                       const double x[3])
{
    float query[3] = {(float)x[0], (float)x[1], (float)x[2]};
    uint32_t index[VOR_NEIGHBORS_MAX];
    float distance2[VOR_NEIGHBORS_MAX];

    vor_knn_search(seeds->domain->knn, query, 1, seeds->k, index, distance2);
    return fit(seeds, place, index);
}

void vor_seeds_project(const struct vor_surface *surface, double x[3])
{
    double local[3];

    vor_surface_to_local(surface, x, local);
    vor_surface_project(surface, local);
    vor_surface_to_world(surface, local, x);
}

void vor_seeds_border(const struct vor_seeds *seeds, struct vor_bench *bench,
                      struct vor_border *border, const double x[3])
{
    const struct vor_place *there = &bench->there;
    double foot[3] = {(double)there->near[0], (double)there->near[1], (double)there->near[2]};

    *border = (struct vor_border){&there->surface, there->near, seeds->k, there->surface.spacing};
    if (vor_boundary_inside(&there->surface, there->near, seeds->k, x))
        return;
    if (vor_seeds_fit_at(seeds, &bench->foot, foot) != VOR_SURFACE_NONE)
        border->spacing = bench->foot.surface.spacing;
}

/* Mean distance to the six nearest seeds; with fewer seeds the patch spans the whole domain. */
static double patch_radius(const struct vor_seeds *seeds, size_t i)
{
    const float *distance = &seeds->distance[i * seeds->listed];
    double sum = 0;

    if (seeds->listed < 6)
        return 2;
    for (int j = 0; j < 6; j++)
        sum += (double)distance[j];
    return sum / 6;
}

/* Where seed j lies as seen from seed i, in the surface's axes. Coincident seeds get a tangential
 * offset of their own, opposite for the two, so that they part. */
static void offset_of(const struct vor_seeds *seeds, const struct vor_bench *bench, size_t i,
                      size_t j, double offset[3])
{
    const float *a = &seeds->xyz[3 * i], *b = &seeds->xyz[3 * j];
    double d[3] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                   (double)b[2] - (double)a[2]};
    uint64_t low = i < j ? i : j, high = i < j ? j : i;
    double sign = i < j ? 1e-6 : -1e-6;

    for (int c = 0; c < 3; c++)
        offset[c] = vor_dot(bench->here.surface.axis[c], d);
    if (vor_dot(offset, offset) > 0)
        return;
    offset[0] = sign * bench->radius * (0.1 + vor_rng_unit(low, 7, 2 * high));
    offset[1] = sign * bench->radius * (vor_rng_unit(low, 7, 2 * high + 1) - 0.5);
    offset[2] = 0;
}

static int clip_by(const struct vor_seeds *seeds, struct vor_bench *bench, size_t i, size_t j)
{
    double offset[3];

    offset_of(seeds, bench, i, j, offset);
    if (vor_cell_secure(&bench->cell, vor_dot(offset, offset)))
        return 0;
    vor_cell_clip(&bench->cell, offset);
    return 1;
}

/* The list did not secure the cell: looks farther. */
static void clip_more(const struct vor_seeds *seeds, struct vor_bench *bench, size_t i)
{
    uint32_t index[VOR_SEEDS_MORE_MAX];
    float distance2[VOR_SEEDS_MORE_MAX];
    unsigned done = seeds->listed, width = 2 * (seeds->listed + 1);

    while (done + 1 < seeds->n && done + 1 < VOR_SEEDS_MORE_MAX) {
        if (width > VOR_SEEDS_MORE_MAX)
            width = VOR_SEEDS_MORE_MAX;
        if (width > seeds->n)
            width = (unsigned)seeds->n;
        vor_knn_search(seeds->knn, &seeds->xyz[3 * i], 1, width, index, distance2);
        for (unsigned j = done; j < width; j++)
            if (index[j] != i && !clip_by(seeds, bench, i, index[j]))
                return;
        done = width - 1;
        width *= 2;
    }
}

const struct vor_disc *vor_seeds_disc(const struct vor_seeds *seeds, const struct vor_bench *bench)
{
    const double *c = bench->here.surface.c;
    double bend = (fabs(c[3]) + fabs(c[4]) + fabs(c[5])) * bench->radius;

    return bend > BEND_MAX ? &seeds->fine : &seeds->disc;
}

static void end_at_border(const struct vor_seeds *seeds, struct vor_bench *bench)
{
    double side[2], room = vor_boundary_room(&bench->here.surface, bench->here.near, seeds->k,
                                             bench->cell.seed, bench->radius / seeds->widen, side);

    if (room < bench->radius)
        vor_cell_clip(&bench->cell, (double[3]){2 * room * side[0], 2 * room * side[1], 0});
}

enum vor_surface_kind vor_seeds_cell(const struct vor_seeds *seeds, struct vor_bench *bench,
                                     size_t i, size_t row)
{
    const uint32_t *list = &seeds->list[i * seeds->listed];
    double x[3], local[3];

    if (vor_seeds_fit(seeds, bench, row) == VOR_SURFACE_NONE)
        return VOR_SURFACE_NONE;
    vor_seeds_position(seeds, i, x);
    vor_surface_to_local(&bench->here.surface, x, local);
    bench->radius = seeds->widen * patch_radius(seeds, i);
    vor_cell_begin(&bench->cell, vor_seeds_disc(seeds, bench), &bench->here.surface, local,
                   bench->radius);
    if (seeds->keep_border)
        end_at_border(seeds, bench);
    for (unsigned j = 0; j < seeds->listed; j++)
        if (!clip_by(seeds, bench, i, list[j]))
            return bench->here.surface.kind;
    clip_more(seeds, bench, i);
    return bench->here.surface.kind;
}
