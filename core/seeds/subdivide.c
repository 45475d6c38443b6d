#include "core/seeds/subdivide.h"

#include "core/base/linalg.h"
#include "core/base/morton.h"
#include "core/base/stat.h"
#include "core/geom/boundary.h"
#include "core/geom/flat.h"

#include <math.h>
#include <string.h>

/* Number of the line that a border cuts a cell by. */
#define BORDER (VOR_FLAT_SIDE + VOR_PATCH_OCTAGON)

struct find {
    struct vor_seeds *seeds;
    struct vor_seed_edges *of;
};

/* Places that seeds are added at. */
struct places {
    size_t n, most;
    float *xyz;    /* most x 3 */
    float *length; /* most: of the edges that they are the middles of, squared, over those wanted */
};

/* Clips the flat cell of seed i, which scratch->here and scratch->crowd belong to. */
static void clip(struct vor_flat *cell, const struct vor_seeds *seeds,
                 const struct vor_scratch *scratch, size_t i, struct vor_seed_edges *out)
{
    const struct vor_surface *surface = &scratch->here.surface;
    const struct vor_crowd *crowd = &scratch->crowd;
    double x[3], local[3], radius = 2, room = INFINITY;
    double side[2] = {0}; /* clang-analyzer cannot see that room < radius sets it */

    vor_seeds_position(seeds, i, x);
    vor_surface_to_local(surface, x, local);
    for (unsigned j = 0; j < crowd->count && j < 6; j++)
        radius = 1.5 * sqrt((double)crowd->distance2[j]);
    vor_flat_begin(cell, vor_patch_octagon, VOR_PATCH_OCTAGON, radius);
    if (seeds->policy.keep_border)
        room = vor_boundary_room(surface, scratch->here.near, scratch->here.k, local, radius, side);
    if (room < radius) {
        vor_flat_clip(cell, side, room, BORDER);
        for (int c = 0; c < 3; c++)
            x[c] += room / 2 * (side[0] * surface->axis[0][c] + side[1] * surface->axis[1][c]);
        vor_surface_put(surface, x);
        vor_to_floats(out->outside, x);
    }
    for (unsigned j = 0; j < crowd->count; j++) {
        const float *to = &seeds->xyz[3 * (size_t)crowd->index[j]], *from = &seeds->xyz[3 * i];
        double d[3], length2 = (double)crowd->distance2[j];

        if (length2 >= 4 * cell->far2)
            break;
        vor_way(d, from, to);
        vor_flat_clip(cell, (double[2]){vor_dot(surface->axis[0], d), vor_dot(surface->axis[1], d)},
                      length2 / 2, crowd->index[j]);
    }
}

static void find_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct find *find = ctx;
    struct vor_seeds *seeds = find->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    const struct vor_surface *surface = &scratch->here.surface;

    for (size_t i = begin; i < end; i++) {
        struct vor_seed_edges *out = &find->of[i];
        struct vor_flat cell;
        double x[3], normal[3];
        int reaches = 0;

        out->outside[0] = NAN;
        if (vor_run_is_late(&seeds->run) || vor_seeds_fit(seeds, scratch, i) == VOR_SURFACE_NONE)
            continue;
        vor_seeds_crowd(seeds, scratch, i);
        clip(&cell, seeds, scratch, i, out);
        vor_seeds_position(seeds, i, x);
        vor_surface_to_local(surface, x, normal);
        vor_surface_normal(surface, normal, normal);
        vor_to_floats(out->normal, normal);
        for (unsigned e = 0; e < cell.count; e++) {
            uint32_t j = cell.id[e];

            reaches |= j == BORDER;
            out->open |= j >= VOR_FLAT_SIDE;
            if (j >= VOR_FLAT_SIDE || out->count == VOR_EDGES_MOST)
                continue;
            for (size_t c = 0; c < 3; c++)
                x[c] = ((double)seeds->xyz[3 * i + c] + (double)seeds->xyz[3 * (size_t)j + c]) / 2;
            vor_surface_put(surface, x);
            vor_to_floats(out->middle[out->count], x);
            out->to[out->count++] = j;
        }
        if (!reaches)
            out->outside[0] = NAN;
    }
}

static int has(const struct vor_seed_edges *edges, size_t to)
{
    for (unsigned e = 0; e < edges->count; e++)
        if (edges->to[e] == to)
            return 1;
    return 0;
}

/* Whether the edge from seed i to seed j leaves the surface at one end and comes back from the
 * other side at the other: on a surface that bends evenly its angles with both normals are the
 * same. */
static int leaves(const struct vor_seeds *seeds, const struct vor_seeds_edges *edges, size_t i,
                  size_t j)
{
    const float *a = edges->of[i].normal, *b = edges->of[j].normal;
    double along = 0, from = 0, to = 0, length2 = 0;

    for (size_t c = 0; c < 3; c++) {
        double d = (double)seeds->xyz[3 * j + c] - (double)seeds->xyz[3 * i + c];

        along += (double)a[c] * (double)b[c];
        from += (double)a[c] * d;
        to += (double)b[c] * d;
        length2 += d * d;
    }
    from += along < 0 ? -to : to;
    return from * from > length2 / 4;
}

