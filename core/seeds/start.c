#include "core/seeds/start.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "core/base/stat.h"
#include "core/base/vector.h"
#include "core/geom/integrate.h"
#include "core/seeds/area.h"
#include "core/seeds/hurried.h"
#include "core/seeds/warm_start.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* Coefficient of variation of the areas of cells, from which on they are taken again. Measured: 0.3
 * to 1.5 on most inputs, 3 to 10 where patches cut cells off. At 1 / 2 / 4 only kitti changes: area
 * 1525 / 1458 / 1471 m2. */
#define UNEVEN 2.0
/* Most times that cells are sampled. At 1 / 3 / 6: delta of kitti to 3,000, default request, 0.41 /
 * 0.24 / 0.24. */
enum { PASSES = 3 };

/* Cells in a row of the order that say what is wide there. */
enum { NEAR_BLOCK = 16 };

/* Streams of random numbers; that of vor_area_draw is 1. */
enum { STREAM_STRETCH = 1, STREAM_ROUND = 2, STREAM_SAMPLE = 3 };

/* Input points a seed from which on they show areas by themselves (start.h has the figures): a
 * stretch of fewer is too short for the density to vary within it. */
enum { PLENTY = 10 };
/* Neighbours, the point itself included, whose disc is the area of 32 points. At 17 / 33 / 65:
 * delta of a cow of 50,000 points, uneven, to 2,000, after 20 iterations 0.072 / 0.071 / 0.068,
 * largest gap 0.88 / 0.89 / 0.97 spacings. */
enum { DENSITY_K = 33, DENSITY_BLOCK = 64 };

/* Figures are delta of igea, 12,000 points of white noise to 36,000, after one iteration (spread
 * 0.5 %). */
enum {
    /* Samples of one cell that are spread together. */
    TOGETHER = 64,
    /* Random points for each. At 8 / 16 / 32: 0.121 / 0.111 / 0.106; time grows with them. */
    RANDOM = 16,
    /* The same for a sample alone in its cell. At 1 / 3 / 6: delta of igea to 3,000 after 20
     * iterations 0.0493 / 0.0482 / 0.0496; of kitti 0.244 / 0.244 / 0.232, within the spread. */
    ALONE = 3,
    /* Times that samples move to the mean of their points. At 2 / 5 / 10: 0.113 / 0.111 / 0.111. */
    ROUNDS = 5
};

/* The samples of a cell and the random points that they are chosen from, in (u, v, w). */
struct spread {
    size_t n, each; /* samples; random points for each of them */
    size_t kept;    /* places before those of the samples that are taken and stay: 0 or 1 */
    double at[1 + TOGETHER][3];
    double pool[TOGETHER * RANDOM][3];
    double x[TOGETHER * RANDOM], y[TOGETHER * RANDOM]; /* of the pool */
    int64_t nearest[TOGETHER * RANDOM];                /* place nearest to each point */
};

/* The running sum of the areas of one set of seeds, from which another set is sampled. */
struct areas {
    struct vor_seeds *from, *to;
    double *end;   /* end[i]: sum of the areas of cells 0 .. i, or of their shares of the seeds */
    double offset; /* of the first sample in the running sum, 0 .. 1 samples */
    uint64_t seed;
    size_t kept; /* 1: the points of the cells stay, and the samples join them; else 0 */
};

/* Number of the first sample beyond this value of the running sum. */
static size_t samples_until(const struct areas *areas, double end)
{
    double total = areas->end[areas->from->n - 1];
    double t = end / total * (double)areas->to->n + areas->offset;

    return end >= total || t >= (double)areas->to->n ? areas->to->n : (size_t)t;
}

/* Squared distance along the surface. */
static double apart2(const double a[3], const double b[3])
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

/* Lessens squared distances of `count` points of the pool, the first of which is `first`, to those
 * along the surface from place i, and notes it for those that it is nearest to. */
VOR_INLINE void approach(struct spread *spread, double *least2, size_t first, size_t count,
                         size_t i)
{
    const double *x = &spread->x[first], *y = &spread->y[first];
    int64_t *nearest = &spread->nearest[first];
    double u = spread->at[i][0], v = spread->at[i][1];

    for (size_t j = 0; j < count; j++) {
        double d2 = (x[j] - u) * (x[j] - u) + (y[j] - v) * (y[j] - v);

        nearest[j] = d2 < least2[j] ? (int64_t)i : nearest[j];
        least2[j] = d2 < least2[j] ? d2 : least2[j];
    }
}

