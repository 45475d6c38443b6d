#include "core/input/neighbors.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/base/vector.h"
#include "core/geom/surface.h"
#include "core/input/sheets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Figures are rms distances to the true surface in 1e-4 of its diagonal: "noise" is igea, 12,000
 * points with noise of 0.4 % of the diagonal, "half" igea with 0.5 % on one half, both to 3,000.
 * Other seeds move them by 0.1. Inputs without noise (igea, fandisk, kitti) get 20 neighbours at
 * every value. */

enum {
    PLACES = VOR_NEIGHBORS_PLACES,
    BLOCK = 16, /* places of one task */
    STEPS = VOR_LADDER_STEPS,
    FIRST = 2, /* steps that decide whether the others are tried; 1 and 3 change no figure */
    EXACT = VOR_NEIGHBORS_EXACT,
    MOST = VOR_LADDER_LAST,
    ROOM = VOR_NEIGHBORS_ROOM,
    POOL = VOR_NEIGHBORS_POOL
};

/* Residual over reach: a thicker neighbourhood shows no surface. A ball of points has 0.45. At 0.1
 * / 0.19 / 0.38: noise 16.1 / 15.5 / 16.1, half 13.9 / 13.5 / 14.5. */
#define THICK 0.19
/* Share of the places that must not be thick. At 0.93 / 0.97 / 0.99: noise 14.9 / 15.5 / 16.1, half
 * 13.4 / 13.5 / 14.0. */
#define THICK_SHARE 0.97
/* The same of a pool. At 0.9 / 0.95 / 0.99 no figure moves beyond the spread; but at 0.97,
 * so that its thickest place decides, the sides of a thin plate pass for noise. */
#define THICK_SHARE_POOL 0.95
/* If every number leaves neighbourhoods thick: times the least thickness at which more neighbours
 * help little. At 1.1 / 1.25 / 1.6 no figure moves: with this noise 45 are enough; but at 1.1 ear
 * smears 3.7 % of the normals at a wedge's edge in noise of 1.7 spacings, at 1.25 under 1 %. */
#define HELPS 1.25
/* Share of the noise's variance that stays in a quadric's height at its middle, times the points
 * that it is fitted to. From the moments of the points it is 4 on a uniform disc, 2 on a Gaussian
 * one. At 1.5 / 3 / 6: noise 15.1 / 15.5 / 15.2, half 13.5 / 13.5 / 13.8. */
#define LEVERAGE 3.0
/* Residuals that differ by this factor do so by chance: no detail is lost. At 1 / 1.1 / 1.3: noise
 * 15.4 / 15.5 / 16.7, half 13.9 / 13.5 / 14.4. */
#define FLUKE 1.1

/* A pool estimates worse than all places. It takes more neighbours than all of them only if the
 * error falls below SURE times, fewer only if it falls below half of that and the pool's
 * neighbourhoods are thinner than SURE times THICK. At 0.35 / 0.7 / 1 for more: noise 15.4 / 15.5 /
 * 15.1, half 13.8 / 13.5 / 13.3; for fewer: half 13.4 / 13.5 / 13.5; for thinner: noise 15.6 / 15.5
 * / 15.3 and half the same. */
#define SURE 0.7

/* Share of the variance about a thick fit that the nearest EXACT points have about theirs, below
 * which that is no noise, but another sheet or an edge: of noise one in 300 has less. The steps of
 * a lattice are flat, too, but not thick. And share of THICK below which a neighbourhood has no
 * noise that more neighbours could lessen: a flat one always has what coordinates are rounded to,
 * and near its edge they reach beyond. */
#define NO_NOISE 0.04

static const unsigned ladder[STEPS] = VOR_LADDER;

/* Fits at all places with all numbers. */
struct survey {
    const struct vor_domain *domain;
    unsigned from, steps, most; /* steps of the ladder that are tried now; the last one's number */
    const struct vor_neighbors *at;
    uint16_t pool[PLACES][POOL];     /* of each place */
    double least[PLACES];            /* variance about a surface through the nearest EXACT */
    double residual[STEPS][PLACES];  /* variance about the surface */
    double noise[STEPS][PLACES];     /* the part of it that noise explains */
    double thickness[STEPS][PLACES]; /* the root of that over the reach */
};

