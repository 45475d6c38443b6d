#include "core/input/restore.h"

#include "core/base/linalg.h"
#include "core/geom/surface.h"
#include "core/input/conditioning.h"
#include "core/input/domain.h"
#include "core/input/lattice.h"
#include "core/input/splats.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum {
    BLOCK = VOR_LATTICE_BLOCK, /* points of one task */
    /* Neighbours of the widest fit; the finer ones have half and a quarter. At 90 / 120 bytes saved
     * at equal D2 (tests/by_hand/bench/codec.pl): 18.1 / 18.4 %. */
    WIDE = 6 * VOR_NEIGHBORS_FEWEST,
    /* One point in so many has a fit. At 5 / 7 / 10: 18.5 / 18.4 / 18.1 %; igea, us of CPU a point,
     * 3.5 / 2.7 / 2.0. */
    EACH = WIDE / VOR_NEIGHBORS_FEWEST
};

#define NONE UINT32_MAX

/* Sums are whole numbers, so that they do not depend on the order of threads: in 2^-32 of a cell
 * and of a weight, which is at most WIDE / 6. */
#define STEP 0x1p-32

/* What fits say of one point: the weighted sum of its moves over the cells, and of the weights. */
struct votes {
    _Atomic int64_t by[3], weight;
};

struct restore {
    const struct vor_run *run;
    struct vor_domain domain;
    struct vor_cloud *cloud;
    struct vor_regions regions;
    struct votes *votes;
    uint32_t *place;         /* of each point of the cloud, in the domain */
    _Atomic uint32_t *count; /* of each point of the domain: how many of the cloud are there */
    atomic_size_t moved;
};

/* The neighbours of a point, nearest first. */
struct hood {
    const uint32_t *index;
    const float *distance2;
    float near[3 * WIDE], count[WIDE];
};

/* A fit to the first k of them. */
struct fit {
    unsigned k;
    double rounding; /* variance of rounding across it */
    double expected; /* variance of a further point about it */
    double error;    /* variance of what it says, over that of rounding */
    double share;    /* of a way that rounding explains */
    double total;    /* of the weights */
    float weight[WIDE];
    double by[4 * WIDE]; /* vor_surface_feet */
};

/* Sets the weights (1 - d^2 / d_k^2)^3, for each point that was rounded to a place. Returns the sum
 * of their squares over their own squared: one over the number of equal weights that would be as
 * good. */
static double weigh(struct fit *fit, const struct hood *hood)
{
    double sum = 0, squares = 0;

    for (unsigned j = 0; j < fit->k; j++) {
        float inside = 1 - hood->distance2[j] / (1.001F * hood->distance2[fit->k - 1]);
        double weight = (double)(inside * inside * inside * hood->count[j]);

        fit->weight[j] = (float)weight;
        sum += weight;
        squares += weight * weight;
    }
    fit->total = sum;
    return squares / (sum * sum);
}

/* Sets the way of each neighbour to its foot, to first order. Returns the weighted variance of
 * their distances from the surface. */
static double find_feet(struct fit *fit, const struct vor_surface *surface, const struct hood *hood)
{
    double sum = 0;

    vor_surface_feet(surface, hood->near, fit->k, fit->by);
    for (unsigned j = 0; j < fit->k; j++)
        sum += (double)fit->weight[j] * fit->by[3 * fit->k + j];
    return sum / fit->total;
}

/* The variance of rounding along the surface's normal: uniform in the cell, but along an axis that
 * the surface runs across within less than a cell, most points are rounded by about the same, and
 * what differs is no more than the variance of the feet. */
static double expect_rounding(const struct fit *fit, const struct vor_surface *surface,
                              const struct hood *hood, const double cell[3])
{
    double mean[3] = {0}, square[3] = {0}, sum = 0;

    for (unsigned j = 0; j < fit->k; j++)
        for (size_t c = 0; c < 3; c++) {
            double foot =
                (double)hood->near[3 * j + c] - surface->origin[c] + fit->by[c * fit->k + j];
            double weighed = (double)fit->weight[j] * foot;

            mean[c] += weighed;
            square[c] += weighed * foot;
        }
    for (size_t c = 0; c < 3; c++) {
        double along = surface->axis[2][c], middle = mean[c] / fit->total;
        double variance = fmax(square[c] / fit->total - middle * middle, 0);

        sum += along * along * fmin(cell[c] * cell[c] / 12, variance);
    }
    return sum;
}

