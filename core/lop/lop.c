#include "core/lop/lop.h"

#include "core/base/linalg.h"
#include "core/base/morton.h"
#include "core/geom/boundary.h"
#include "core/input/coarsen.h"
#include "core/input/lists.h"
#include "core/input/neighbors.h"
#include "core/input/thin.h"
#include "core/lop/bends.h"
#include "core/lop/beside.h"
#include "core/lop/even.h"
#include "core/lop/insert.h"
#include "core/lop/normals.h"
#include "core/lop/project.h"
#include "core/lop/scale.h"
#include "core/lop/strays.h"
#include "core/seeds/area.h"
#include "core/seeds/attach.h"
#include "core/seeds/checkpoint.h"
#include "core/seeds/repel.h"
#include "core/seeds/start.h"

#include <math.h>
#include <string.h>

/* Spacings of the samples that points act on each other. wlop: what CGAL's is best at; at 1.25 /
 * 1.5 / 2, bunny to 5,000 after 36 steps. */
#define REACH_WLOP 1.5
#define REACH_EAR 2.0

/* Part of the samples that sides are looked for as if there were no more, where the points are
 * means: one mean for each sample, then. Of 22,000 normals of an armadillo with noise (lop.h) 23
 * face inwards, 35 without means. By lists that walks make 62, at 0.125 / 1 37 / 24, and 1.3 / 3.5
 * CPU s more. */
#define SIDES_SHARE 0.2
#define RADIANS 0.017453292519943295
#define PI 3.141592653589793

struct lop {
    const struct vor_domain *input; /* what the result is for */
    const struct vor_domain *whole,
        *domain;              /* whole: the input, or coarse; domain: that, or thin */
    struct vor_domain coarse; /* with ear, where fits to the input show no surface */
    struct vor_domain thin;   /* where the whole is dense */
    const struct vor_spec *spec;
    const struct vor_run *run;
    struct vor_outcome *told;
    int ear;
    int means;            /* the points of the domain are means of those of the whole */
    int smooth;           /* the input has no edges */
    double area, spacing; /* of the surface; of samples spread evenly on it; normalised */
    double reach;
    size_t in_gaps;               /* the last ones of the samples, put where the input has none */
    struct vor_lop_samples data;  /* the points of the domain; owned with ear */
    struct vor_orientation sides; /* of the domain, with ear */
    struct vor_lop_samples samples;
};

/* The parameter sigmaP, as a reach in normalised units; 0 where it is auto. */
static double sigma_p(const struct lop *lop)
{
    double given = lop->spec->value[VOR_PARAM_SIGMA_P], diagonal2 = 0;

    if (given == VOR_WORD(VOR_SIGMA_P_AUTO))
        return 0;
    if (given != VOR_WORD(VOR_SIGMA_P_PAPER))
        return given / lop->domain->unit;
    for (size_t c = 0; c < 3; c++) {
        float low = INFINITY, high = -INFINITY;

        for (size_t i = 0; i < lop->whole->n; i++) {
            low = fminf(low, lop->whole->xyz[3 * i + c]);
            high = fmaxf(high, lop->whole->xyz[3 * i + c]);
        }
        diagonal2 += ((double)high - (double)low) * ((double)high - (double)low);
    }
    return sqrt(diagonal2 / (double)lop->whole->n);
}

/* How far points act on each other where the request does not say: by ear no less than the radius
 * of the fits that the input's noise asks for. At 0 / 1 / 1.5 of that, to 120,000 at rho 0,
 * fandisk30k_noise2: rms near edges 7.6e-4 / 7.2e-4 / 6.9e-4, from the true edge to the nearest
 * point 1.56e-3 / 1.63e-3 / 1.81e-3. */
static double reach_of(const struct lop *lop)
{
    double fitted = lop->domain->known.neighbors.usual, points = (double)lop->domain->n;

    if (!lop->ear)
        return REACH_WLOP * lop->spacing;
    return fmax(REACH_EAR * lop->spacing, sqrt(fitted * lop->area / (PI * points)));
}

/* Whether the samples are the input's own points, and stay where they are. */
static int only_inserts(const struct lop *lop)
{
    return lop->ear && lop->spec->value[VOR_PARAM_PHASES] == VOR_PHASES_INSERT;
}

