#include "core/cvt/lloyd.h"

#include "core/base/linalg.h"
#include "core/geom/boundary.h"
#include "core/opt/anderson.h"
#include "core/seeds/area.h"
#include "core/seeds/attach.h"
#include "core/seeds/stage.h"
#include "core/seeds/uniformity.h"

#include <string.h>

/* Figures are delta after 20 iterations without polish: igea, 12,000 points of white noise to
 * 3,000, "cow" 50,000 points of which one end is ten times as dense to 2,000, "few" 300 points on a
 * cow. Other seeds move them by 2, 3 and 3 %. */

/* Iterations whose gain decides about a plateau. */
enum { PLATEAU_WINDOW = 10 };
/* Delta must fall below this share of its value a window ago. At 0.98 / 0.99 / 0.995 igea ends
 * after 35 / 39 / 43 iterations, at 0.046 each. */
#define PLATEAU_GAIN 0.99

/* Most times that a cell is clipped where the input ends. 1 and 6 change nothing on bunny, autzen
 * and a square. */
enum { SHORTEN_MAX = 3 };

/* The last iterations on the whole of a thinned input: one in ON_WHOLE of all, at most
 * as many. One in 4 / 8 / 16 of 20: armadillo, 300,000 to 4,000, 0.0652 / 0.0654 / 0.0654, rms
 * distance to the true surface 0.70e-4 / 0.66e-4 / 0.72e-4 (spread 6 %), searches 67 / 59 / 55
 * thousand. */
enum { ON_WHOLE = 8 };

/* Times the way to the centroid. At 1 / 1.5 / 1.9: igea 0.0508 / 0.0482 / 0.0483, few 0.085 / 0.101
 * / 0.103; 2 is where plain relaxation stops converging. */
#define RELAXATION 1.5
/* Share of the last step that is added, at most. At 0.3 / 0.6 / 0.9: igea 0.0510 / 0.0482 / 0.0485,
 * cow 0.0658 / 0.0709 / 0.0812. */
#define MOMENTUM 0.6

enum { AT_BORDER = 1 << 0, HELD_EVER = 1 << 1 }; /* flags of a seed */

struct block_sums {
    double area, even, energy, max_move; /* even: the area as an even spread would share it */
    uint64_t held, plane, left;
};

struct cvt {
    struct vor_seeds *seeds;
    const struct vor_spec *spec;
    const struct vor_run *run; /* a stop ends it */
    struct vor_stage stage;
    size_t blocks;
    struct block_sums *sums, total;
    float *lloyd, *mix; /* candidates, n x 3 each */
    float *normal;      /* of the surface at the projected centroid, n x 3; NULL: no mix */
    float *step;        /* the last one of each seed, n x 3; NULL: no momentum */
    unsigned char *flags;
    struct vor_anderson anderson;
    double past[PLATEAU_WINDOW]; /* best delta of the last iterations */
    int level;                   /* a plateau was reached */
};

/* How many of the last iterations run on the whole of the input. */
static uint32_t on_whole(const struct cvt *cvt)
{
    uint32_t share = cvt->stage.record.of / ON_WHOLE;

    return share < ON_WHOLE ? share : ON_WHOLE;
}

static int polish_follows(const struct cvt *cvt)
{
    return cvt->spec->value[VOR_PARAM_POLISH] > 0;
}

static void free_cvt(struct cvt *cvt)
{
    struct vor_memory *memory = cvt->seeds->run.memory;

    if (cvt->anderson.length > 0)
        vor_anderson_free(&cvt->anderson);
    VOR_FREE_ALL(memory, cvt->flags, cvt->step, cvt->normal);
    vor_stage_free(&cvt->stage);
    VOR_FREE_ALL(memory, cvt->mix, cvt->lloyd, cvt->sums);
}

