#include "core/seeds/fixed.h"

#include "core/base/stat.h"
#include "core/input/islands.h"
#include "core/seeds/uniformity.h"
#include "core/seeds/warm_start.h"

#include <string.h>

/* What the seeds counted before they were made anew. */
struct counted {
    struct vor_counts counts;
    uint64_t indexed;
    double area, coherence;
    uint32_t unused;
};

static struct counted count(const struct vor_seeds *seeds, const struct vor_domain *domain)
{
    struct counted counted = {
        .area = seeds->area, .coherence = seeds->coherence, .unused = domain->previous.unused};

    if (seeds->n == 0)
        return counted;
    counted.unused = seeds->unused;
    counted.counts = vor_seeds_counts(seeds);
    counted.indexed = seeds->point_lists.indexed;
    return counted;
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
    struct counted counted = count(seeds, domain);
    size_t moved = seeds->n;
    int normals = seeds->normal != NULL, tracks = domain->previous.n > 0;
    float *xyz = vor_malloc(run->memory, moved + fixed.n, 3 * sizeof *xyz);
    float *normal = normals ? vor_calloc(run->memory, moved + fixed.n, 3 * sizeof *normal) : NULL;
    uint32_t *track = tracks ? vor_malloc(run->memory, moved + fixed.n, sizeof *track) : NULL;
    vor_status status;

    if (xyz == NULL || (normals && normal == NULL) || (tracks && track == NULL)) {
        VOR_FREE_ALL(run->memory, track, normal, xyz);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", fixed.n);
    }
    if (tracks && moved > 0)
        memcpy(track, seeds->track, moved * sizeof *track);
    if (normals)
        memcpy(normal, seeds->normal, 3 * moved * sizeof *normal);
    if (moved > 0)
        memcpy(xyz, seeds->xyz, 3 * moved * sizeof *xyz);
    if (fixed.n > 0)
        memcpy(&xyz[3 * moved], fixed.xyz, 3 * fixed.n * sizeof *xyz);
    vor_seeds_free(seeds);
    status = vor_seeds_init(seeds, domain, moved + fixed.n, policy, run, err);
    if (status == VOR_OK) {
        struct vor_scratch *scratch = &seeds->scratch[0];

        memcpy(seeds->xyz, xyz, 3 * seeds->n * sizeof *xyz);
        seeds->normal = normal;
        normal = NULL;
        seeds->track = track;
        track = NULL;
        seeds->unused = counted.unused;
        seeds->coherence = counted.coherence;
        if (tracks)
            vor_warm_start_number(seeds, moved);
        seeds->area = counted.area;
        seeds->indexed_before = counted.indexed;
        scratch->queries = counted.counts.queries;
        scratch->cells = counted.counts.cells;
        scratch->bisectors = counted.counts.bisectors;
        scratch->triangles = counted.counts.triangles;
    }
    VOR_FREE_ALL(run->memory, track, normal, xyz);
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
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
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
    size_t sites = seeds->fixed;
    float *xyz;
    vor_status status;

    if (domain->islands.count == 0)
        return VOR_OK;
    xyz = vor_malloc(run->memory, share, 3 * sizeof *xyz);
    if (xyz == NULL && share > 0)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", share);
    fixed.xyz = xyz;
    status = measure(delta_beside, seeds, err);
    VOR_THEN(status, vor_islands_place(xyz, domain, share, &whole, err));
    VOR_THEN(status, vor_islands_return(domain, &whole, err));
    VOR_THEN(status, add_fixed(seeds, fixed, domain, policy, run, err));
    if (status == VOR_OK && sites > 0)
        seeds->fixed = sites + share;
    vor_free(run->memory, xyz);
    return status;
}

vor_status vor_seeds_add_input(struct vor_seeds *seeds, const struct vor_domain *domain,
                               struct vor_seeds_policy policy, const struct vor_run *run,
                               struct vor_error *err)
{
    struct fixed fixed = {domain->xyz, domain->n};
    vor_status status = add_fixed(seeds, fixed, domain, policy, run, err);

    if (status == VOR_OK)
        seeds->fixed = domain->n;
    return status;
}