/* Makes seeds of n first places: of the input's own points where these are the samples that others
 * are inserted between, else evenly by area. */
static vor_status first_places(struct vor_seeds *out, const struct lop *lop, size_t n,
                               const struct vor_run *run, struct vor_error *err)
{
    uint64_t seed = (uint64_t)lop->spec->value[VOR_PARAM_SEED];
    double area = 0;
    vor_status status;

    if (!only_inserts(lop) || n > lop->whole->n)
        return vor_start_seeds(out, lop->whole, n, lop->spec, run, err);
    status = vor_area_of_surface(&area, lop->whole, seed, run, err);
    VOR_THEN(status, vor_seeds_init(out, lop->whole, n, vor_seeds_policy_of(lop->spec), run, err));
    if (status != VOR_OK)
        return status;
    vor_area_draw(out, seed);
    out->area = area;
    return VOR_OK;
}

/* Takes some of the points of a dense input for n samples; of a noisy one means, with ear, which
 * keeps edges as far as the noise shows them. */
static vor_status take_few(struct lop *lop, size_t n, const struct vor_run *run,
                           struct vor_error *err)
{
    vor_status status = vor_domain_thin_for(&lop->thin, lop->whole, n, lop->area, run, err);

    if (status == VOR_OK && lop->thin.n == 0 && lop->ear && !only_inserts(lop)) {
        status = vor_domain_means_for(&lop->thin, lop->whole, n, lop->area, run, err);
        lop->means = lop->thin.n > 0;
    }
    if (status == VOR_OK && lop->thin.n > 0)
        lop->domain = &lop->thin;
    return status;
}

/* Starts n samples, without normals, and sets the lengths for as many. */
static vor_status start(struct lop *lop, size_t n, struct vor_error *err)
{
    const struct vor_run whole = vor_run_unstoppable(lop->run);
    struct vor_seeds seeds = {.n = 0};
    vor_status status = vor_lop_samples_init(&lop->samples, n, lop->run->memory, err);

    VOR_THEN(status, first_places(&seeds, lop, n, &whole, err));
    if (status != VOR_OK)
        return status;
    lop->samples.n = n;
    memcpy(lop->samples.xyz, seeds.xyz, 3 * n * sizeof *seeds.xyz);
    memset(lop->samples.normal, 0, 3 * n * sizeof *lop->samples.normal);
    lop->area = seeds.area;
    vor_seeds_free(&seeds);
    status = take_few(lop, n, &whole, err);
    lop->spacing = sqrt(lop->area / (VOR_HEXAGON_HEIGHT * (double)n));
    lop->reach = sigma_p(lop);
    if (!(lop->reach > 0))
        lop->reach = reach_of(lop);
    return status;
}

/* Says if points do not see each other. */
static void warn_of_reach(const struct lop *lop)
{
    if (lop->reach < lop->spacing)
        vor_warn(lop->told->warnings, &lop->told->warnings_count, VOR_WARNING_SIGMA_P,
                 lop->reach * lop->domain->unit, lop->spacing * lop->domain->unit);
}

/* What points of the result lie beside. */
static struct vor_lop_beside beside_of(const struct lop *lop)
{
    return (struct vor_lop_beside){&lop->data, lop->domain,
                                   lop->spec->value[VOR_PARAM_SIGMA_N] * RADIANS};
}

/* Gives the samples the normals of the data next to them and puts them onto the planes of these, no
 * farther from them than from their neighbours. Points of the input that are kept stay. */
static void face_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct lop *lop = ctx;
    const struct vor_lop_beside beside = beside_of(lop);
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++) {
        float *x = &lop->samples.xyz[3 * i], at[3];
        size_t datum;

        memcpy(at, x, sizeof at);
        datum = vor_lop_beside_face(at, &beside, &last);
        if (!only_inserts(lop))
            memcpy(x, at, sizeof at);
        memcpy(&lop->samples.normal[3 * i], &lop->data.normal[3 * datum], 3 * sizeof(float));
    }
}