static vor_status alloc_cvt(struct cvt *cvt, struct vor_error *err)
{
    struct vor_memory *memory = cvt->seeds->run.memory;
    size_t n = cvt->seeds->n, row = 3 * sizeof(float);
    int momentum = !vor_spec_given(cvt->spec, VOR_PARAM_ANDERSON);
    unsigned window = momentum ? 0 : (unsigned)cvt->spec->value[VOR_PARAM_ANDERSON];
    int ok;

    cvt->blocks = (n + VOR_SEEDS_BLOCK - 1) / VOR_SEEDS_BLOCK;
    cvt->sums = vor_calloc(memory, cvt->blocks, sizeof *cvt->sums);
    cvt->lloyd = vor_malloc(memory, n, row);
    cvt->flags = vor_calloc(memory, n, 1);
    ok = cvt->sums != NULL && cvt->lloyd != NULL && cvt->flags != NULL;
    if (momentum) {
        cvt->step = vor_calloc(memory, n, row);
        ok &= cvt->step != NULL;
    }
    if (window > 0) {
        cvt->mix = vor_malloc(memory, n, row);
        cvt->normal = vor_calloc(memory, n, row);
        ok &= cvt->mix != NULL && cvt->normal != NULL;
    }
    if (!ok)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    return window > 0 ? vor_anderson_init(&cvt->anderson, 3 * n, window, memory, err) : VOR_OK;
}

/* The centroid of scratch->cell lies outside: clips the cell where the input ends in that
 * direction, and computes the centroid x again. */
static void shorten_cell(const struct cvt *cvt, struct vor_scratch *scratch, size_t i,
                         struct vor_moments *moments, double x[3])
{
    double side[2] = {moments->centroid[0] - scratch->cell.seed[0],
                      moments->centroid[1] - scratch->cell.seed[1]};
    double length = sqrt(side[0] * side[0] + side[1] * side[1]), end;

    if (!(length > 0))
        return;
    side[0] /= length;
    side[1] /= length;
    end = fmax(vor_boundary_end(&scratch->here.surface, scratch->cell.seed, side,
                                scratch->there.near, scratch->there.k),
               VOR_EDGE_ROOM * scratch->there.surface.spacing);
    vor_cell_clip(&scratch->cell, (double[3]){2 * end * side[0], 2 * end * side[1], 0});
    if (!vor_area_moments(moments, cvt->seeds, scratch, i))
        return;
    vor_surface_to_world(&scratch->here.surface, moments->centroid, x);
    vor_surface_put(&scratch->here.surface, x);
}

/* Projects x onto the surface of the input around it. Returns whether it is outside the input. */
static int outside(const struct cvt *cvt, struct vor_scratch *scratch, struct vor_border *border,
                   double x[3])
{
    if (vor_seeds_fit_at(cvt->seeds, scratch, &scratch->there, x) == VOR_SURFACE_NONE)
        return 0;
    vor_surface_put(&scratch->there.surface, x);
    vor_seeds_border(cvt->seeds, scratch, &scratch->there, border, x);
    return vor_boundary_outside(border, VOR_OUTSIDE_MOVING, x);
}

/* Changes x, the place that seed i is meant to go to, to one that it may go to (OUTSIDE in
 * geom/boundary.h). Judged by the input around x, not by that around the seed. Returns whether the
 * seed is held back. */
static int restrict_move(struct cvt *cvt, struct vor_scratch *scratch, size_t i,
                         struct vor_moments *moments, double x[3])
{
    struct vor_border border;

    if (!cvt->seeds->policy.keep_border ||
        vor_boundary_within(scratch->here.near, scratch->here.k, x,
                            scratch->here.surface.spacing) ||
        !outside(cvt, scratch, &border, x))
        return 0;
    cvt->flags[i] |= AT_BORDER;
    for (int tries = 0; tries < SHORTEN_MAX; tries++) {
        shorten_cell(cvt, scratch, i, moments, x);
        if (!outside(cvt, scratch, &border, x))
            return 0;
    }
    (void)vor_boundary_restrict(&border, VOR_OUTSIDE_MOVING, x);
    cvt->flags[i] |= HELD_EVER;
    return 1;
}

/* Length of an offset of seed i, in the metric if there is one. */
static double length_of(const struct cvt *cvt, size_t i, const double d[3])
{
    return sqrt(vor_stretched_length2(&cvt->seeds->stretched, i, i, d));
}

/* Over-relaxation and momentum: stretches the way of seed i to its projected centroid x, and adds a
 * share of its last step. */