/* Puts each sample at that of its own random points that is farthest from the samples before it. */
VOR_CLONES static void start_apart(struct spread *spread)
{
    for (size_t i = 0; i < spread->n; i++) {
        size_t first = i * spread->each, farthest = 0;
        double least2[RANDOM];

        for (size_t j = 0; j < spread->each; j++)
            least2[j] = INFINITY;
        for (size_t before = 0; before < spread->kept + i; before++)
            approach(spread, least2, first, spread->each, before);
        for (size_t j = 1; j < spread->each; j++)
            farthest = least2[j] > least2[farthest] ? j : farthest;
        memcpy(spread->at[spread->kept + i], spread->pool[first + farthest], sizeof spread->at[i]);
    }
}

/* Moves each sample to the mean of the random points nearest to it. Returns whether these are
 * others than in the round before. */
VOR_CLONES static int relax(struct spread *spread)
{
    double sum[1 + TOGETHER][3], count[1 + TOGETHER], least2[TOGETHER * RANDOM];
    int64_t before[TOGETHER * RANDOM];
    size_t drawn = spread->n * spread->each, places = spread->kept + spread->n;
    int others = 0;

    memset(sum, 0, places * sizeof *sum);
    memset(count, 0, places * sizeof *count);
    memcpy(before, spread->nearest, drawn * sizeof *before);
    for (size_t j = 0; j < drawn; j++) {
        least2[j] = INFINITY;
        spread->nearest[j] = 0;
    }
    for (size_t i = 0; i < places; i++)
        approach(spread, least2, 0, drawn, i);
    for (size_t j = 0; j < drawn; j++) {
        size_t i = (size_t)spread->nearest[j];

        others |= spread->nearest[j] != before[j];
        count[i]++;
        for (int c = 0; c < 3; c++)
            sum[i][c] += spread->pool[j][c];
    }
    for (size_t i = spread->kept; others && i < places; i++)
        for (int c = 0; c < 3 && count[i] > 0; c++)
            spread->at[i][c] = sum[i][c] / count[i];
    return others;
}

/* Moves a place on the surface of a fit to where the points of the fit have it: as far above the
 * surface as they are, in the mean by the inverse fourth power of their distances (Shepard 1968, "A
 * two-dimensional interpolation function for irregularly-spaced data"). D2 of nine clouds, a
 * quarter of their points in 10 bits to all of them, is higher by 0.3 to 1 dB so. */
static void put_among_points(const struct vor_place *here, double local[3])
{
    double above[VOR_NEIGHBORS_MAX], far2[VOR_NEIGHBORS_MAX];
    double least = INFINITY, sum = 0, weights = 0;

    for (unsigned j = 0; j < here->k; j++) {
        double x[3], at[3], gradient[2];

        vor_to_doubles(x, &here->near[3 * j]);
        vor_surface_to_local(&here->surface, x, at);
        above[j] = at[2] - vor_surface_height(&here->surface, at[0], at[1], gradient);
        far2[j] = apart2(at, local);
        least = fmin(least, far2[j]);
    }
    for (unsigned j = 0; j < here->k; j++) {
        double share = far2[j] > least ? least / far2[j] : 1;

        sum += share * share * above[j];
        weights += share * share;
    }
    local[2] += sum / weights;
}

/* Sets the position of a sample, on the surface and inside the input. */
static void place_sample(const struct areas *areas, struct vor_scratch *scratch, size_t sample,
                         double local[3])
{
    const struct vor_seeds *from = areas->from;
    float *at = &areas->to->xyz[3 * sample];
    struct vor_border border;
    double x[3];

    vor_surface_project(&scratch->here.surface, local);
    if (areas->kept)
        put_among_points(&scratch->here, local);
    vor_surface_to_world(&scratch->here.surface, local, x);
    vor_to_floats(at, x);
    if (!from->policy.keep_border ||
        vor_boundary_within(scratch->here.near, scratch->here.k, x, scratch->here.surface.spacing))
        return;
    if (vor_run_is_late(&from->run)) {
        (void)vor_hurried_hold(at, from->domain, VOR_OUTSIDE_MOVING * from->domain->sparse);
        return;
    }
    /* The patch may extend beyond the input: x is put onto the surface around it, at most
     * VOR_OUTSIDE_MOVING spacings from the input. */
    if (vor_seeds_fit_at(from, scratch, &scratch->there, x) == VOR_SURFACE_NONE)
        return;
    vor_surface_put(&scratch->there.surface, x);
    vor_seeds_border(from, scratch, &scratch->there, &border, x);
    (void)vor_boundary_restrict(&border, VOR_OUTSIDE_MOVING, x);
    vor_to_floats(at, x);
}

/* Starts n seeds in scratch->cell: each is one of several random points of it, few for a sample
 * alone. */