static vor_status project(struct lop *lop, uint32_t ahead, struct vor_error *err)
{
    const double *value = lop->spec->value;
    struct vor_lop_project_how how = {.mu = value[VOR_PARAM_MU],
                                      .sigma_n = value[VOR_PARAM_SIGMA_N] * RADIANS,
                                      .spacing = lop->spacing,
                                      .reach = lop->reach,
                                      .normals = lop->ear,
                                      .rounds =
                                          only_inserts(lop) ? 0 : (uint32_t)value[VOR_PARAM_ROUNDS],
                                      .steps = vor_spec_steps(lop->spec),
                                      .ahead = ahead,
                                      .spec = lop->spec};

    return vor_lop_project(&lop->samples, &lop->data, lop->domain, &how, lop->told, lop->run, err);
}

/* Whether a sample is so far from the input that only gaps=fill puts it there, farther from the
 * nearest point than points are apart around that one, and goes on beside the nearest datum. Over
 * it, samples hang between strays and the surface. */
static int is_in_gap(const struct lop *lop, const float x[3])
{
    double most = VOR_LOP_PARTNERS * lop->spacing / 2;
    unsigned k = lop->input->n > VOR_PATCH_HEXAGON ? VOR_PATCH_HEXAGON + 1 : 1;
    uint32_t index[VOR_PATCH_HEXAGON + 1];
    float gap2, distance2[VOR_PATCH_HEXAGON + 1] = {0};
    double over = 0;

    vor_knn_search(lop->input->knn, x, 1, 1, index, &gap2);
    if (!((double)gap2 > most * most))
        return 0;
    vor_knn_search(lop->input->knn, &lop->input->xyz[3 * (size_t)index[0]], 1, k, index, distance2);
    if (!(gap2 > distance2[k - 1]))
        return 0;
    vor_knn_search(lop->domain->knn, x, 1, 1, index, &gap2);
    for (size_t c = 0; c < 3; c++)
        over += (double)lop->data.normal[3 * (size_t)index[0] + c] *
                ((double)x[c] - (double)lop->domain->xyz[3 * (size_t)index[0] + c]);
    return over * over < VOR_SAME_WAY * VOR_SAME_WAY * (double)gap2;
}

