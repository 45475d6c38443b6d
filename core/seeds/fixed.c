#include "core/seeds/fixed.h"

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

vor_status vor_seeds_add_fixed(struct vor_seeds *seeds, struct vor_fixed fixed,
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