static void sample_cell(const struct areas *areas, struct vor_scratch *scratch, size_t first,
                        size_t n)
{
    struct vor_moments moments;
    double area = vor_cell_moments(&moments, &scratch->cell) ? moments.area : 0;
    double unit[TOGETHER * RANDOM][3];
    struct spread spread;
    size_t drawn;

    spread.n = n;
    spread.kept = areas->kept;
    spread.each = spread.kept + n > 1 ? RANDOM : ALONE;
    drawn = n * spread.each;
    memcpy(spread.at[0], scratch->cell.seed, sizeof spread.at[0]);
    assert(drawn > 0 && n <= TOGETHER);
    for (size_t j = 0; j < drawn; j++)
        for (size_t c = 0; c < 3; c++)
            unit[j][c] = vor_rng_unit(areas->seed, STREAM_SAMPLE, 3 * (first * RANDOM + j) + c);
    vor_cell_sample(&scratch->cell, area, drawn, unit, spread.pool);
    for (size_t j = 0; j < drawn; j++) {
        spread.x[j] = spread.pool[j][0];
        spread.y[j] = spread.pool[j][1];
        spread.nearest[j] = -1;
    }
    start_apart(&spread);
    for (int round = 0; round < ROUNDS && relax(&spread); round++)
        ;
    for (size_t i = 0; i < n; i++)
        place_sample(areas, scratch, first + i, spread.at[spread.kept + i]);
}

static void sample_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct areas *areas = ctx;
    struct vor_scratch *scratch = &areas->from->scratch[worker];

    for (size_t i = begin; i < end; i++) {
        size_t first = i > 0 ? samples_until(areas, areas->end[i - 1]) : 0;
        size_t last = samples_until(areas, areas->end[i]);

        if (first == last)
            continue;
        if (vor_run_is_late(&areas->from->run)) {
            for (size_t sample = first; sample < last; sample++) {
                double unit[2];

                for (size_t c = 0; c < 2; c++)
                    unit[c] = vor_rng_unit(areas->seed, STREAM_SAMPLE, 3 * sample * RANDOM + c);
                vor_hurried_draw(&areas->to->xyz[3 * sample], areas->from->domain,
                                 &areas->from->xyz[3 * i], unit);
            }
            continue;
        }
        if (vor_seeds_cell(areas->from, scratch, i) == VOR_SURFACE_NONE)
            continue;
        for (size_t sample = first; sample < last; sample += TOGETHER)
            sample_cell(areas, scratch, sample,
                        last - sample < TOGETHER ? last - sample : TOGETHER);
    }
}

/* First point of the i-th of n equal stretches of the domain's order. */
static size_t stretch(const struct vor_seeds *seeds, size_t i)
{
    return (size_t)((uint64_t)i * seeds->domain->n / seeds->n);
}

/* Where stretch i is sampled. */
static size_t sample_of(const struct areas *areas, size_t i)
{
    size_t low = stretch(areas->to, i), points = stretch(areas->to, i + 1) - low;

    return low + (size_t)(vor_rng_unit(areas->seed, STREAM_STRETCH, i) * (double)points);
}

/* Estimates the area of a stretch: one of its points is drawn, and each point counts as much as one
 * of the DENSITY_K - 1 neighbours in the disc around that one. */
static void density_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct areas *areas = ctx;
    const struct vor_seeds *to = areas->to;
    uint32_t index[DENSITY_BLOCK * DENSITY_K];
    float distance2[DENSITY_BLOCK * DENSITY_K], x[3 * DENSITY_BLOCK] = {0};

    for (size_t i = begin; i < end; i++) {
        memcpy(&x[3 * (i - begin)], &to->domain->xyz[3 * sample_of(areas, i)], 3 * sizeof *x);
    }
    vor_knn_search(to->domain->knn, x, end - begin, DENSITY_K, index, distance2);
    for (size_t i = begin; i < end; i++) {
        double points = (double)(stretch(to, i + 1) - stretch(to, i));
        double far2 = (double)distance2[(i - begin) * DENSITY_K + DENSITY_K - 1];

        areas->end[i] = M_PI * far2 * points / (DENSITY_K - 1);
    }
}

/* Turns the areas of stretches into their shares of the seeds: with a density rho, these go with
 * area times sqrt(rho). */
static void weigh_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct areas *areas = ctx;
    const struct vor_domain *domain = areas->to->domain;
    struct vor_field_near near;

    for (size_t i = begin; i < end; i++) {
        vor_field_find(&near, &domain->field, &domain->xyz[3 * sample_of(areas, i)]);
        areas->end[i] /= (double)near.value * (double)near.value;
    }
}