/* Moves the samples in gaps to the end of an order. */
static vor_status gaps_last(uint32_t *order, struct lop *lop, struct vor_error *err)
{
    uint32_t *in_gaps = vor_malloc(lop->run->memory, lop->samples.n, sizeof *in_gaps);
    size_t near = 0;

    if (in_gaps == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", lop->samples.n);
    for (size_t i = 0; i < lop->samples.n; i++)
        if (is_in_gap(lop, &lop->samples.xyz[3 * (size_t)order[i]]))
            in_gaps[lop->in_gaps++] = order[i];
        else
            order[near++] = order[i];
    memcpy(&order[near], in_gaps, lop->in_gaps * sizeof *order);
    vor_free(lop->run->memory, in_gaps);
    return VOR_OK;
}

/* Puts the samples in an order in which near ones follow each other, as searches among the input
 * want it: those that were inserted came in that of their priorities. */
static vor_status sort_samples(struct lop *lop, struct vor_error *err)
{
    struct vor_memory *memory = lop->run->memory;
    const struct vor_run whole = vor_run_unstoppable(lop->run);
    struct vor_lop_samples sorted = {0}, *samples = &lop->samples;
    uint32_t *order = vor_malloc(memory, samples->n, sizeof *order);
    vor_status status;

    if (order == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", samples->n);
    status = vor_morton_order(order, samples->xyz, samples->n, &whole, err);
    if (status == VOR_OK && lop->spec->value[VOR_PARAM_GAPS] == VOR_GAPS_FILL)
        status = gaps_last(order, lop, err);
    VOR_THEN(status, vor_lop_samples_init(&sorted, samples->n, memory, err));
    if (status == VOR_OK) {
        for (size_t i = 0; i < samples->n; i++) {
            memcpy(&sorted.xyz[3 * i], &samples->xyz[3 * (size_t)order[i]], 3 * sizeof(float));
            memcpy(&sorted.normal[3 * i], &samples->normal[3 * (size_t)order[i]],
                   3 * sizeof(float));
        }
        sorted.n = samples->n;
        vor_lop_samples_free(samples);
        *samples = sorted;
    }
    vor_free(memory, order);
    return status;
}

/* Makes seeds of the samples. With edges hardly one of them moves from there. */
static vor_status hand_over(struct vor_seeds *out, struct lop *lop, struct vor_error *err)
{
    struct vor_memory *memory = lop->run->memory;
    size_t n = lop->samples.n;
    struct vor_seeds_policy policy = vor_seeds_policy_of(lop->spec);
    struct vor_seeds seeds;
    vor_status status;

    if (vor_checkpoint_is(lop->run))
        return vor_checkpoint_seeds(out, lop->told, lop->input, lop->run, err);
    policy.still = lop->ear && !lop->smooth;
    if (policy.near_input != VOR_NEAR_NEVER) /* samples were projected onto the input */
        policy.near_input = lop->ear && lop->smooth ? VOR_NEAR_IN_STEPS : VOR_NEAR_NEVER;
    status = vor_seeds_init(&seeds, lop->input, n, policy, lop->run, err);
    if (status != VOR_OK)
        return status;
    seeds.area = lop->area;
    seeds.fixed = lop->in_gaps; /* else they would be taken back to the rims */
    memcpy(seeds.xyz, lop->samples.xyz, 3 * n * sizeof *seeds.xyz);
    if (lop->ear) {
        seeds.normal = vor_malloc(memory, n, 3 * sizeof *seeds.normal);
        if (seeds.normal == NULL) {
            vor_seeds_free(&seeds);
            return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
        }
        memcpy(seeds.normal, lop->samples.normal, 3 * n * sizeof *seeds.normal);
    }
    *out = seeds;
    return VOR_OK;
}

vor_status vor_wlop_run(struct vor_seeds *out, struct vor_outcome *told,
                        const struct vor_domain *domain, size_t n, const struct vor_spec *spec,
                        const struct vor_run *run, struct vor_error *err)
{
    struct lop lop = {
        .input = domain, .whole = domain, .domain = domain, .spec = spec, .run = run, .told = told};
    struct vor_seeds seeds = {.n = 0};
    double before = vor_run_clock(run);
    vor_status status = start(&lop, n, err);

    if (status == VOR_OK) {
        warn_of_reach(&lop);
        lop.data = (struct vor_lop_samples){.n = lop.domain->n, .xyz = lop.domain->xyz};
        told->seconds_start = vor_run_clock(run) - before;
    }
    if (status == VOR_OK && !vor_checkpoint_is(run)) {
        status = project(&lop, vor_spec_polish(spec), err);
    }
    VOR_THEN(status, hand_over(&seeds, &lop, err));
    VOR_THEN(status, vor_polish(&seeds, told, spec, run, err));
    vor_lop_samples_free(&lop.samples);
    vor_domain_free(&lop.thin);
    if (status == VOR_OK)
        *out = seeds;
    else
        vor_seeds_free(&seeds);
    return status;
}

/* The input with its normals. */
static vor_status find_normals(struct lop *lop, size_t samples, struct vor_error *err)
{
    const struct vor_run whole = vor_run_unstoppable(lop->run);
    const double *value = lop->spec->value;
    struct vor_lop_normals_how how = {
        .sigma_n = value[VOR_PARAM_SIGMA_N] * RADIANS,
        .points = lop->means ? (size_t)ceil(SIDES_SHARE * (double)samples) : samples,
        .area = lop->area,
        .plain = lop->means,
        .edges = !lop->smooth,
        .rounds = only_inserts(lop) ? 0 : (uint32_t)value[VOR_PARAM_ROUNDS],
        .orientation = &lop->sides};
    vor_status status = vor_lop_normals(&lop->data, lop->domain, &how, &whole, err);

    lop->told->oriented = 1;
    lop->told->one_sided = lop->sides.one_sided;
    return status;
}

/* Seeds that take normals from surfaces fitted around them. */
struct fitting {
    const struct lop *lop;
    struct vor_seeds *seeds;
};

static void normal_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct fitting *fitting = ctx;
    struct vor_seeds *seeds = fitting->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end && !vor_run_is_late(&seeds->run); i++) {
        double x[3], local[3], fitted[3], toward[3], side;

        if (vor_seeds_fit(seeds, scratch, i) == VOR_SURFACE_NONE)
            continue;
        vor_seeds_position(seeds, i, x);
        vor_surface_to_local(&scratch->here.surface, x, local);
        vor_surface_normal(&scratch->here.surface, local, fitted);
        side = vor_orientation_side(&fitting->lop->sides, fitting->lop->domain, &seeds->xyz[3 * i],
                                    fitted, toward, &last);
        for (size_t c = 0; c < 3; c++)
            seeds->normal[3 * i + c] = (float)(side < 0 ? -fitted[c] : fitted[c]);
    }
}