/* What rounding explains of the way of neighbour j: a share, and at most the way from the middle of
 * a cell to the farthest plane across the way that touches the cell. */
static double explain(const struct fit *fit, unsigned j, const double cell[3])
{
    double square = 0, most = 0;

    for (size_t c = 0; c < 3; c++) {
        double by = fit->by[c * fit->k + j];

        square += by * by;
        most += fabs(by) * cell[c] / 2;
    }
    return square > most ? fit->share * (most / square) : fit->share;
}

/* Fits to the k nearest of a point whose lattice is known. most: of the variance of rounding. */
static void make_fit(struct fit *fit, const struct hood *hood, unsigned k, const double cell[3],
                     double most)
{
    struct vor_surface surface;
    double taken, variance;

    fit->k = k;
    fit->error = fit->expected = INFINITY;
    fit->rounding = most;
    taken = weigh(fit, hood);
    vor_surface_fit_weighted(&surface, hood->near, fit->weight, k);
    taken *= surface.kind == VOR_SURFACE_QUADRIC ? 6 : 3; /* coefficients */
    if (surface.kind == VOR_SURFACE_NONE || !(taken < 1))
        return;
    variance = find_feet(fit, &surface, hood) / (1 - taken);
    fit->rounding = fmin(most, expect_rounding(fit, &surface, hood, cell));
    fit->share = variance > fit->rounding ? fit->rounding / variance : 1;
    fit->error = 1 - fit->share + taken;
    fit->expected = variance * (1 + taken);
}

static const double *cell_at(const struct restore *restore, size_t i)
{
    return restore->regions.cell[vor_region_of(&restore->regions, &restore->domain, i)];
}

/* Tells the neighbours what a fit says of them. */
static void vote(struct restore *restore, const struct fit *fit, const struct hood *hood,
                 const double own[3])
{
    for (unsigned j = 0; j < fit->k; j++) {
        struct votes *votes = &restore->votes[hood->index[j]];
        const double *cell = cell_at(restore, hood->index[j]);
        double weight = (double)(fit->weight[j] / hood->count[j]) / (fit->error * STEP);
        double share = explain(fit, j, own);

        for (size_t c = 0; c < 3; c++) {
            double by = cell[c] > 0 ? fit->by[c * fit->k + j] * share / cell[c] : 0;

            by = weight * (by < -0.5 ? -0.5 : by > 0.5 ? 0.5 : by);
            atomic_fetch_add_explicit(&votes->by[c], llrint(by), memory_order_relaxed);
        }
        atomic_fetch_add_explicit(&votes->weight, llrint(weight), memory_order_relaxed);
    }
}

/* Fits to half of the neighbours, to all and to a quarter. Returns the fit that a further point
 * would be nearest to (Akaike's final prediction error): wide ones miss details, fine ones follow
 * the rounding. Whether the surface crosses cells is seen in the half: at 6 bits office1 gains -.02
 * dB of D2 so, -.10 where it is seen in each. */
static const struct fit *choose_fit(struct fit fits[2], const struct hood *hood,
                                    const double cell[3])
{
    double most;
    int best;

    make_fit(&fits[0], hood, WIDE / 2, cell, INFINITY);
    most = fits[0].rounding;
    make_fit(&fits[1], hood, WIDE, cell, most);
    best = fits[1].expected < fits[0].expected;
    make_fit(&fits[!best], hood, WIDE / 4, cell, most);
    return fits[!best].expected < fits[best].expected ? &fits[!best] : &fits[best];
}