/* Takes one point from each of n equal parts of the running sum, all different. Returns false when
 * a stretch has fewer points than its area asks for. */
static int pick(const struct areas *areas)
{
    struct vor_seeds *to = areas->to;
    const struct vor_domain *domain = to->domain;
    double share = areas->end[to->n - 1] / (double)to->n, low = 0;
    size_t sample = 0, next = 0;

    for (size_t i = 0; i < to->n; i++) {
        size_t begin = stretch(to, i), points = stretch(to, i + 1) - begin;
        double area = areas->end[i] - low;

        if (area > share * (double)points)
            return 0;
        while (sample < to->n) {
            double t = share * ((double)sample + vor_rng_unit(areas->seed, STREAM_SAMPLE, sample));
            size_t at;

            if (t >= areas->end[i] && i + 1 < to->n)
                break;
            at = begin + (size_t)fmin((t - low) / area * (double)points, (double)points - 1);
            if (at < next)
                at = next;
            if (at > domain->n - (to->n - sample))
                at = domain->n - (to->n - sample);
            next = at + 1;
            memcpy(&to->xyz[3 * sample++], &domain->xyz[3 * at], 3 * sizeof *to->xyz);
        }
        low = areas->end[i];
    }
    return 1;
}

/* Starts the seeds at input points, as many in each stretch as its area asks for.
 *
 * @param[out] enough  false: a stretch has fewer points than that, and the positions are unset */