/* Index of the point of a place: places are at equal steps along the order. */
static size_t place_at(const struct vor_domain *domain, size_t place)
{
    return (size_t)(((double)place + 0.5) / PLACES * (double)domain->n);
}

/* The variance of k points about a surface fitted to those of them that lie on one sheet. */
static double variance_of(struct vor_surface *surface, const struct vor_domain *domain,
                          const float *near, const double x[3], unsigned k)
{
    float own[3 * MOST];

    memcpy(own, near, 3 * k * sizeof *own);
    (void)vor_sheets_fit(surface, own, domain, x, k, NULL);
    return vor_surface_variance(surface, own, k);
}

static void fit_place(void *ctx, size_t place, VOR_UNUSED unsigned worker)
{
    struct survey *survey = ctx;
    const struct vor_domain *domain = survey->domain;
    const float *from = &domain->xyz[3 * place_at(domain, place)];
    double x[3] = {(double)from[0], (double)from[1], (double)from[2]};
    float near[3 * MOST] = {0}, distance2[MOST];
    uint32_t index[MOST];
    struct vor_surface surface;

    vor_knn_search(domain->knn, from, 1, survey->most, index, distance2);
    vor_gather(near, domain->xyz, index, survey->most);
    if (survey->from == 0) {
        survey->least[place] = variance_of(&surface, domain, near, x, EXACT);
        vor_neighbors_pool(survey->pool[place], survey->at->xyz, place);
    }
    for (unsigned s = survey->from; s < survey->steps; s++) {
        double residual = variance_of(&surface, domain, near, x, ladder[s]);
        double thick = THICK * surface.reach, least = survey->least[place];
        int is_thin = residual > thick * thick && least < NO_NOISE * residual;

        survey->residual[s][place] = residual;
        survey->noise[s][place] = is_thin ? least : residual;
        survey->thickness[s][place] =
            surface.reach > 0 ? sqrt(survey->noise[s][place]) / surface.reach : 0;
    }
}

/* Places that are judged together. */
struct pool {
    size_t count;
    uint16_t place[PLACES];
};

/* The thickness that all but a few of the places do not reach. */
static double thickness_of(const struct survey *survey, const struct pool *pool, unsigned step)
{
    double thickness[PLACES] = {0}, share = pool->count < PLACES ? THICK_SHARE_POOL : THICK_SHARE;

    for (size_t i = 0; i < pool->count; i++)
        thickness[i] = survey->thickness[step][pool->place[i]];
    vor_sort_doubles(thickness, pool->count);
    return thickness[(size_t)(share * (double)pool->count)];
}

static double mean_of(const double values[PLACES], const struct pool *pool)
{
    double sum = 0;

    for (size_t i = 0; i < pool->count; i++)
        sum += values[pool->place[i]];
    return sum / (double)pool->count;
}

static double residual_of(const struct survey *survey, const struct pool *pool, unsigned step)
{
    return mean_of(survey->residual[step], pool);
}

/* Whether the residual grows faster from the first step to that one than that of points that fill a
 * ball, which grows as the reach squared: then detail or another sheet comes in, and more
 * neighbours raise the error. */
static int outgrows_ball(const struct survey *survey, const struct pool *pool, unsigned step)
{
    double from = residual_of(survey, pool, 0), to = residual_of(survey, pool, step);
    double more = (double)ladder[step] / ladder[0];

    return to * to * to > more * more * from * from * from;
}

/* The first step at which neighbourhoods are wide enough to show a surface. */
static unsigned wide_step(const struct survey *survey, const struct pool *pool)
{
    double thickness[STEPS] = {0}, least = INFINITY;
    unsigned step = 0;

    for (unsigned s = 0; s < survey->steps; s++) {
        thickness[s] = thickness_of(survey, pool, s);
        least = fmin(least, thickness[s]);
    }
    while (thickness[step] > (least > THICK ? HELPS * least : THICK))
        step++;
    while (step > 0 && outgrows_ball(survey, pool, step))
        step--;
    return step;
}

/* Mean square error of a fit at that step if its neighbours have noise of that variance: what is
 * left of the noise, and the detail that is lost. */
static double error_of(double residual, unsigned step, double noise)
{
    return LEVERAGE * noise / ladder[step] + fmax(0, residual - FLUKE * noise);
}

