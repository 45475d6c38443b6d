#include "core/cvt/cvt.h"

#include "core/cvt/descend.h"
#include "core/cvt/lloyd.h"
#include "core/input/thin.h"
#include "core/seeds/area.h"
#include "core/seeds/checkpoint.h"
#include "core/seeds/coarse.h"
#include "core/seeds/fixed.h"
#include "core/seeds/repel.h"
#include "core/seeds/start.h"

#include <math.h>

/* Places sites along borders or edges, and starts the other seeds beside them. */
static vor_status start_with_sites(struct vor_seeds *seeds, const struct vor_domain *domain,
                                   size_t n, const struct vor_spec *spec, const struct vor_run *run,
                                   struct vor_error *err)
{
    const struct vor_run whole = vor_run_unstoppable(run);
    struct vor_sites_for wanted = {.n = n,
                                   .borders = spec->value[VOR_PARAM_BOUNDARY] == VOR_BOUNDARY_SITES,
                                   .edges = spec->value[VOR_PARAM_EDGES] == VOR_EDGES_SITES};
    struct vor_sites sites = {.n = 0};
    vor_status status = vor_area_of_surface(&wanted.area, domain,
                                            (uint64_t)spec->value[VOR_PARAM_SEED], &whole, err);

    VOR_THEN(status, vor_sites_find(&sites, domain, &wanted, &whole, err));
    VOR_THEN(status,
             vor_start_seeds(seeds, domain, vor_seeds_beside_sites(n, &sites), spec, run, err));
    VOR_THEN(status, vor_seeds_add_sites(seeds, &sites, n, &whole, err));
    vor_sites_free(&sites);
    return status;
}

static vor_status start(struct vor_seeds *seeds, const struct vor_domain *domain, size_t n,
                        const struct vor_spec *spec, const struct vor_run *run,
                        struct vor_error *err)
{
    const struct vor_coarse_how how = {vor_lloyd_run, spec, run};

    return vor_coarse_start(seeds, domain, n, &how, err);
}

/* Starts seeds between the points of the input, and joins these to them. */
static vor_status start_between(struct vor_seeds *seeds, const struct vor_domain *domain, size_t n,
                                const struct vor_spec *spec, const struct vor_run *run,
                                struct vor_error *err)
{
    vor_status status = n > 0 ? vor_start_between(seeds, domain, n, spec, run, err) : VOR_OK;

    return status == VOR_OK
               ? vor_seeds_add_input(seeds, domain, vor_seeds_policy_of(spec), run, err)
               : status;
}

vor_status vor_cvt_run(struct vor_seeds *out, struct vor_outcome *told,
                       const struct vor_domain *domain, size_t n, const struct vor_spec *spec,
                       const struct vor_run *run, struct vor_error *err)
{
    int sites = spec->value[VOR_PARAM_BOUNDARY] == VOR_BOUNDARY_SITES ||
                spec->value[VOR_PARAM_EDGES] == VOR_EDGES_SITES;
    struct vor_domain thin = {.n = 0}; /* of a dense input: most of the work is done on it */
    struct vor_seeds seeds = {.n = 0};
    double before = vor_run_clock(run);
    struct vor_spec shorter;
    int inserts = spec->value[VOR_PARAM_METHOD] == VOR_METHOD_INSERT;
    vor_status status = vor_checkpoint_is(run)
                            ? vor_checkpoint_seeds(&seeds, told, domain, run, err)
                            : (inserts ? start_between
                               : sites ? start_with_sites
                                       : start)(&seeds, domain, n, spec, run, err);

    if (status == VOR_OK && !inserts)
        status = vor_domain_thin_for(&thin, domain, n, seeds.area, &seeds.run, err);
    if (status == VOR_OK && thin.n >= seeds.input_lists.wide)
        status = vor_seeds_onto(&seeds, &thin, err);
    told->seconds_start = vor_run_clock(run) - before;
    shorter = vor_coarse_shorten(spec, &seeds);
    if (status == VOR_OK && !vor_checkpoint_is_in(run, VOR_RUN_STAGE_POLISH))
        status = vor_spec_descends(spec) ? vor_descend_run(&seeds, told, &shorter, run, err)
                                         : vor_lloyd_run(&seeds, told, &shorter, run, err);
    if (status == VOR_OK && !inserts)
        status = vor_polish(&seeds, told, &shorter, run, err);
    vor_domain_free(&thin);
    if (status == VOR_OK)
        *out = seeds;
    else
        vor_seeds_free(&seeds);
    return status;
}
