#include "core/output/compare.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

/* Points at the border are only counted, for the report; inputs as in geom/boundary.h. */

/* Cosine of 130 degrees, the angle that is left free. At 100 / 130 / 160 degrees: border points of
 * square 146 / 147 / 121, of bunny 37 / 28 / 11, of autzen 396 / 342 / 266. */
#define FREE_COSINE (-0.64278760968653936)
/* Spacings of the result, and of the input, from the point to the place ahead. At 0.375 / 0.75
 * / 1.5 of the result: border points of bunny 30 / 28 / 20, of autzen 347 / 342 / 320, of square
 * 147 each. At 0.25 / 0.5 / 1 of the input no number differs by more than with the seed; those keep
 * the place ahead from being the point's own foot where the input is sparser than the result. */
#define AHEAD 0.75

enum {
    BLOCK = 1024, /* points of one task */
    AROUND = 32 /* most points of a first ring: an even result has six, a draw hardly ever more than
                   20 */
};

static void add(struct vor_sums *sums, double distance2)
{
    vor_sums_add(sums, sqrt(distance2), distance2);
}

struct compare {
    struct vor_seeds *seeds;
    struct vor_sums *block;
    const struct vor_knn *knn; /* over the seeds */
    size_t points;             /* of the domain, whose distances are taken */
    double spacing;
    int refined;
    atomic_size_t border, fitted[VOR_NEIGHBORS_MAX + 1];
};

static void in_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct compare *compare = ctx;
    const struct vor_domain *domain = compare->seeds->domain;
    struct vor_sums sums = {0};
    uint32_t index[VOR_KNN_NEAR_MAX];
    float query[3 * VOR_KNN_NEAR_MAX], distance2[VOR_KNN_NEAR_MAX];
    struct vor_knn_near near = {query, 0, 1, NULL, 0};

    for (size_t i = begin; i < end; i += near.count) {
        near.count = end - i < VOR_KNN_NEAR_MAX ? end - i : VOR_KNN_NEAR_MAX;
        for (size_t j = 0; j < near.count; j++)
            memcpy(&query[3 * j],
                   &domain->xyz[3 * (size_t)((uint64_t)(i + j) * domain->n / compare->points)],
                   3 * sizeof *query);
        vor_knn_search_near(compare->knn, &near, index, distance2);
        for (size_t j = 0; j < near.count; j++)
            add(&sums, vor_distance2f(&query[3 * j], &compare->seeds->xyz[3 * (size_t)index[j]]));
    }
    compare->block[begin / BLOCK] = sums;
}

/* Directions, along the surface of scratch->here, from seed i to the points in the first ring
 * around it. Returns how many there are. */
static unsigned directions(const struct compare *compare, const struct vor_scratch *scratch,
                           size_t i, double direction[AROUND][2])
{
    const struct vor_crowd *crowd = &scratch->crowd;
    const float *xyz = compare->seeds->xyz;
    double within2;
    unsigned count = 0;

    if (crowd->count < 3)
        return 0;
    within2 = VOR_RIM_RING * VOR_RIM_RING * (double)crowd->distance2[2];
    for (unsigned j = 0; j < crowd->count && count < AROUND; j++) {
        const float *other = &xyz[3 * (size_t)crowd->index[j]];
        double d[3], along[2], length;

        if ((double)crowd->distance2[j] > within2)
            break;
        vor_way(d, &xyz[3 * i], other);
        along[0] = vor_dot(scratch->here.surface.axis[0], d);
        along[1] = vor_dot(scratch->here.surface.axis[1], d);
        length = sqrt(along[0] * along[0] + along[1] * along[1]);
        if (!(length > 0))
            continue;
        direction[count][0] = along[0] / length;
        direction[count++][1] = along[1] / length;
    }
    return count;
}

/* Whether the points around seed i leave one side of it free. */
static int free_side(const struct compare *compare, const struct vor_scratch *scratch, size_t i,
                     double side[3])
{
    double direction[AROUND][2], free_to[2];
    unsigned count = directions(compare, scratch, i, direction);

    if (!vor_boundary_free_side(direction, count, FREE_COSINE, free_to))
        return 0;
    for (int c = 0; c < 3; c++)
        side[c] = free_to[0] * scratch->here.surface.axis[0][c] +
                  free_to[1] * scratch->here.surface.axis[1][c];
    return 1;
}

/* Whether the input ends ahead of x, in the direction `side`. */
static int ends(const struct compare *compare, struct vor_scratch *scratch, const double x[3],
                const double side[3])
{
    const struct vor_seeds *seeds = compare->seeds;
    const struct vor_place *foot = &scratch->foot;
    double far = AHEAD * (compare->spacing + scratch->here.surface.spacing);
    double at[3], local[3], away[2], end[3];
    uint32_t index;
    float query[3], distance2;

    for (int c = 0; c < 3; c++)
        query[c] = (float)(x[c] + far * side[c]);
    vor_knn_search(seeds->domain->knn, query, 1, 1, &index, &distance2);
    vor_to_doubles(at, &seeds->domain->xyz[3 * (size_t)index]);
    if (vor_seeds_fit_at(seeds, scratch, &scratch->foot, at) == VOR_SURFACE_NONE)
        return 0;
    vor_surface_to_local(&foot->surface, at, local);
    if (isinf(vor_boundary_room(&foot->surface, foot->near, foot->k, local, foot->surface.reach,
                                away)))
        return 0;
    for (int c = 0; c < 3; c++)
        end[c] = away[0] * foot->surface.axis[0][c] + away[1] * foot->surface.axis[1][c];
    return vor_dot(end, side) > VOR_SAME_WAY;
}