/* Evens the seeds of an input without edges out, and takes the normals of where they then are. */
static vor_status even_out_smooth(struct vor_seeds *seeds, struct lop *lop, struct vor_error *err)
{
    struct fitting fitting = {lop, seeds};
    vor_status status = vor_polish(seeds, lop->told, lop->spec, lop->run, err);

    if (status != VOR_OK || lop->told->stopped == VOR_STOPPED_CALLER)
        return status;
    return vor_run_for(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, normal_block, &fitting, err);
}

/* Points to project, of the n in the end. */
static size_t samples_of(const struct lop *lop, size_t n)
{
    const double *value = lop->spec->value;
    double samples = value[VOR_PARAM_SAMPLES], points = (double)lop->domain->n;

    if (value[VOR_PARAM_PHASES] == VOR_PHASES_RESAMPLE)
        return n;
    if (samples == VOR_UNSET && value[VOR_PARAM_PHASES] == VOR_PHASES_INSERT)
        samples = points;
    else if (samples == VOR_UNSET)
        samples = ceil(points / 2);
    else if (value[VOR_PARAM_PHASES] == VOR_PHASES_INSERT)
        samples = fmin(samples, points);
    return samples < (double)n ? (size_t)fmax(samples, fmin(VOR_LOP_FEWEST, (double)n)) : n;
}

/* Keeps the points of an input with edges to it; fits to a coarse one say nothing. */
static vor_status keep_to_input(struct vor_seeds *seeds, struct lop *lop, struct vor_error *err)
{
    double before = vor_run_clock(lop->run);
    vor_status status = lop->whole == &lop->coarse ? VOR_OK : vor_attach_fast(seeds, err);

    lop->told->seconds[VOR_RUN_STAGE_POLISH] += vor_run_clock(lop->run) - before;
    return status;
}

/* Steps of the polish; between edges there are fewer. */
static uint32_t polish_of(const struct lop *lop)
{
    uint32_t polish = vor_spec_polish(lop->spec);

    return lop->smooth || polish < VOR_LOP_EVEN_MOST ? polish : VOR_LOP_EVEN_MOST;
}

/* Inserts points until there are n, and evens them out. */
static vor_status insert(struct lop *lop, size_t n, struct vor_error *err)
{
    const double *value = lop->spec->value;
    uint32_t polish = polish_of(lop);
    struct vor_lop_insert_how how = {.rho = lop->smooth && polish > 0 ? 0 : value[VOR_PARAM_RHO],
                                     .sigma_n = value[VOR_PARAM_SIGMA_N] * RADIANS,
                                     .spacing = only_inserts(lop) ? 0 : lop->spacing,
                                     .sigma_p = lop->reach,
                                     .fill = value[VOR_PARAM_GAPS] == VOR_GAPS_FILL,
                                     .polish = lop->smooth ? 0 : polish,
                                     .spec = lop->spec,
                                     .beside = beside_of(lop)};

    if (n < VOR_LOP_FEWEST || (n == lop->samples.n && how.polish == 0))
        return VOR_OK;
    return vor_lop_insert(&lop->samples, n, &how, lop->domain, lop->told, lop->run, err);
}

/* Starts samples for n points and looks for edges; where noise hides them, starts again with fewer
 * of the input's points. */
static vor_status start_with_edges(struct lop *lop, size_t n, struct vor_edges *edges,
                                   struct vor_error *err)
{
    const struct vor_run whole = vor_run_unstoppable(lop->run);
    vor_status status = start(lop, samples_of(lop, n), err);