vor_status vor_seeds_edges_find(struct vor_seeds_edges *out, struct vor_seeds *seeds,
                                struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct vor_seeds_edges edges = {.of = vor_calloc(memory, seeds->n, sizeof *edges.of)};
    struct find find = {seeds, edges.of};
    vor_status status;

    if (edges.of == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    status = vor_seeds_index(seeds, &seeds->run, err);
    VOR_THEN(status, vor_run_for(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, find_block, &find, err));
    if (status != VOR_OK) {
        vor_seeds_edges_free(&edges, memory);
        return status;
    }
    for (size_t i = 0; i < seeds->n; i++) {
        edges.open += edges.of[i].open;
        for (unsigned e = 0; e < edges.of[i].count; e++) {
            size_t j = edges.of[i].to[e];

            edges.doubtful += !has(&edges.of[j], i) || (i < j && leaves(seeds, &edges, i, j));
        }
    }
    *out = edges;
    return VOR_OK;
}

void vor_seeds_edges_free(struct vor_seeds_edges *edges, struct vor_memory *memory)
{
    vor_free(memory, edges->of);
    *edges = (struct vor_seeds_edges){.of = NULL};
}

static void add(struct places *places, const float at[3], float length)
{
    places->length[places->n] = length;
    memcpy(&places->xyz[3 * places->n++], at, 3 * sizeof *at);
}

/* Adds the middles of the edges, and where a cell reaches the border a place on its way there. */
static void add_middles(struct places *places, const struct vor_seeds *seeds,
                        const struct vor_seeds_edges *edges)
{
    for (size_t i = 0; i < seeds->n; i++) {
        const struct vor_seed_edges *at = &edges->of[i];

        for (unsigned e = 0; e < at->count; e++) {
            size_t j = at->to[e];
            double wanted = vor_wanted_at(&seeds->wanted, i) * vor_wanted_at(&seeds->wanted, j),
                   length2 = vor_distance2f(&seeds->xyz[3 * i], &seeds->xyz[3 * j]) / wanted;

            if (j > i || !has(&edges->of[j], i))
                add(places, at->middle[e], (float)length2);
        }
        if (!isnan(at->outside[0]))
            add(places, at->outside, INFINITY);
    }
}

/* Keeps the `wanted` places of the longest edges. */
static vor_status keep_longest(struct places *places, size_t wanted, struct vor_memory *memory,
                               struct vor_error *err)
{
    size_t drop = places->n - wanted, kept = 0, below = 0;
    float *sorted = vor_malloc(memory, places->n, sizeof *sorted), least;

    if (sorted == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", places->n);
    memcpy(sorted, places->length, places->n * sizeof *sorted);
    vor_sort_floats(sorted, places->n);
    least = sorted[drop];
    while (sorted[below] < least)
        below++;
    vor_free(memory, sorted);
    drop -= below; /* of those as long as the shortest that stays */
    for (size_t k = 0; k < places->n; k++) {
        if (places->length[k] < least || (places->length[k] <= least && drop > 0 && drop-- > 0))
            continue;
        memmove(&places->xyz[3 * kept++], &places->xyz[3 * k], 3 * sizeof *places->xyz);
    }
    places->n = kept;
    return VOR_OK;
}

/* Adds `missing` places in triangles, at equal steps along the order of the seeds, or at seeds
 * without one. */
static void add_missing(struct places *places, size_t missing, const struct vor_seeds *seeds,
                        const struct vor_seeds_edges *edges)
{
    for (size_t k = 0; k < missing; k++) {
        size_t i = (size_t)((uint64_t)k * seeds->n / missing);
        const struct vor_seed_edges *at = &edges->of[i];
        float x[3];

        for (size_t c = 0; c < 3; c++)
            x[c] =
                at->count > 1 ? (at->middle[0][c] + at->middle[1][c]) / 2 : seeds->xyz[3 * i + c];
        add(places, x, 0);
    }
}

/* Takes the places in Morton order. */
static vor_status take(struct vor_seeds *fine, const struct places *places, struct vor_error *err)
{
    struct vor_memory *memory = fine->run.memory;
    uint32_t *order = vor_malloc(memory, fine->n, sizeof *order);
    vor_status status;

    if (order == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", fine->n);
    status = vor_morton_order(order, places->xyz, fine->n, &fine->run, err);
    if (status == VOR_OK)
        vor_gather(fine->xyz, places->xyz, order, fine->n);
    vor_free(memory, order);
    return status;
}

vor_status vor_seeds_subdivide(struct vor_seeds *fine, const struct vor_seeds *coarse,
                               const struct vor_seeds_edges *edges, struct vor_error *err)
{
    struct vor_memory *memory = fine->run.memory;
    size_t wanted = fine->n - coarse->n;
    struct places places = {.most = fine->n};
    vor_status status = VOR_OK;

    for (size_t i = 0; i < coarse->n; i++)
        places.most += edges->of[i].count + (size_t)1;
    if (VOR_MAKE_ALL(memory, err, places.most, VOR_ARRAY(places.xyz, places.most, 3),
                     VOR_ARRAY(places.length, places.most, 1)) != VOR_OK) {
        VOR_FREE_ALL(memory, places.length, places.xyz);
        return VOR_E_NOMEM;
    }
    add_middles(&places, coarse, edges);
    if (places.n > wanted)
        status = keep_longest(&places, wanted, memory, err);
    if (status == VOR_OK) {
        add_missing(&places, wanted - places.n, coarse, edges);
        for (size_t i = 0; i < coarse->n; i++)
            add(&places, &coarse->xyz[3 * i], 0);
        status = take(fine, &places, err);
    }
    VOR_FREE_ALL(memory, places.length, places.xyz);
    return status;
}