static void out_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct compare *compare = ctx;
    struct vor_seeds *seeds = compare->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    struct vor_sums sums = {0};
    size_t border = 0, fitted[VOR_NEIGHBORS_MAX + 1] = {0};

    for (size_t i = begin; i < end; i++) {
        enum vor_surface_kind kind;
        struct vor_surface surface;
        double x[3], side[3];

        if (vor_run_is_late(&seeds->run)) {
            uint32_t index;
            float distance2;

            vor_knn_search(seeds->domain->knn, &seeds->xyz[3 * i], 1, 1, &index, &distance2);
            add(&sums, vor_distance2f(&seeds->xyz[3 * i], &seeds->domain->xyz[3 * (size_t)index]));
            continue;
        }
        kind = vor_seeds_fit(seeds, scratch, i);
        surface = scratch->here.surface;
        add(&sums, vor_distance2f(&seeds->xyz[3 * i], scratch->here.near));
        /* The surface that the last step of the polish used where the seed is now. */
        fitted[kind != VOR_SURFACE_NONE && compare->refined &&
                       vor_seeds_refine(seeds, scratch, i, &surface)
                   ? VOR_REFINED_TO
                   : scratch->here.k]++;
        if (kind == VOR_SURFACE_NONE)
            continue;
        vor_seeds_crowd(seeds, scratch, i);
        vor_seeds_position(seeds, i, x);
        border += free_side(compare, scratch, i, side) && ends(compare, scratch, x, side);
    }
    compare->block[begin / BLOCK] = sums;
    atomic_fetch_add(&compare->border, border);
    for (unsigned k = 0; k <= VOR_NEIGHBORS_MAX; k++)
        if (fitted[k] > 0)
            atomic_fetch_add(&compare->fitted[k], fitted[k]);
}

/* Runs a task over n rows and sums the distances of its blocks. */
static vor_status over_blocks(struct vor_compare_apart *out, struct compare *compare, size_t n,
                              vor_task task, struct vor_error *err)
{
    const struct vor_run *run = &compare->seeds->run;
    size_t blocks = (n + BLOCK - 1) / BLOCK;
    struct vor_sums all = {0};
    vor_status status;

    compare->block = vor_malloc(run->memory, blocks, sizeof *compare->block);
    if (compare->block == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_run_for(run, n, BLOCK, task, compare, err);
    for (size_t b = 0; status == VOR_OK && b < blocks; b++)
        vor_sums_merge(&all, &compare->block[b]);
    if (status == VOR_OK) {
        struct vor_stat stat = vor_sums_stat(&all, n);

        *out = (struct vor_compare_apart){stat.mean, stat.rms, stat.max, n};
    }
    vor_free(run->memory, compare->block);
    return status;
}

vor_status vor_compare_ref_to_out(struct vor_compare_apart *out, struct vor_mls_error *error,
                                  struct vor_seeds *seeds, struct vor_error *err)
{
    struct compare compare = {.seeds = seeds, .points = seeds->domain->n};
    struct vor_knn *knn = NULL;
    vor_status status = vor_knn_build_along(&knn, seeds->xyz, seeds->n, &seeds->run, err);

    if (compare.points > VOR_COMPARE_POINTS)
        compare.points = VOR_COMPARE_POINTS;
    compare.knn = knn;
    VOR_THEN(status, over_blocks(out, &compare, compare.points, in_block, err));
    if (status == VOR_OK && error != NULL && seeds->n >= VOR_MLS_ERROR_LEAST)
        status = vor_mls_error_measure(
            error,
            &(struct vor_mls_error_of){seeds->xyz, seeds->n, knn, seeds->domain->xyz,
                                       seeds->domain->n, VOR_COMPARE_ERROR_POINTS},
            &seeds->run, err);
    vor_knn_free(knn);
    return status;
}

vor_status vor_compare(struct vor_comparison *out, struct vor_seeds *seeds, double spacing,
                       int refined, struct vor_error *err)
{
    struct compare compare = {.seeds = seeds, .spacing = spacing, .refined = refined};
    struct vor_comparison found = {.border = 0};
    vor_status status;

    assert(vor_seeds_on_whole(seeds));
    status = over_blocks(&found.out_to_ref, &compare, seeds->n, out_block, err);
    VOR_THEN(status, vor_compare_ref_to_out(&found.ref_to_out, &found.mls_error, seeds, err));
    if (status != VOR_OK)
        return status;
    found.border = atomic_load(&compare.border);
    for (unsigned k = 0; k <= VOR_NEIGHBORS_MAX; k++)
        found.fitted[k] = atomic_load(&compare.fitted[k]);
    *out = found;
    return VOR_OK;
}