size_t vor_seeds_beside_sites(size_t n, const struct vor_sites *sites)
{
    return n - sites->half + sites->half / 2;
}

/* Takes seeds out: those whose squared distance is less than `far2`, and of those where it is equal
 * the first, until `wanted` are left. */
static void keep_far(struct vor_seeds *seeds, const float *distance2, float far2, size_t wanted)
{
    size_t nearer = 0, kept = 0, equal;

    for (size_t i = 0; i < seeds->n; i++)
        nearer += distance2[i] < far2;
    equal = seeds->n - nearer - wanted; /* that go, of those at far2 */
    for (size_t i = 0; i < seeds->n; i++) {
        if (distance2[i] < far2 || (distance2[i] == far2 && equal > 0 && equal-- > 0))
            continue;
        if (seeds->track != NULL)
            seeds->track[kept] = seeds->track[i];
        memmove(&seeds->xyz[3 * kept++], &seeds->xyz[3 * i], 3 * sizeof *seeds->xyz);
    }
    seeds->n = kept;
}

/* How far seed i lies outside of the border, at the place along it that is nearest. */
static double beyond(const struct vor_seeds *seeds, const struct vor_sites *sites, size_t i,
                     uint32_t nearest)
{
    double sum = 0;

    for (size_t c = 0; c < 3; c++)
        sum += ((double)seeds->xyz[3 * i + c] - (double)sites->place[3 * (size_t)nearest + c]) *
               (double)sites->outward[3 * (size_t)nearest + c];
    return sum;
}

/* Sets how far each seed is from the lines of sites, squared; less than 0 where it lies outside. */
static void look(float *distance2, uint32_t *index, const struct vor_seeds *seeds,
                 const struct vor_sites *sites, const struct vor_knn *knn)
{
    vor_knn_search(knn, seeds->xyz, seeds->n, 1, index, distance2);
    for (size_t i = 0; i < seeds->n; i++)
        if (beyond(seeds, sites, i, index[i]) > 0)
            distance2[i] = -distance2[i];
}

/* Takes out the seeds that lie outside of borders, the farthest first, and then those nearest to
 * the lines of sites, until `wanted` are left. */
static vor_status make_way(struct vor_seeds *seeds, const struct vor_sites *sites, size_t wanted,
                           struct vor_memory *memory, struct vor_error *err)
{
    size_t n = seeds->n, surplus = n - wanted;
    float *distance2 = vor_malloc(memory, n, sizeof *distance2),
          *sorted = vor_malloc(memory, n, sizeof *sorted);
    uint32_t *index = vor_malloc(memory, n, sizeof *index);
    struct vor_knn *knn = NULL;
    vor_status status = VOR_E_NOMEM;

    if (distance2 == NULL || sorted == NULL || index == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    } else {
        status = vor_knn_build(&knn, sites->place, sites->places, memory, err);
        if (status == VOR_OK && surplus > 0) {
            look(distance2, index, seeds, sites, knn);
            memcpy(sorted, distance2, n * sizeof *sorted);
            vor_sort_floats(sorted, n);
            keep_far(seeds, distance2, sorted[surplus - 1], wanted);
            look(distance2, index, seeds, sites, knn);
            /* Those left outside go onto the border. */
            for (size_t i = 0; i < seeds->n; i++) {
                double far = beyond(seeds, sites, i, index[i]);

                for (size_t c = 0; distance2[i] < 0 && c < 3; c++)
                    seeds->xyz[3 * i + c] -=
                        (float)(far * (double)sites->outward[3 * (size_t)index[i] + c]);
            }
        }
    }
    vor_knn_free(knn);
    VOR_FREE_ALL(memory, index, sorted, distance2);
    return status;
}

vor_status vor_seeds_add_sites(struct vor_seeds *seeds, const struct vor_sites *sites, size_t n,
                               const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    if (sites->n == 0)
        return VOR_OK;
    status = make_way(seeds, sites, n - sites->n, run->memory, err);
    if (status == VOR_OK)
        status = add_fixed(seeds, (struct fixed){sites->xyz, sites->n}, seeds->whole, seeds->policy,
                           run, err);
    if (status == VOR_OK) {
        seeds->fixed = sites->n;
        seeds->half = sites->half;
    }
    return status;
}