static void stretch(const struct cvt *cvt, struct vor_scratch *scratch, size_t i, double x[3])
{
    double k = cvt->stage.record.step, momentum = fmin(MOMENTUM, k / (k + 3)); /* Nesterov's */
    double way[3] = {0}, step[3] = {0}; /* clang-analyzer cannot see that the loop sets all */
    double most, length;

    for (size_t c = 0; c < 3; c++) {
        way[c] = x[c] - (double)cvt->seeds->xyz[3 * i + c];
        step[c] = RELAXATION * way[c] + momentum * (double)cvt->step[3 * i + c];
    }
    most = fmax(VOR_LLOYD_LONG_STEP * scratch->radius, length_of(cvt, i, way));
    length = length_of(cvt, i, step);
    for (size_t c = 0; c < 3; c++)
        x[c] = (double)cvt->seeds->xyz[3 * i + c] +
               (length > most ? step[c] * (most / length) : step[c]);
    vor_surface_put(&scratch->here.surface, x);
}

/* Moves seed i to its cell's projected centroid, or beyond. A seed whose cell is empty, because it
 * lies too far off its own surface, is projected; a seed without a surface stays. */
static void lloyd_step(struct cvt *cvt, struct vor_scratch *scratch, size_t i,
                       struct block_sums *sums)
{
    enum vor_surface_kind kind = vor_seeds_cell(cvt->seeds, scratch, i);
    struct vor_moments moments;
    double x[3], normal[3];

    memcpy(&cvt->lloyd[3 * i], &cvt->seeds->xyz[3 * i], 3 * sizeof(float));
    cvt->flags[i] &= (unsigned char)~AT_BORDER;
    if (kind == VOR_SURFACE_NONE) {
        if (cvt->step != NULL)
            memset(&cvt->step[3 * i], 0, 3 * sizeof(float));
        sums->left++;
        return;
    }
    if (vor_area_moments(&moments, cvt->seeds, scratch, i)) {
        double wanted = vor_wanted_at(&cvt->seeds->wanted, i);

        sums->area += moments.area;
        sums->even += moments.area / (wanted * wanted);
        sums->energy += moments.energy;
    } else {
        memcpy(moments.centroid, scratch->cell.seed, sizeof moments.centroid);
    }
    sums->plane += kind == VOR_SURFACE_PLANE && !cvt->seeds->policy.planes;
    if (i >= vor_seeds_moving(cvt->seeds)) {
        cvt->flags[i] |= AT_BORDER; /* nor does the mix move it */
        return;
    }
    vor_surface_project(&scratch->here.surface, moments.centroid);
    vor_surface_to_world(&scratch->here.surface, moments.centroid, x);
    if (cvt->normal != NULL) {
        vor_surface_normal(&scratch->here.surface, moments.centroid, normal);
        vor_to_floats(&cvt->normal[3 * i], normal);
    }
    if (cvt->step != NULL)
        stretch(cvt, scratch, i, x);
    sums->held += (uint64_t)restrict_move(cvt, scratch, i, &moments, x);
    vor_to_floats(&cvt->lloyd[3 * i], x);
    for (size_t c = 0; cvt->step != NULL && c < 3; c++)
        cvt->step[3 * i + c] = cvt->lloyd[3 * i + c] - cvt->seeds->xyz[3 * i + c];
}

static double move2(const struct cvt *cvt, const float *to, size_t i)
{
    return vor_distance2f(&to[3 * i], &cvt->seeds->xyz[3 * i]);
}

static void lloyd_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct cvt *cvt = ctx;
    struct vor_scratch *scratch = &cvt->seeds->scratch[worker];
    struct block_sums sums = {0};

    vor_seeds_input_ahead(cvt->seeds, begin, end);
    for (size_t i = begin; i < end; i++) {
        lloyd_step(cvt, scratch, i, &sums);
        sums.max_move = fmax(sums.max_move, move2(cvt, cvt->lloyd, i));
    }
    sums.max_move = sqrt(sums.max_move);
    cvt->sums[begin / VOR_SEEDS_BLOCK] = sums;
}