/* The step with the least error, from `from` on. */
static unsigned best_step(const struct survey *survey, const struct pool *pool, unsigned from)
{
    double noise = mean_of(survey->noise[from], pool), least = INFINITY;
    unsigned best = from;

    if (thickness_of(survey, pool, from) < NO_NOISE * THICK)
        return from;
    for (unsigned s = from; s < survey->steps; s++) {
        double error = error_of(residual_of(survey, pool, s), s, noise);

        if (error < least) {
            least = error;
            best = s;
        }
    }
    return best;
}

/* Whether step s is better than the usual one by enough, and at half of the places at least: not
 * only at a few, at an edge. */
static int worth_it(const struct survey *survey, const struct pool *pool, unsigned from, unsigned s,
                    unsigned usual)
{
    double noise = mean_of(survey->noise[from], pool), worth = s < usual ? SURE / 2 : SURE;
    unsigned agree = 0;

    if (error_of(residual_of(survey, pool, s), s, noise) >
        worth * error_of(residual_of(survey, pool, usual), usual, noise))
        return 0;
    for (size_t i = 0; i < pool->count; i++) {
        size_t place = pool->place[i];

        noise = survey->noise[from][place];
        agree += error_of(survey->residual[s][place], s, noise) <
                 error_of(survey->residual[usual][place], usual, noise);
    }
    return 2 * agree >= pool->count;
}

/* The best step for a few places; all places together begin at `from` and take `usual`. */
static unsigned local_step(const struct survey *survey, const struct pool *pool, unsigned from,
                           unsigned usual)
{
    unsigned best;

    while (from > 0 && thickness_of(survey, pool, from - 1) <= SURE * THICK)
        from--;
    best = best_step(survey, pool, from);
    return worth_it(survey, pool, from, best, usual) ? best : usual;
}

VOR_CLONES void vor_neighbors_pool(uint16_t pool[VOR_NEIGHBORS_POOL], const float *xyz,
                                   size_t place)
{
    size_t first = place < POOL / 2 ? 0 : place - POOL / 2;
    double all2[PLACES], distance2[POOL] = {0};

    for (size_t i = 0; i < PLACES; i++)
        all2[i] = vor_distance2f(&xyz[3 * i], &xyz[3 * place]);
    for (size_t turn = 0; turn < PLACES; turn++) { /* most of the nearest come first */
        size_t i = (first + turn) % PLACES, at = turn < POOL ? turn : POOL - 1;
        double to = all2[i];

        if (turn >= POOL && !(to < distance2[at] || (to <= distance2[at] && i < pool[at])))
            continue;
        for (; at > 0 && (to < distance2[at - 1] || (to <= distance2[at - 1] && i < pool[at - 1]));
             at--) {
            distance2[at] = distance2[at - 1];
            pool[at] = pool[at - 1];
        }
        distance2[at] = to;
        pool[at] = (uint16_t)i;
    }
}

static void pool_around(struct pool *pool, const struct survey *survey, size_t place)
{
    pool->count = POOL;
    memcpy(pool->place, survey->pool[place], sizeof survey->pool[place]);
}

static void pool_all(struct pool *pool)
{
    pool->count = PLACES;
    for (size_t i = 0; i < PLACES; i++)
        pool->place[i] = (uint16_t)i;
}

static vor_status fit_places(struct survey *survey, unsigned steps, const struct vor_run *run,
                             struct vor_error *err)
{
    survey->from = survey->steps;
    survey->steps = steps;
    survey->most = ladder[steps - 1];
    return vor_run_rows(run, PLACES, BLOCK, fit_place, survey, err);
}

/* Whether the smallest number is best at every place, by the first steps of the ladder: then the
 * others need not be tried. */
static int fewest_do(const struct survey *survey)
{
    struct pool pool;

    pool_all(&pool);
    if (thickness_of(survey, &pool, 0) > THICK)
        return 0;
    for (size_t place = 0; place < PLACES; place++) {
        pool_around(&pool, survey, place);
        if (best_step(survey, &pool, 0) > 0)
            return 0;
    }
    return 1;
}

static void choose(struct vor_neighbors *out, const struct survey *survey)
{
    struct pool pool;
    unsigned from, usual;

    pool_all(&pool);
    from = wide_step(survey, &pool);
    usual = best_step(survey, &pool, from);
    vor_neighbors_fix(out, ladder[usual]);
    for (size_t place = 0; place < PLACES; place++) {
        unsigned k;

        pool_around(&pool, survey, place);
        k = ladder[local_step(survey, &pool, from, usual)];
        out->k[place] = (unsigned char)k;
        out->most = k > out->most ? k : out->most;
        if (k != out->usual)
            out->places = PLACES;
    }
}

