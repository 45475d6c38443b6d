#include "core/seeds/fixed.h"

#include "core/input/islands.h"
#include "core/seeds/uniformity.h"

#include <string.h>

/* What the seeds counted before they were made anew. */
struct counted {
    struct vor_counts counts;
    uint64_t indexed;
    double area;
};

static struct counted count(const struct vor_seeds *seeds)
{
    struct counted counted = {.area = seeds->area};

    if (seeds->n == 0)
        return counted;
    counted.counts = vor_seeds_counts(seeds);
    counted.indexed = seeds->point_lists.indexed;
    return counted;
}

static void count_on(struct vor_seeds *seeds, const struct counted *counted)
{
    struct vor_scratch *scratch = &seeds->scratch[0];

    seeds->area = counted->area;
    seeds->indexed_before = counted->indexed;
    scratch->queries = counted->counts.queries;
    scratch->cells = counted->counts.cells;
    scratch->bisectors = counted->counts.bisectors;
    scratch->triangles = counted->counts.triangles;
}

/* Points that do not move; borrowed. */
struct fixed {
    const float *xyz; /* n x 3, normalised */
    size_t n;
};

/* Puts the seeds and the fixed points after them onto a domain with the same coordinates. */
static vor_status add_fixed(struct vor_seeds *seeds, struct fixed fixed,
                            const struct vor_domain *domain, struct vor_seeds_policy policy,
                            const struct vor_run *run, struct vor_error *err)
{
    struct counted counted = count(seeds);
    size_t moved = seeds->n;
    float *xyz = vor_malloc(run->memory, moved + fixed.n, 3 * sizeof *xyz);
    vor_status status;

    if (xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points that do not move", fixed.n);
    if (moved > 0)
        memcpy(xyz, seeds->xyz, 3 * moved * sizeof *xyz);
    if (fixed.n > 0)
        memcpy(&xyz[3 * moved], fixed.xyz, 3 * fixed.n * sizeof *xyz);
    vor_seeds_free(seeds);
    status = vor_seeds_init(seeds, domain, moved + fixed.n, policy, run, err);
    if (status == VOR_OK) {
        memcpy(seeds->xyz, xyz, 3 * seeds->n * sizeof *xyz);
        count_on(seeds, &counted);
    }
    vor_free(run->memory, xyz);
    return status;
}

static vor_status measure(double *delta, struct vor_seeds *seeds, struct vor_error *err)
{
    struct vor_uniformity even;
    float *nearest;
    vor_status status;

    if (seeds->n == 0)
        return VOR_OK;
    nearest = vor_malloc(seeds->run.memory, seeds->n, sizeof *nearest);
    if (nearest == NULL)
        return vor_fail(err, VOR_E_NOMEM, "distances of %zu points", seeds->n);
    status = vor_seeds_uniformity_now(&even, nearest, seeds, err);
    if (status == VOR_OK)
        *delta = even.delta;
    vor_free(seeds->run.memory, nearest);
    return status;
}

vor_status vor_seeds_add_islands(struct vor_seeds *seeds, double *delta_beside,
                                 struct vor_domain *domain, size_t share,
                                 struct vor_seeds_policy policy, const struct vor_run *run,
                                 struct vor_error *err)
{
    const struct vor_run whole = vor_run_unstoppable(run);
    struct fixed fixed = {NULL, share};
    float *xyz;
    vor_status status;

    if (domain->islands.count == 0)
        return VOR_OK;
    xyz = vor_malloc(run->memory, share, 3 * sizeof *xyz);
    if (xyz == NULL && share > 0)
        return vor_fail(err, VOR_E_NOMEM, "%zu points on islands", share);
    fixed.xyz = xyz;
    status = measure(delta_beside, seeds, err);
    if (status == VOR_OK)
        status = vor_islands_place(xyz, domain, share, &whole, err);
    if (status == VOR_OK)
        status = vor_islands_return(domain, &whole, err);
    if (status == VOR_OK)
        status = add_fixed(seeds, fixed, domain, policy, run, err);
    vor_free(run->memory, xyz);
    return status;
}
