#include "core/seeds/coarse.h"

#include "core/input/thin.h"
#include "core/seeds/repel.h"
#include "core/seeds/stage.h"
#include "core/seeds/start.h"
#include "core/seeds/subdivide.h"

#include <math.h>

/* One in so many coarse seeds at their first positions may have an edge in doubt. Share of those
 * that have, and what comes of it: igea to 20,000, 5,000 coarse seeds 0.09, 1,250 0.20, 310 0.33:
 * on the first two, defects 1,931 / 657; bunny to 5,000 0.30, armadillo to 10,000 0.45, a cow to
 * 2,000 0.57: eta 0.025 / 0.028, 0.020 / 0.025 and 0.049 / 0.061 (old start / this one). Twice as
 * many where the mesh is repaired: fandisk to 10,000 0.31, mean quality 0.963 / 0.970. */
enum { DOUBTFUL = 4 };

static int applies(const struct vor_domain *domain, size_t n, const struct vor_spec *spec)
{
    return n / 4 > VOR_DOMAIN_FEW && vor_spec_polish(spec) > 0 &&
           !vor_spec_given(spec, VOR_PARAM_ITERATIONS) && domain->previous.n == 0 &&
           !domain->known.sheets && spec->value[VOR_PARAM_METRIC] == VOR_METRIC_ISOTROPIC &&
           spec->value[VOR_PARAM_BOUNDARY] == VOR_BOUNDARY_KEEP &&
           spec->value[VOR_PARAM_EDGES] != VOR_EDGES_SITES;
}

/* Evens coarse seeds out, which the method spreads first unless they come from yet coarser ones.
 * They end on `thin` again, if that is not NULL: there their neighbourhoods reach a border that is
 * as near as the next seed. */
static vor_status even_out(struct vor_seeds *seeds, const struct vor_domain *thin,
                           const struct vor_coarse_how *how, int is_first, struct vor_error *err)
{
    struct vor_outcome told = {.stages = 0};
    vor_status status = is_first ? how->spread(seeds, &told, how->spec, how->run, err) : VOR_OK;

    VOR_THEN(status, vor_polish(seeds, &told, how->spec, how->run, err));
    return status == VOR_OK && thin != NULL ? vor_seeds_onto(seeds, thin, err) : status;
}

/* Adds what was counted while the coarse seeds moved. */
static void count(struct vor_seeds *seeds, const struct vor_seeds *coarse)
{
    struct vor_counts counts = vor_seeds_counts(coarse);

    seeds->scratch[0].queries = counts.queries;
    seeds->scratch[0].cells = counts.cells;
    seeds->scratch[0].bisectors = counts.bisectors;
    seeds->scratch[0].triangles = counts.triangles;
    seeds->indexed_before = coarse->indexed_before + coarse->point_lists.indexed;
}

static vor_status subdivide(struct vor_seeds *out, struct vor_seeds *coarse, size_t n,
                            struct vor_error *err)
{
    struct vor_seeds_edges edges = {.of = NULL};
    struct vor_seeds seeds = {.n = 0};
    vor_status status = vor_seeds_edges_find(&edges, coarse, err);

    VOR_THEN(status, vor_seeds_init(&seeds, coarse->whole, n, coarse->policy, &coarse->run, err));
    VOR_THEN(status, vor_seeds_subdivide(&seeds, coarse, &edges, err));
    vor_seeds_edges_free(&edges, coarse->run.memory);
    if (status != VOR_OK) {
        vor_seeds_free(&seeds);
        return status;
    }
    seeds.area = coarse->area;
    count(&seeds, coarse);
    *out = seeds;
    return VOR_OK;
}

/* Whether the coarse seeds show the surface, and its border is no longer than the side of a square
 * of the same area: along a border the finer lattice lacks half a row, and faults gather there. An
 * open sheet to 10,000 and 40,000: defects 962 / 578 and 4,112 / 1,344, but delta 0.0182 / 0.0213
 * and 0.0185 / 0.0202. */
static vor_status look(int *shows, struct vor_seeds *coarse, const struct vor_spec *spec,
                       struct vor_error *err)
{
    int repaired = spec->value[VOR_PARAM_REPAIR] == VOR_REPAIR_AUTO;
    size_t doubtful = (size_t)(repaired ? DOUBTFUL / 2 : DOUBTFUL);
    struct vor_seeds_edges edges;
    vor_status status = vor_seeds_edges_find(&edges, coarse, err);

