#include "core/method/settle.h"

#include "core/geom/boundary.h"

#include "core/base/linalg.h"

#include <stdatomic.h>
#include <string.h>

enum { FEW = 12, EXACT = 20 }; /* neighbours: for a finer fit; at most, where the input is exact */

#define FINER 2.0 /* times less variance about its surface makes a fit to fewer neighbours finer   \
                   */
#define TRUSTED                                                                                    \
    2.0 /* times the coarser fit's variance that the finer one may move a seed, squared */

/* Where more of the seeds than this lie beyond the input, gaps are how it was taken, and no holes.
 */
#define GAPPY 0.03

struct settle {
    struct vor_seeds *seeds;
    int landing; /* the surface at hand is new to the seeds */
    atomic_size_t beyond;
};

/* Counts the seeds that vor_seeds_hold would move. */
static void count_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct settle *settle = ctx;
    struct vor_seeds *seeds = settle->seeds;
    struct vor_bench *bench = &seeds->bench[worker];
    size_t beyond = 0;
    double x[3];

    for (size_t i = begin; i < end; i++) {
        vor_seeds_position(seeds, i, x);
        beyond +=
            vor_seeds_fit(seeds, bench, i) != VOR_SURFACE_NONE && vor_seeds_hold(seeds, bench, x);
    }
    atomic_fetch_add(&settle->beyond, beyond);
}

static void settle_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct settle *settle = ctx;
    struct vor_seeds *seeds = settle->seeds;
    struct vor_bench *bench = &seeds->bench[worker];
    struct vor_border border;

    for (size_t i = begin; i < end; i++) {
        int moved = settle->landing;
        double x[3];

        vor_seeds_position(seeds, i, x);
        if (vor_seeds_fit(seeds, bench, i) == VOR_SURFACE_NONE)
            continue;
        if (settle->landing)
            vor_seeds_project(&bench->here.surface, x);
        if (seeds->keep_border) {
            vor_seeds_border(seeds, bench, &bench->here, &border, x);
            moved |= seeds->keep_holes && vor_seeds_hold(seeds, bench, x);
            moved |= vor_boundary_restrict(&border, VOR_BORDER_SETTLED, x);
        }
        for (size_t c = 0; moved && c < 3; c++)
            seeds->xyz[3 * i + c] = (float)x[c];
    }
}

/* Variance of the neighbours about the surface fitted to them. */
static double residual2(const struct vor_surface *surface, const float *near, unsigned k)
{
    double sum = 0;

    for (unsigned j = 0; j < k; j++) {
        double x[3] = {(double)near[3 * j], (double)near[3 * j + 1], (double)near[3 * j + 2]};
        double local[3], off;

        vor_surface_to_local(surface, x, local);
        off = local[2] - vor_surface_height(surface, local[0], local[1], NULL);
        sum += off * off;
    }
    return sum / (k - 6);
}

/* Brings the `few` neighbours nearest to the seed to the front. */
static void nearest_first(float *near, unsigned k, unsigned few, const float *x)
{
    for (unsigned i = 0; i < few; i++) {
        unsigned best = i;
        float swap[3];

        for (unsigned j = i + 1; j < k; j++)
            if (vor_distance2f(&near[3 * j], x) < vor_distance2f(&near[3 * best], x))
                best = j;
        memcpy(swap, &near[3 * i], sizeof swap);
        memcpy(&near[3 * i], &near[3 * best], sizeof swap);
        memcpy(&near[3 * best], swap, sizeof swap);
    }
}

static void refine_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct settle *settle = ctx;
    struct vor_seeds *seeds = settle->seeds;
    struct vor_bench *bench = &seeds->bench[worker];

    for (size_t i = begin; i < end; i++) {
        struct vor_surface fine;
        double x[3], y[3], coarse2;

        vor_seeds_position(seeds, i, x);
        if (vor_seeds_fit(seeds, bench, i) != VOR_SURFACE_QUADRIC)
            continue;
        coarse2 = residual2(&bench->here.surface, bench->here.near, seeds->k);
        nearest_first(bench->here.near, seeds->k, FEW, &seeds->xyz[3 * i]);
        vor_surface_fit(&fine, bench->here.near, FEW);
        if (fine.kind != VOR_SURFACE_QUADRIC ||
            FINER * residual2(&fine, bench->here.near, FEW) > coarse2)
            continue;
        memcpy(y, x, sizeof y);
        vor_seeds_project(&fine, y);
        for (int c = 0; c < 3; c++)
            x[c] -= y[c];
        if (vor_dot(x, x) > TRUSTED * coarse2)
            continue;
        for (size_t c = 0; c < 3; c++)
            seeds->xyz[3 * i + c] = (float)y[c];
    }
}

vor_status vor_refine(struct vor_seeds *seeds, struct vor_error *err)
{
    struct settle settle = {.seeds = seeds};

    if (seeds->k <= FEW || seeds->k > EXACT)
        return VOR_OK;
    return vor_run_for(seeds->run, seeds->n, VOR_SEEDS_BLOCK, refine_block, &settle, err);
}

vor_status vor_settle(struct vor_seeds *seeds, struct vor_error *err)
{
    struct settle settle = {.seeds = seeds};
    vor_status status;

    if (!seeds->keep_border)
        return VOR_OK;
    status = vor_run_for(seeds->run, seeds->n, VOR_SEEDS_BLOCK, count_block, &settle, err);
    if (status != VOR_OK)
        return status;
    seeds->keep_holes = (double)settle.beyond <= GAPPY * (double)seeds->n;
    return vor_run_for(seeds->run, seeds->n, VOR_SEEDS_BLOCK, settle_block, &settle, err);
}

vor_status vor_land(struct vor_seeds *seeds, struct vor_error *err)
{
    struct settle settle = {.seeds = seeds, .landing = 1};
    struct vor_run calm_run = *seeds->run;
    struct vor_calm calm;

    if (vor_seeds_on_whole(seeds))
        return VOR_OK;
    vor_seeds_onto(seeds, seeds->whole);
    calm_run.watch = vor_calm_watch(&calm, seeds->run->watch);
    return vor_run_for(&calm_run, seeds->n, VOR_SEEDS_BLOCK, settle_block, &settle, err);
}