/* The Anderson mix for seed i: the centroid plus the tangential part of the difference, bounded. */
static void mix_step(struct cvt *cvt, size_t i)
{
    const float *lloyd = &cvt->lloyd[3 * i], *normal = &cvt->normal[3 * i];
    double d[3], x[3], off = 0, length, limit;

    for (size_t c = 0; c < 3; c++) {
        d[c] = -(double)lloyd[c];
        for (unsigned j = 0; j < cvt->anderson.depth; j++)
            d[c] += cvt->anderson.weight[j] * (double)cvt->anderson.image[j][3 * i + c];
    }
    for (int c = 0; c < 3; c++)
        off += d[c] * (double)normal[c];
    for (int c = 0; c < 3; c++)
        d[c] -= off * (double)normal[c];
    length = length_of(cvt, i, d);
    limit = (double)cvt->stage.nearest[i] / 2; /* points cannot swap places */
    if (cvt->flags[i] & AT_BORDER || !isfinite(length))
        limit = 0;
    for (int c = 0; c < 3; c++)
        x[c] = (double)lloyd[c] + (length > limit ? d[c] * (limit / length) : d[c]);
    vor_to_floats(&cvt->mix[3 * i],
                  limit > 0 ? x
                            : (double[3]){(double)lloyd[0], (double)lloyd[1], (double)lloyd[2]});
}

static void mix_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct cvt *cvt = ctx;
    double longest = 0;

    for (size_t i = begin; i < end; i++) {
        mix_step(cvt, i);
        longest = fmax(longest, move2(cvt, cvt->mix, i));
    }
    cvt->sums[begin / VOR_SEEDS_BLOCK].max_move = sqrt(longest);
}

/* Replaces the centroids by the mix if that is at least as even. */
static vor_status accelerate(struct cvt *cvt, struct vor_uniformity *even, struct vor_error *err)
{
    const struct vor_seeds *seeds = cvt->seeds;
    struct vor_uniformity mixed;
    double max_move = 0;
    vor_status status = vor_anderson_push(&cvt->anderson, seeds->xyz, cvt->lloyd, cvt->run, err);

    if (status != VOR_OK || cvt->anderson.depth < 2)
        return status;
    status = vor_run_for(cvt->run, seeds->n, VOR_SEEDS_BLOCK, mix_block, cvt, err);
    if (status != VOR_OK)
        return status;
    for (size_t b = 0; b < cvt->blocks; b++)
        max_move = fmax(max_move, cvt->sums[b].max_move);
    status = vor_seeds_uniformity(&mixed, cvt->stage.nearest, seeds, cvt->mix, cvt->run, err);
    if (status != VOR_OK || !(mixed.delta <= even->delta))
        return status;
    memcpy(cvt->lloyd, cvt->mix, 3 * seeds->n * sizeof *cvt->mix);
    cvt->total.max_move = max_move;
    *even = mixed;
    return VOR_OK;
}

/* One iteration of all seeds, in seeds->xyz. */
static vor_status iterate(struct cvt *cvt, struct vor_error *err)
{
    struct vor_seeds *seeds = cvt->seeds;
    struct block_sums *total = &cvt->total;
    struct vor_uniformity even;
    vor_status status = vor_seeds_index(seeds, cvt->run, err);

    VOR_THEN(status, vor_run_for(cvt->run, seeds->n, VOR_SEEDS_BLOCK, lloyd_block, cvt, err));
    if (status != VOR_OK)
        return status;
    memset(total, 0, sizeof *total);
    for (size_t b = 0; b < cvt->blocks; b++) {
        total->area += cvt->sums[b].area;
        total->even += cvt->sums[b].even;
        total->energy += cvt->sums[b].energy;
        total->max_move = fmax(total->max_move, cvt->sums[b].max_move);
        total->held += cvt->sums[b].held;
        total->plane += cvt->sums[b].plane;
        total->left += cvt->sums[b].left;
    }
    status = vor_seeds_uniformity(&even, cvt->stage.nearest, seeds, cvt->lloyd, cvt->run, err);
    if (status == VOR_OK && cvt->anderson.length > 0)
        status = accelerate(cvt, &even, err);
    if (status != VOR_OK)
        return status;
    memcpy(seeds->xyz, cvt->lloyd, 3 * seeds->n * sizeof *seeds->xyz);
    vor_stage_note(&cvt->stage, &even);
    return VOR_OK;
}

/* Whether delta has fallen too little over the last window to go on. */
static int plateau(struct cvt *cvt)
{
    uint32_t done = cvt->stage.record.step;
    double *slot = &cvt->past[done % PLATEAU_WINDOW], before = *slot;

    *slot = cvt->stage.best.delta;
    return done > PLATEAU_WINDOW && *slot > PLATEAU_GAIN * before;
}