static vor_status start_at_points(struct areas *areas, int *enough, struct vor_error *err)
{
    struct vor_seeds *to = areas->to;
    const struct vor_run *run = &to->run;
    vor_status status;
    double sum = 0, shares = 0;

    *enough = 0;
    areas->end = vor_malloc(run->memory, to->n, sizeof *areas->end);
    if (areas->end == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", to->n);
    status = vor_run_for(run, to->n, DENSITY_BLOCK, density_block, areas, err);
    for (size_t i = 0; status == VOR_OK && i < to->n; i++)
        sum += areas->end[i];
    if (status == VOR_OK && vor_field_is(&to->domain->field))
        status = vor_run_for(run, to->n, DENSITY_BLOCK, weigh_block, areas, err);
    for (size_t i = 0; status == VOR_OK && i < to->n; i++)
        areas->end[i] = shares += areas->end[i];
    if (status == VOR_OK && sum > 0)
        *enough = pick(areas);
    to->area = sum;
    vor_free(run->memory, areas->end);
    areas->end = NULL;
    return status;
}

static double variation(const struct areas *areas)
{
    size_t n = areas->from->n;
    double mean = areas->end[n - 1] / (double)n, before = 0, sum2 = 0;

    for (size_t i = 0; i < n; i++) {
        double area = areas->end[i] - before;

        before = areas->end[i];
        sum2 += area * area;
    }
    return sqrt(fmax(0, sum2 / (double)n / (mean * mean) - 1));
}

/* Turns the areas of cells into equal shares of the seeds. Cells without area get none, nor those
 * VOR_OUTSIDE_MOVING times as far across as half of the NEAR_BLOCK that are near them in the order:
 * their seeds would hang between objects. By all cells, the sparse half of a sphere, a 25th of the
 * points, gets 313 seeds of 2,127; with 16 / 32 / 64 / 256 2,123, 2,123, 2,123, 2,043. Bytes that
 * three draws of kitti save (start.h): 36, 36, 38 / 35, 36, 36 / 37, 37, 33 / 37, 39, 33 %. */
static void share_equally(const struct areas *areas)
{
    double before = 0, cells = 0, wide2 = VOR_OUTSIDE_MOVING * VOR_OUTSIDE_MOVING;
    size_t n = areas->from->n;

    for (size_t first = 0; first < n; first += NEAR_BLOCK) {
        size_t count = n - first < NEAR_BLOCK ? n - first : NEAR_BLOCK, used = 0;
        double area[NEAR_BLOCK] = {0}, sorted[NEAR_BLOCK] = {0}, most;

        for (size_t i = 0; i < count; i++) {
            area[i] = areas->end[first + i] - before;
            before = areas->end[first + i];
            sorted[used] = area[i];
            used += area[i] > 0;
        }
        vor_sort_doubles(sorted, used);
        most = wide2 * sorted[used / 2];
        for (size_t i = 0; i < count; i++)
            areas->end[first + i] = cells += area[i] > 0 && area[i] <= most;
    }
}

/* Starts the seeds in the cells of areas->from, as many in each as its area asks for. Where the
 * areas are very uneven and both sets are as large, takes the cells of the started seeds and starts
 * again. */
static vor_status sample_cells(struct areas *areas, struct vor_error *err)
{
    struct vor_seeds *from = areas->from, *to = areas->to;
    struct vor_memory *memory = to->run.memory;
    size_t each = to->n > from->n ? to->n / from->n : 1;
    size_t block = vor_seeds_block(to->domain) / each; /* cells in which as many seeds start */
    vor_status status = VOR_OK;

    areas->end = vor_malloc(memory, from->n, sizeof *areas->end);
    if (areas->end == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", from->n);
    for (int pass = 0; status == VOR_OK && pass < PASSES; pass++) {
        if (pass > 0) {
            if (areas->kept || from->n != to->n || variation(areas) < UNEVEN)
                break;
            memcpy(from->xyz, to->xyz, 3 * to->n * sizeof *to->xyz);
        }
        status = vor_area_cells(areas->end, from, err);
        if (status != VOR_OK)
            break;
        to->area = areas->end[from->n - 1];
        if (areas->kept)
            share_equally(areas);
        if (from->wanted.value != NULL) {
            double before = 0, sum = 0; /* of the shares, as weigh_block */

            for (size_t i = 0; i < from->n; i++) {
                double wanted = vor_wanted_at(&from->wanted, i), area = areas->end[i] - before;

                before = areas->end[i];
                areas->end[i] = sum += area / (wanted * wanted);
            }
        }
        status = vor_run_for(&to->run, from->n, block > 0 ? block : 1, sample_block, areas, err);
    }
    vor_free(memory, areas->end);
    return status;
}

/* Draws input points, and starts the seeds in their cells. */
static vor_status start_in_cells(struct areas *areas, struct vor_error *err)
{
    struct vor_seeds *from = areas->from, *to = areas->to;
    const struct vor_domain *domain = to->domain;
    struct vor_seeds_policy policy = to->policy;
    vor_status status;

    policy.keep_border = 0;
    status =
        vor_seeds_init(from, domain, to->n < domain->n ? to->n : domain->n, policy, &to->run, err);
    if (status != VOR_OK)
        return status;
    from->policy = to->policy;
    from->foot = to->foot; /* lent: the domain is the same */
    vor_area_draw(from, areas->seed);
    status = sample_cells(areas, err);
    from->foot = NULL;
    vor_seeds_free(from);
    return status;
}

vor_status vor_start_seeds(struct vor_seeds *out, const struct vor_domain *domain, size_t n,
                           const struct vor_spec *spec, const struct vor_run *run,
                           struct vor_error *err)
{
    uint64_t seed = (uint64_t)spec->value[VOR_PARAM_SEED];
    struct vor_seeds from = {0}, to = {0};
    struct areas areas = {&from, &to, NULL, vor_rng_unit(seed, STREAM_ROUND, 0), seed, 0};
    int done = 0;
    vor_status status = vor_seeds_init(&to, domain, n, vor_seeds_policy_of(spec), run, err);

    if (status == VOR_OK && domain->n / PLENTY >= n && domain->n >= DENSITY_K)
        status = start_at_points(&areas, &done, err);
    if (status == VOR_OK && !done)
        status = start_in_cells(&areas, err);
    if (status == VOR_OK && domain->previous.n > 0)
        status = vor_warm_start(
            &to, vor_spec_given(spec, VOR_PARAM_COHERENCE) ? spec->value[VOR_PARAM_COHERENCE] : 1,
            err);
    if (status == VOR_OK)
        *out = to;
    else
        vor_seeds_free(&to);
    return status;
}

vor_status vor_start_between(struct vor_seeds *out, const struct vor_domain *domain, size_t n,
                             const struct vor_spec *spec, const struct vor_run *run,
                             struct vor_error *err)
{
    uint64_t seed = (uint64_t)spec->value[VOR_PARAM_SEED];
    struct vor_seeds_policy policy = vor_seeds_policy_of(spec);
    struct vor_seeds from = {0}, to = {0};
    struct areas areas = {&from, &to, NULL, vor_rng_unit(seed, STREAM_ROUND, 0), seed, 1};
    vor_status status = vor_seeds_init(&to, domain, n, policy, run, err);

    policy.widen = 0.5; /* halfway to the neighbours, where the cells of an even input end */
    VOR_THEN(status, vor_seeds_init(&from, domain, domain->n, policy, &to.run, err));
    if (status == VOR_OK) {
        memcpy(from.xyz, domain->xyz, 3 * domain->n * sizeof *from.xyz);
        status = sample_cells(&areas, err);
    }
    vor_seeds_free(&from);
    if (status == VOR_OK)
        *out = to;
    else
        vor_seeds_free(&to);
    return status;
}