/* Fits to points of the order whose lattice is known. */
static void vote_around(struct restore *restore, const uint32_t *at, size_t count)
{
    const struct vor_domain *domain = &restore->domain;
    uint32_t index[VOR_KNN_NEAR_MAX * WIDE];
    float query[3 * VOR_KNN_NEAR_MAX], distance2[VOR_KNN_NEAR_MAX * WIDE];
    struct fit fits[2];
    struct hood hood;

    vor_gather(query, domain->xyz, at, count);
    vor_knn_search_near(domain->knn, &(struct vor_knn_near){query, count, WIDE, NULL, 0}, index,
                        distance2);
    for (size_t i = 0; i < count; i++) {
        const double *cell = cell_at(restore, at[i]);
        const struct fit *fit;

        hood.index = &index[i * WIDE];
        hood.distance2 = &distance2[i * WIDE];
        vor_gather(hood.near, domain->xyz, hood.index, WIDE);
        for (size_t j = 0; j < WIDE; j++)
            hood.count[j] =
                (float)atomic_load_explicit(&restore->count[hood.index[j]], memory_order_relaxed);
        fit = choose_fit(fits, &hood, cell);
        if (isfinite(fit->error))
            vote(restore, fit, &hood, cell);
    }
}

static void vote_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct restore *restore = ctx;
    uint32_t at[VOR_KNN_NEAR_MAX];
    size_t count = 0;

    assert(restore->domain.n >= VOR_DOMAIN_FEW); /* or there is no lattice */
    for (size_t i = vor_blocks_of(begin, EACH) * EACH; i < end; i += EACH) {
        if (cell_at(restore, i)[0] > 0)
            at[count++] = (uint32_t)i;
        if (count == VOR_KNN_NEAR_MAX || (count > 0 && i + EACH >= end)) {
            vote_around(restore, at, count);
            count = 0;
        }
    }
}

/* The places of a lattice between two coordinates. */
static uint64_t places_between(float a, float b, double cell)
{
    return (uint64_t)(fabs((double)a - (double)b) / cell + 0.5);
}

/* True when some piece of the order has at most every second place of a lattice along each axis. */
static int has_coarser(const struct vor_domain *domain, const struct vor_lattice *lattice)
{
    for (size_t first = 0; first + VOR_LATTICE_BLOCK <= domain->n; first += VOR_LATTICE_BLOCK) {
        const float *x = &domain->xyz[3 * first];
        uint64_t step = 2;

        for (int c = 0; c < 3 && step > 1; c++) {
            step = 0; /* the greatest common divisor */
            for (int i = 1; i < VOR_LATTICE_BLOCK && step != 1; i++)
                for (uint64_t rest = places_between(x[3 * i + c], x[c], lattice->cell[c]);
                     rest > 0;) {
                    uint64_t before = rest;

                    rest = step % rest;
                    step = before;
                }
        }
        if (step > 1)
            return 1;
    }
    return 0;
}

/* Looks for the lattice of all points. If none counts, or pieces of their order have coarser ones,
 * each piece has its own, or that of all. */
static vor_status find_regions(struct restore *restore, struct vor_error *err)
{
    struct vor_regions *regions = &restore->regions;
    const struct vor_domain *domain = &restore->domain;
    struct vor_lattice found;
    vor_status status = vor_lattice_find(&found, domain, restore->run, err);
    int is_wide = status == VOR_OK && vor_lattice_is_wide(&found);

    if (status == VOR_OK && (!is_wide || has_coarser(domain, &found)))
        status = vor_lattice_find_regions(regions, domain, 1, restore->run, err);
    if (status != VOR_OK)
        return status;
    for (int c = 0; c < 3; c++)
        regions->widest[c] = fmax(regions->widest[c], found.cell[c]);
    if (!is_wide) {
        if (vor_lattice_is_full(&found)) /* of all points, though small */
            regions->pitch[1] = 0;
        return VOR_OK;
    }
    if (!(regions->pitch[1] > 0)) { /* one of all */
        vor_free(restore->run->memory, regions->cell);
        *regions = (struct vor_regions){.many = domain->n, .n = 1};
        memcpy(regions->widest, found.cell, sizeof found.cell);
        regions->cell = vor_calloc(restore->run->memory, 1, sizeof *regions->cell);
        if (regions->cell == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    }
    regions->eligible = domain->n;
    for (size_t i = 0; i < regions->n; i++)
        if (!(regions->cell[i][0] > 0))
            memcpy(regions->cell[i], found.cell, sizeof found.cell);
    return VOR_OK;
}

/* Finds the place in the domain of each point of the cloud, and counts: those that coincide share
 * one. */
static void place_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct restore *restore = ctx;

    for (size_t i = begin; i < end; i++) {
        float x[3], distance2;

        if (restore->place[i] == NONE) {
            vor_domain_normalise(&restore->domain, &restore->cloud->xyz[3 * i], x);
            vor_knn_search(restore->domain.knn, x, 1, 1, &restore->place[i], &distance2);
        }
        atomic_fetch_add_explicit(&restore->count[restore->place[i]], 1, memory_order_relaxed);
    }
}