static void put_in_boxes(struct vor_neighbors *out)
{
    for (size_t i = 0; i < 3 * VOR_NEIGHBORS_PLACES; i++) {
        size_t b = i / (3 * VOR_NEIGHBORS_BATCH);
        double *low = &out->low[i % 3][b], *high = &out->high[i % 3][b], x = (double)out->xyz[i];

        if (i % (3 * VOR_NEIGHBORS_BATCH) < 3)
            *low = *high = x;
        *low = x < *low ? x : *low;
        *high = x > *high ? x : *high;
    }
}

vor_status vor_neighbors_choose(struct vor_neighbors *out, const struct vor_domain *domain,
                                const struct vor_run *run, struct vor_error *err)
{
    struct survey *survey = vor_calloc(run->memory, 1, sizeof *survey);
    unsigned steps = 0;
    vor_status status = VOR_OK;

    if (survey == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the neighbours of %d points", (int)PLACES);
    survey->domain = domain;
    survey->at = out;
    vor_neighbors_fix(out, ladder[0]);
    for (size_t place = 0; place < PLACES; place++)
        memcpy(&out->xyz[3 * place], &domain->xyz[3 * place_at(domain, place)],
               3 * sizeof *out->xyz);
    put_in_boxes(out);
    while (steps < STEPS && (size_t)ROOM * ladder[steps] <= domain->n)
        steps++;
    if (steps >= FIRST)
        status = fit_places(survey, FIRST, run, err);
    if (status == VOR_OK && steps >= FIRST && !fewest_do(survey)) {
        status = fit_places(survey, steps, run, err);
        if (status == VOR_OK)
            choose(out, survey);
    }
    vor_free(run->memory, survey);
    return status;
}

/* Squared distances from x to the boxes: by the same operations as to a place in one, so never
 * larger. */
VOR_CLONES static void box_distances(double *restrict distance2,
                                     const struct vor_neighbors *neighbors, const float x[3])
{
    for (size_t b = 0; b < VOR_NEIGHBORS_BOXES; b++) {
        double gap[3];

        for (size_t c = 0; c < 3; c++) {
            double below = neighbors->low[c][b] - (double)x[c];
            double above = (double)x[c] - neighbors->high[c][b];

            below = below > 0 ? below : 0;
            gap[c] = above > below ? above : below;
        }
        distance2[b] = gap[0] * gap[0] + gap[1] * gap[1] + gap[2] * gap[2];
    }
}

unsigned vor_neighbors_at(const struct vor_neighbors *neighbors, const float x[3])
{
    double box2[VOR_NEIGHBORS_BOXES] = {0}; /* gcc's analyzer does not follow VOR_CLONES */
    double least = INFINITY;
    size_t nearest = 0, best = 0;

    if (neighbors->places == 0)
        return neighbors->most;
    box_distances(box2, neighbors, x);
    for (size_t b = 1; b < VOR_NEIGHBORS_BOXES; b++)
        nearest = box2[b] < box2[nearest] ? b : nearest;
    for (size_t turn = 0; turn <= VOR_NEIGHBORS_BOXES; turn++) {
        size_t b = turn > 0 ? turn - 1 : nearest, begin = b * VOR_NEIGHBORS_BATCH;

        if (box2[b] > least) /* most are */
            continue;
        for (size_t i = begin; i < begin + VOR_NEIGHBORS_BATCH; i++) {
            double distance2 = vor_distance2f(&neighbors->xyz[3 * i], x);

            if (distance2 < least || (distance2 <= least && i < best)) {
                least = distance2;
                best = i;
            }
        }
    }
    return neighbors->k[best];
}

void vor_neighbors_fewer(struct vor_neighbors *neighbors, double share)
{
    neighbors->usual = (unsigned)fmax(neighbors->usual * share, VOR_NEIGHBORS_FEWEST);
    neighbors->most = (unsigned)fmax(neighbors->most * share, VOR_NEIGHBORS_FEWEST);
    for (unsigned i = 0; i < neighbors->places; i++)
        neighbors->k[i] = (unsigned char)fmax(neighbors->k[i] * share, VOR_NEIGHBORS_FEWEST);
}