    if (status != VOR_OK)
        return status;
    *shows = edges.doubtful * doubtful <= coarse->n && edges.open * edges.open <= coarse->n &&
             !vor_run_is_late(&coarse->run);
    vor_seeds_edges_free(&edges, coarse->run.memory);
    return VOR_OK;
}

/* As vor_coarse_start. A closed surface without handles has 3 n - 6 edges. */
static vor_status start(struct vor_seeds *out, const struct vor_domain *domain, size_t n,
                        const struct vor_coarse_how *how, struct vor_error *err)
{
    const struct vor_spec *spec = how->spec;
    struct vor_seeds coarse = {.n = 0}, finer = {.n = 0};
    struct vor_domain thin = {.n = 0};
    const struct vor_domain *onto = NULL;
    struct vor_spec less = *spec;
    const struct vor_coarse_how with_less = {how->spread, &less, how->run};
    int shows = 0;
    vor_status status;

    if (!applies(domain, n, spec))
        return VOR_OK;
    status = vor_start_seeds(&coarse, domain, (n + 9) / 4, spec, how->run, err);
    VOR_THEN(status, vor_domain_thin_for(&thin, domain, coarse.n, coarse.area, &coarse.run, err));
    if (status == VOR_OK && thin.n >= coarse.input_lists.wide) {
        onto = &thin;
        status = vor_seeds_onto(&coarse, onto, err);
    }
    VOR_THEN(status, look(&shows, &coarse, spec, err));
    less.value[VOR_PARAM_POLISH] =
        fmin(spec->value[VOR_PARAM_POLISH], vor_parameter_info(VOR_PARAM_POLISH)->fallback);
    less.value[VOR_PARAM_REPAIR] = VOR_REPAIR_NONE;
    if (vor_spec_given(spec, VOR_PARAM_SECONDS))
        less.value[VOR_PARAM_SECONDS] *= VOR_STAGE_SHARE;
    if (status == VOR_OK && shows)
        status = start(&finer, domain, coarse.n, &with_less, err);
    if (status == VOR_OK && finer.n > 0) {
        vor_seeds_free(&coarse);
        coarse = finer;
        if (onto != NULL)
            status = vor_seeds_onto(&coarse, onto, err);
    }
    if (status == VOR_OK && shows)
        status = even_out(&coarse, onto, &with_less, finer.n == 0, err);
    if (status == VOR_OK && shows)
        status = subdivide(out, &coarse, n, err);
    vor_seeds_free(&coarse);
    vor_domain_free(&thin);
    return status;
}

vor_status vor_coarse_start(struct vor_seeds *out, const struct vor_domain *domain, size_t n,
                            const struct vor_coarse_how *how, struct vor_error *err)
{
    struct vor_run silent = *how->run;
    const struct vor_coarse_how silently = {how->spread, how->spec, &silent};
    struct vor_watch watch;
    vor_status status;

    if (silent.watch != NULL) {
        watch = *silent.watch;
        watch.progress = NULL;
        watch.points = NULL;
        watch.checkpoint = NULL;
        silent.watch = &watch;
    }
    status = start(out, domain, n, &silently, err);
    if (status == VOR_OK && out->n == 0)
        status = vor_start_seeds(out, domain, n, how->spec, how->run, err);
    else if (status == VOR_OK) {
        out->coherence = VOR_SEEDS_COHERENT;
        out->run = vor_run_unstoppable(how->run);
    }
    return status;
}

struct vor_spec vor_coarse_shorten(const struct vor_spec *spec, const struct vor_seeds *seeds)
{
    double less = seeds->track != NULL ? seeds->coherence : seeds->coherence > 0 ? 0.5 : 0;
    struct vor_spec out = *spec;

    if (less > 0 && vor_spec_polish(spec) > 0) {
        out.value[VOR_PARAM_ITERATIONS] =
            seeds->track != NULL ? rint((1 - less) * vor_spec_iterations(spec)) : 1;
        out.value[VOR_PARAM_POLISH] = rint((1 - less / 2) * vor_spec_polish(spec));
    }
    return out;
}