/* Ends the iterations on a plateau, unless the request gives their number. Returns whether they end
 * now; else, at a plateau, only those on the whole of the input follow. */
static int ends_on_plateau(struct vor_stage *stage)
{
    struct cvt *cvt = stage->of;
    uint32_t last = stage->record.step + on_whole(cvt);

    if (cvt->level || vor_spec_given(cvt->spec, VOR_PARAM_ITERATIONS) || !plateau(cvt))
        return 0;
    cvt->level = 1;
    if (vor_seeds_on_whole(cvt->seeds) || polish_follows(cvt))
        return 1;
    stage->record.of = last < stage->record.of ? last : stage->record.of;
    return 0;
}

/* One iteration; before those on the whole of the input, moves the seeds there. The most even
 * iterate before that no longer counts; whether holes are kept open is decided after the iterations
 * (vor_attach). */
static vor_status step(struct vor_stage *stage, struct vor_error *err)
{
    struct cvt *cvt = stage->of;
    const struct vor_seeds *seeds = cvt->seeds;
    const struct block_sums *total = &cvt->total;
    struct vor_outcome *told = stage->told;
    struct vor_record *record = &stage->record;
    double unit = stage->domain->unit;
    vor_status status = VOR_OK;

    if (!vor_seeds_on_whole(seeds) &&
        (vor_stage_is_enough(stage) ||
         (!polish_follows(cvt) && record->step + on_whole(cvt) >= record->of))) {
        stage->unfinished = 0;
        status = vor_attach_to_whole(cvt->seeds, 0, err);
        VOR_THEN(status, vor_stage_restart(stage, err));
    }
    VOR_THEN(status, iterate(cvt, err));
    if (status != VOR_OK)
        return status;
    record->energy = total->energy * unit * unit * unit * unit;
    record->max_move = total->max_move * unit;
    record->held = told->held = total->held;
    told->fallback_plane = total->plane;
    told->fallback_left = total->left;
    told->area = total->area;
    told->area_even = total->even;
    stage->moved = total->max_move / sqrt(seeds->area / (VOR_HEXAGON_HEIGHT * (double)seeds->n));
    return VOR_OK;
}

vor_status vor_lloyd_run(struct vor_seeds *seeds, struct vor_outcome *told,
                         const struct vor_spec *spec, const struct vor_run *run,
                         struct vor_error *err)
{
    struct cvt cvt = {.seeds = seeds, .spec = spec, .run = run};
    vor_status status;

    cvt.stage = (struct vor_stage){.spec = spec,
                                   .run = run,
                                   .told = told,
                                   .record = {.stage = VOR_RUN_STAGE_ITERATE,
                                              .of = vor_spec_iterations(spec),
                                              .ahead = (uint32_t)spec->value[VOR_PARAM_POLISH]},
                                   .of = &cvt,
                                   .step = step,
                                   .ends = ends_on_plateau,
                                   .share = polish_follows(&cvt) ? VOR_STAGE_SHARE : 1,
                                   .unfinished = !vor_seeds_on_whole(seeds)};
    status = alloc_cvt(&cvt, err);
    cvt.stage.saves = cvt.anderson.length == 0;
    cvt.stage.part[0] =
        (struct vor_part){cvt.step, cvt.step != NULL ? 3 * seeds->n * sizeof *cvt.step : 0};
    cvt.stage.part[1] = (struct vor_part){cvt.flags, seeds->n};
    cvt.stage.part[2] = (struct vor_part){cvt.past, sizeof cvt.past};
    cvt.stage.part[3] = (struct vor_part){&cvt.level, sizeof cvt.level};
    VOR_THEN(status, vor_stage_of_seeds(&cvt.stage, seeds, err));
    VOR_THEN(status, vor_stage_run(&cvt.stage, err));
    for (size_t i = 0; status == VOR_OK && i < seeds->n; i++)
        told->held_ever += (cvt.flags[i] & HELD_EVER) != 0;
    if (cvt.level && told->stopped == VOR_STOPPED_ITERATIONS)
        told->stopped = VOR_STOPPED_PLATEAU;
    free_cvt(&cvt);
    return status;
}