static void move_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct restore *restore = ctx;
    const struct vor_domain *domain = &restore->domain;
    struct vor_cloud *cloud = restore->cloud;
    size_t moved = 0;

    for (size_t i = begin; i < end; i++) {
        size_t at = restore->place[i];
        const struct votes *votes = &restore->votes[at];
        const double *cell = cell_at(restore, at);
        double weight = (double)atomic_load_explicit(&votes->weight, memory_order_relaxed);
        int is_moved = 0;

        for (size_t c = 0; c < 3 && weight > 0; c++) {
            double by = (double)atomic_load_explicit(&votes->by[c], memory_order_relaxed) / weight;
            float *x = &cloud->xyz[3 * i + c];
            double to = (double)*x + by * cell[c] * domain->unit;

            is_moved |= (float)to != *x;
            if ((float)to != *x && cloud->exact != NULL)
                cloud->exact[3 * i + c] += to - (double)*x;
            *x = (float)to;
        }
        moved += (size_t)is_moved;
    }
    atomic_fetch_add_explicit(&restore->moved, moved, memory_order_relaxed);
}

/* Moves the points of a cloud whose domain and lattice are known. */
static vor_status move(struct restore *restore, struct vor_error *err)
{
    const struct vor_run *run = restore->run;
    size_t n = restore->cloud->n;
    vor_status status;

    restore->votes = vor_calloc(run->memory, restore->domain.n, sizeof *restore->votes);
    restore->place = vor_malloc(run->memory, n, sizeof *restore->place);
    restore->count = vor_calloc(run->memory, restore->domain.n, sizeof *restore->count);
    if (restore->votes == NULL || restore->place == NULL || restore->count == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    for (size_t i = 0; i < n; i++)
        restore->place[i] = NONE;
    for (size_t i = 0; i < restore->domain.n; i++)
        restore->place[restore->domain.source[i]] = (uint32_t)i;
    status = vor_run_for(run, n, BLOCK, place_block, restore, err);
    VOR_THEN(status, vor_run_for(run, restore->domain.n, BLOCK, vote_block, restore, err));
    return status == VOR_OK ? vor_run_for(run, n, BLOCK, move_block, restore, err) : status;
}

vor_status vor_restore_cloud(struct vor_cloud *cloud, struct vor_report *report,
                             const struct vor_spec *spec, const struct vor_run *run,
                             struct vor_error *err)
{
    struct restore restore = {.run = run, .cloud = cloud};
    vor_status status = vor_splats_check(cloud, spec, err);

    VOR_THEN(status, vor_domain_init(&restore.domain, cloud, run, err));
    VOR_THEN(status, find_regions(&restore, err));
    if (status == VOR_OK && restore.regions.eligible > 0)
        status = move(&restore, err);
    if (status == VOR_E_DEGENERATE) /* nothing to fit to */
        status = VOR_OK;
    for (int c = 0; c < 3; c++)
        report->lattice[c] = restore.regions.widest[c] * restore.domain.unit;
    report->off_lattice = restore.moved;
    if (restore.regions.pitch[1] > 0)
        vor_warn(report->warnings, &report->warnings_count, VOR_WARNING_PITCHES,
                 restore.regions.pitch[1] * restore.domain.unit,
                 restore.regions.pitch[0] * restore.domain.unit);
    if (status == VOR_OK &&
        (restore.regions.eligible == 0 || restore.regions.eligible < restore.domain.n))
        vor_warn(report->warnings, &report->warnings_count, VOR_WARNING_NOT_RESTORED,
                 (double)restore.regions.eligible, (double)restore.domain.n);
    VOR_FREE_ALL(run->memory, restore.count, restore.place, restore.votes, restore.regions.cell);
    vor_domain_free(&restore.domain);
    return status;
}