    if (status != VOR_OK || lop->whole == &lop->coarse)
        return status;
    status = vor_lop_has_edges(&lop->smooth, edges, lop->domain, lop->area, &whole, err);
    if (status == VOR_OK && lop->smooth && !only_inserts(lop))
        status = vor_lop_find_scale(&lop->coarse, lop->input, lop->area, &whole, err);
    if (status != VOR_OK || lop->coarse.n == 0)
        return status;
    vor_lop_samples_free(&lop->samples);
    vor_domain_free(&lop->thin);
    lop->means = 0;
    lop->whole = lop->domain = &lop->coarse;
    status = start(lop, samples_of(lop, n), err);
    if (status != VOR_OK)
        return status;
    return vor_lop_has_edges(&lop->smooth, edges, lop->domain, lop->area, &whole, err);
}

/* Projects samples, and inserts points until there are n. */
static vor_status make_points(struct lop *lop, size_t n, struct vor_error *err)
{
    double before = vor_run_clock(lop->run);
    const struct vor_run whole = vor_run_unstoppable(lop->run);
    struct vor_edges edges = {.n = 0};
    struct vor_lop_bends_how how;
    size_t samples, on_edges = 0;
    vor_status status = start_with_edges(lop, n, &edges, err);

    samples = lop->samples.n;
    if (status == VOR_OK)
        warn_of_reach(lop);
    VOR_THEN(status, find_normals(lop, samples, err));
    if (status == VOR_OK && edges.n > 0) {
        how.flag = edges.flag;
        how.put = lop->whole == lop->input; /* noise as wide makes fits as good as the sides */
        status = vor_lop_bends(&on_edges, &lop->data, lop->domain, &how, &whole, err);
        lop->smooth = vor_lop_is_smooth(on_edges, edges.n);
    }
    vor_edges_free(&edges);
    VOR_THEN(status, vor_run_for(&whole, samples, VOR_SEEDS_BLOCK, face_block, lop, err));
    if (status != VOR_OK)
        return status;
    lop->told->seconds_start = vor_run_clock(lop->run) - before;
    if (vor_checkpoint_is(lop->run)) /* of seeds that were made of such points */
        return VOR_OK;
    status = project(lop, (uint32_t)(n - samples) + polish_of(lop), err);
    if (status == VOR_OK && lop->whole == &lop->coarse)
        status = vor_lop_strays_drop(&lop->samples, err);
    VOR_THEN(status, insert(lop, n, err));
    return status == VOR_OK && n > samples ? sort_samples(lop, err) : status;
}

vor_status vor_ear_run(struct vor_seeds *out, struct vor_outcome *told,
                       const struct vor_domain *domain, size_t n, const struct vor_spec *spec,
                       const struct vor_run *run, struct vor_error *err)
{
    struct lop lop = {.input = domain, .spec = spec, .run = run, .told = told, .ear = 1};
    const struct vor_run whole = vor_run_unstoppable(run);
    struct vor_seeds seeds = {.n = 0};
    vor_status status = VOR_OK;

    if (!only_inserts(&lop)) /* fewer points of an input whose noise is as wide as the fits */
        status = vor_domain_coarsen(&lop.coarse, domain, &whole, err);
    lop.whole = lop.domain = lop.coarse.n > 0 ? &lop.coarse : domain;
    VOR_THEN(status, make_points(&lop, n, err));
    VOR_THEN(status, hand_over(&seeds, &lop, err));
    if (status == VOR_OK)
        status = lop.smooth ? even_out_smooth(&seeds, &lop, err) : keep_to_input(&seeds, &lop, err);
    if (status == VOR_OK)
        vor_attach_to_box(&seeds);
    vor_lop_samples_free(&lop.samples);
    vor_lop_samples_free(&lop.data);
    vor_orientation_free(&lop.sides, run->memory);
    vor_domain_free(&lop.thin);
    vor_domain_free(&lop.coarse);
    if (status == VOR_OK)
        *out = seeds;
    else
        vor_seeds_free(&seeds);
    return status;
}
