#include "core/seeds/repel.h"

#include "core/base/linalg.h"
#include "core/geom/boundary.h"
#include "core/geom/glide.h"
#include "core/seeds/area.h"
#include "core/seeds/attach.h"
#include "core/seeds/checkpoint.h"
#include "core/seeds/forces.h"
#include "core/seeds/former.h"
#include "core/seeds/gaps.h"
#include "core/seeds/leash.h"
#include "core/seeds/stage.h"
#include "core/seeds/uniformity.h"

#include <string.h>

/* Figures "at a / b / c" belong to the chosen value b, a lower a and a higher c: delta (spread 3 %
 * from seed to seed), or six, the share of points with six neighbours (spread 1 %), or the largest
 * distance to the true surface over its diagonal (spread 10 %), of inputs in geom/boundary.h. */

enum {
    /* From this S on the force extends to VOR_HARD_REACH. At 5 / 7 / 14 only searches change: on
     * autzen 191 / 198 / 214 thousand. */
    HARDER = VOR_REPEL_HARD / 2,
    /* Steps from one look for gaps to the next, for even distances. At 1 / 3 / 6: CPU of autzen
     * 2.0 / 1.7 / 1.3 s, searches 245 / 198 / 185 thousand, delta the same. */
    CELLS_EVEN = 3,
    /* The same around a point with no gap near, where steps are short, and for triangles. At 3 / 6
     * / 12 only triangles change: on autzen 9.8 / 10.6 / 10.9 a cell. A multiple of those of an
     * aim. */
    QUIET_SHORT = 2 * CELLS_EVEN,
    /* The same around a point with no gap near, for even distances. At 6 / 12: CPU of igea to
     * 20,000 1.97 / 1.90 s; gap of the sphere 0.705 / 0.720 (spread 0.02), of igea the same, delta
     * and six too. Before the last FRESH also from one look to the next at whether input is near a
     * point that it surrounds. At 3 / 12, igea's vertices to 20,000, 4 seeds: delta 0.0164 / 0.0167
     * (spread 0.0006), CPU 1.99 / 1.57 s; at 12 to the end 0.0174, as the last look moves more. */
    QUIET_EVEN = 2 * QUIET_SHORT,
    /* Last steps, on the whole of a thinned input. At 20 / 40 / 80, armadillo, 300,000 to 4,000:
     * rms distance to the true surface 0.56e-4 / 0.58e-4 / 0.59e-4, six 0.753 / 0.735 / 0.712, CPU
     * 0.9 / 1.1 / 1.2 s. */
    ON_WHOLE = 40,
    /* Last steps, on surfaces that are fitted again sooner (SLACK_FRESH), and measured one by one.
     * At 8 / 16 / 32: rms distance on fandisk 6.0e-4 / 5.7e-4 / 5.7e-4. */
    FRESH = 16,
    /* Steps from one measurement of delta to the next, before the last FRESH. 3 and 10 move no
     * figure beyond the spread; a measurement costs a pass over the lists. */
    EVEN_EVERY = 5,
    /* Steps from one record for the watch to the next. */
    RECORD_EVERY = 10
};

/* Spacings: nearer pairs, which two steps take apart, part along the surface, and by a force of
 * that length. It matters where points coincide; half and double move no figure. */
#define OVERLAP (2 * VOR_REPEL_STEP_MAX)
/* VOR_SEEDS_SLACK in the last FRESH steps. Half and double move no figure beyond the spread. */
#define SLACK_FRESH OVERLAP
/* With a density: neighbours are looked for so much farther than the force extends by the seed's
 * own spacing. Where that grows by the usual 0.2 of the way, one 1.5 spacings away has a spacing
 * larger by less than that. */
#define GROWTH 1.25

struct aim {
    unsigned hard;     /* S at the last step */
    unsigned cells;    /* steps from one look for gaps to the next */
    unsigned quiet;    /* the same around a point with no gap near: a multiple */
    double gain;       /* step over the sum of forces, times 2 S; 0: vor_repel_pace_at */
    double momentum;   /* share of the last step that is added to the next */
    double soft_reach; /* spacings that soft repulsion extends to */
};

/* Even distances to the nearest point. soft_reach at 1.5 / 2 / 2.5: only the largest distance on
 * fandisk changes, 5.1e-3 / 4.5e-3 / 4.5e-3. */
#define REACH_EVEN 2.0
static const struct aim even_distances = {VOR_REPEL_HARD, CELLS_EVEN, QUIET_EVEN, 0, 0, REACH_EVEN};

/* The same by short steps, where long ones do harm. Where nothing holds points at the border they
 * carry them out: a saddle with a hole to 400 points, rms distance to it over its diagonal 4.4e-4
 * by short and 1.4e-2 by long steps. Where the input has sheets they carry some from one to
 * another: of two wavy sheets (tests/property/shapes) 0 and 1 points lie between them. */
static const struct aim short_steps = {VOR_REPEL_HARD, CELLS_EVEN, QUIET_SHORT,
                                       VOR_REPEL_GAIN, 0.7,        REACH_EVEN};

/* Six neighbours around each point, for triangles; meshes move the points once more, so that even
 * distances are lost anyway. Mean quality of triangles on igea, 20,000 points, and fandisk, 10,000,
 * 120 steps, two seeds. hard at 6 / 8 / 12: 0.9688 / 0.9688 / 0.9672, 0.9637 / 0.9641 / 0.9621.
 * gain at 0.2 / 0.4 / 0.8: 0.9641 / 0.9690 / 0.9539, 0.9565 / 0.9640 / 0.9475. momentum at 0.8 /
 * 0.9 / 0.95: 0.9660 / 0.9690 / 0.9709, 0.9621 / 0.9640 / 0.9643, its lowest on igea 0.75 / 0.76 /
 * 0.71. cells at 3 / 6 / 12: 0.9689 / 0.9690 / 0.9691, CPU s 3.15 / 3.09 / 2.90. soft_reach at 1.5
 * / 2: 0.9690 / 0.9686, CPU s 3.09 / 3.21. All as for even distances, 180 steps: 0.9580, 0.9521.
 * Not where the input has sheets: longer steps lead more points onto the other one (two wavy
 * sheets, triangles that join them: 10 / 23). Nor with a metric: mean distance of fandisk from its
 * anisotropic mesh of 5,000 points 1.70e-4 / 1.95e-4 of the diagonal. */
static const struct aim six_around = {
    8, QUIET_SHORT, QUIET_SHORT, 0.4, VOR_REPEL_MOMENTUM_FIRST, VOR_HARD_REACH};

struct polish {
    struct vor_seeds *seeds;
    const struct aim *aim;
    struct vor_stage stage;
    float *at;            /* n x 4, as forces.h has it */
    float *next;          /* n x 3 */
    float *step;          /* n x 3: the last one of each point */
    double h;             /* mean spacing */
    struct vor_gaps gaps; /* between points */
    struct vor_repel_pace pace;
    struct vor_leash leash;
    struct vor_recall recall; /* of last fits */
    struct vor_forces forces; /* of the step, if lists hold the points around a seed */
    int looks;                /* gaps next to a point inside are looked for in each step */
    int covers;               /* this step leads to the centroids of cells */
};

/* The spacing that seed i is to have, when the mean is h: with a density, h is the mean of what an
 * even spread would have. */
static double spacing_of(const struct polish *polish, size_t i)
{
    return polish->h * vor_wanted_at(&polish->seeds->wanted, i);
}

/* The vector that seed i moves along to get away from seed j, which is `distance` away. Where they
 * nearly coincide, their offset has neither a useful direction nor a useful length: then it is a
 * vector of OVERLAP spacings along the surface. */
static void away(const struct polish *polish, const struct vor_scratch *scratch, size_t i, size_t j,
                 double distance, double out[3])
{
    const struct vor_surface *surface = &scratch->here.surface;
    const float *a = &polish->seeds->xyz[3 * i], *b = &polish->seeds->xyz[3 * j];
    double overlap = OVERLAP * spacing_of(polish, i), side[2], length, d[3];

    for (size_t c = 0; c < 3; c++)
        out[c] = d[c] = (double)a[c] - (double)b[c];
    if (distance > overlap)
        return;
    side[0] = vor_dot(surface->axis[0], d);
    side[1] = vor_dot(surface->axis[1], d);
    length = sqrt(side[0] * side[0] + side[1] * side[1]);
    if (!(length > 0)) {
        vor_seeds_part(j, i, 1, side);
        length = sqrt(side[0] * side[0] + side[1] * side[1]);
    }
    for (int c = 0; c < 3; c++)
        out[c] = overlap / length * (side[0] * surface->axis[0][c] + side[1] * surface->axis[1][c]);
}

/* How far repulsion reaches in this step, in spacings: with a metric not beyond what lists hold
 * (seeds/stretched.c). */
static double force_reach(const struct polish *polish)
{
    return polish->pace.power < HARDER && !vor_stretched_are(&polish->seeds->stretched)
               ? polish->aim->soft_reach
               : VOR_HARD_REACH;
}

/* Sums the forces of the crowd on seed i. With a density, a pair has the larger spacing of both:
 * the nearest neighbour of a point lies where the spacing falls, so the point gets the distance
 * that is wanted where it is itself. With the mean / the larger, armadillo, 1,000,000 to 20,000, by
 * curvature: delta 0.025 / 0.020, slope of log spacing over log density -0.227 / -0.242. */
static void repulsion(const struct polish *polish, const struct vor_scratch *scratch, size_t i,
                      double force[3])
{
    const struct vor_crowd *crowd = &scratch->crowd;
    double h2 = polish->h * polish->h, scale = polish->pace.gain / (2 * polish->pace.power);
    double reach = force_reach(polish), own = vor_wanted_at(&polish->seeds->wanted, i);
    const float *wanted = polish->seeds->wanted.value;

    force[0] = force[1] = force[2] = 0;
    for (unsigned j = 0; j < crowd->count; j++) {
        double d2 = (double)crowd->distance2[j], most = (double)polish->forces.most, weight, d[3];

        if (wanted != NULL) {
            double h = polish->h * fmax(own, (double)wanted[crowd->index[j]]);

            h2 = h * h;
        }
        if (d2 > reach * reach * h2)
            continue;
        away(polish, scratch, i, crowd->index[j], sqrt(d2), d);
        weight = most;
        if (most * d2 > h2)
            weight = fmin(vor_power(h2 / d2, polish->pace.power), most);
        for (int c = 0; c < 3; c++)
            force[c] += scale * weight * d[c];
    }
}

/* How far the crowd of seed i has to reach for its forces. */
static double crowd_reach(const struct polish *polish, size_t i)
{
    double grows = polish->seeds->wanted.value != NULL ? GROWTH : 1;

    return grows * force_reach(polish) * spacing_of(polish, i);
}

/* Sums the forces on seed i of its list, if that holds all points that are near, and none of them
 * coincides with it. Returns whether it did. */
static int sum_forces(const struct polish *polish, size_t i, double force[3])
{
    const struct vor_seeds *seeds = polish->seeds;
    double scale = polish->pace.gain / (2 * polish->pace.power);
    unsigned listed = seeds->point_lists.listed;
    const uint32_t *list;
    float sum[3];

    if (vor_stretched_are(&seeds->stretched) || listed % VOR_FORCES_BATCH > 0)
        return 0;
    list = vor_point_lists_all(&seeds->point_lists, &seeds->view, i, crowd_reach(polish, i));
    if (list == NULL || !vor_forces_sum(sum, &polish->forces, polish->at, i, list, listed))
        return 0;
    for (int c = 0; c < 3; c++)
        force[c] = scale * (double)sum[c];
    return 1;
}

/* The way of a seed to the centroid of its cell; none where that has no area. */
static int towards_centroid(const struct polish *polish, const struct vor_scratch *scratch,
                            size_t i, double way[3])
{
    const struct vor_surface *surface = &scratch->here.surface;
    struct vor_moments moments;

    if (!vor_area_moments(&moments, polish->seeds, scratch, i))
        return 0;
    for (int c = 0; c < 3; c++) {
        way[c] = 0;
        for (int a = 0; a < 3; a++)
            way[c] += (moments.centroid[a] - scratch->cell.seed[a]) * surface->axis[a][c];
    }
    return 1;
}

/* Reduces v to its tangential part, and at the border to what does not lead out. */
static void keep_on_surface(const struct polish *polish, const struct vor_scratch *scratch,
                            double h, const double x[3], double v[3])
{
    const struct vor_surface *surface = &scratch->here.surface;
    double local[3], normal[3], side[2], out[3];

    vor_surface_to_local(&scratch->onto, x, local);
    vor_surface_normal(&scratch->onto, local, normal);
    vor_remove_along(v, normal, 0);
    if (scratch->interior || !polish->seeds->policy.keep_border)
        return;
    vor_surface_to_local(surface, x, local);
    if (vor_boundary_room(surface, scratch->here.near, scratch->here.k, local, h, side) >=
        VOR_EDGE_EVENING * h)
        return;
    for (int c = 0; c < 3; c++)
        out[c] = side[0] * surface->axis[0][c] + side[1] * surface->axis[1][c];
    vor_remove_along(v, out, 1);
}

/* Whether a seed that moves from x to y leaves the input, or moves farther away from it. */
static int leaves_input(const struct vor_seeds *seeds, const struct vor_scratch *scratch,
                        const double x[3], const double y[3])
{
    const struct vor_place *here = &scratch->here;
    struct vor_border border = {&here->surface, here->near, here->k,
                                fmin(here->surface.spacing, seeds->domain->sparse)};

    return !scratch->interior && seeds->policy.keep_border &&
           vor_boundary_leaves(&border, VOR_OUTSIDE_EVENING, x, y);
}

static void step_to(struct polish *polish, size_t i, double y[3])
{
    if (polish->stage.record.step + FRESH < polish->stage.record.of) /* then they even out */
        vor_leash_hold(&polish->leash, i, y);
    for (size_t c = 0; c < 3; c++) {
        polish->next[3 * i + c] = (float)y[c];
        polish->step[3 * i + c] = (float)(y[c] - (double)polish->seeds->xyz[3 * i + c]);
    }
}

/* Adds to the forces on seed i what else moves it. */
static void add_pull(const struct polish *polish, size_t i, double v[3])
{
    for (size_t c = 0; c < 3; c++)
        v[c] += (double)polish->gaps.pull[3 * i + c] +
                polish->pace.momentum * (double)polish->step[3 * i + c];
}

/* Moves seed i by v, along its surface and not out of the input. */
static void move(struct polish *polish, struct vor_scratch *scratch, size_t i, double v[3])
{
    const struct vor_seeds *seeds = polish->seeds;
    double x[3] = {0}, y[3]; /* clang-analyzer cannot see that seeds->n > i */
    double foot[3], out[3], length, h = spacing_of(polish, i), limit = VOR_REPEL_STEP_MAX * h;

    vor_seeds_position(seeds, i, x);
    add_pull(polish, i, v);
    keep_on_surface(polish, scratch, h, x, v);
    length = sqrt(vor_stretched_length2(&seeds->stretched, i, i, v));
    for (int c = 0; c < 3; c++) {
        v[c] = length > limit ? v[c] * (limit / length) : v[c];
        y[c] = x[c] + v[c];
    }
    vor_surface_put(&scratch->onto, y);
    if (leaves_input(seeds, scratch, x, y)) {
        (void)vor_boundary_foot(scratch->here.near, scratch->here.k, x, foot, out);
        vor_remove_along(v, out, 1);
        for (int c = 0; c < 3; c++)
            y[c] = x[c] + v[c];
        vor_surface_put(&scratch->onto, y);
    }
    if (!scratch->interior && polish->recall.keep_holes && vor_seeds_hold(seeds, scratch, i, y))
        vor_surface_put(&scratch->onto, y);
    if (!scratch->interior && seeds->policy.keep_border)
        (void)vor_attach_near(seeds, scratch, y);
    step_to(polish, i, y);
}

/* Moves seeds as move() does ones that are far from where the input ends. */
static void glide(struct polish *polish, struct vor_glide *far)
{
    vor_glide_go(far);
    for (unsigned j = 0; j < far->count; j++)
        step_to(polish, far->i[j], far->x[j]);
    far->count = 0;
}

/* Whether a gap next to seed i is looked for. */
static int is_asked(const struct polish *polish, size_t i)
{
    unsigned each = polish->aim->cells;

    if (polish->gaps.quiet[i])
        each = polish->aim->quiet;
    else if (polish->looks && polish->seeds->last_fit[i].interior)
        each = 1;
    return polish->covers || polish->stage.record.step % each == 0;
}

/* Mostly the last fit serves, the list has all that is near, and no gap is looked for. */
static void move_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct polish *polish = ctx;
    struct vor_seeds *seeds = polish->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    struct vor_glide far = {.count = 0};
    double force[VOR_SEEDS_BLOCK][3] = {{0}};
    int sums[VOR_SEEDS_BLOCK] = {0};
    uint32_t who[VOR_SEEDS_BLOCK] = {0};
    size_t count = 0;

    for (size_t i = begin; i < end; i++) {
        sums[i - begin] = sum_forces(polish, i, force[i - begin]);
        if (is_asked(polish, i))
            who[count++] = (uint32_t)i;
    }
    vor_seeds_crowd_ahead(seeds, scratch, who, count);
    for (size_t i = begin; i < end; i++) {
        const struct vor_surface *last = vor_seeds_last(seeds, i, &polish->recall);
        int cell = is_asked(polish, i), summed = sums[i - begin];
        double *v = force[i - begin];

        if (summed && last != NULL && !cell) {
            add_pull(polish, i, v);
            if (vor_glide_add(&far, last, i, VOR_REPEL_STEP_MAX * spacing_of(polish, i),
                              &seeds->xyz[3 * i], v))
                glide(polish, &far);
            continue;
        }
        memcpy(&polish->next[3 * i], &seeds->xyz[3 * i], 3 * sizeof(float));
        if (vor_seeds_recall(seeds, scratch, i, &polish->recall) == VOR_SURFACE_NONE)
            continue;
        if (cell) {
            vor_seeds_crowd(seeds, scratch, i);
            vor_seeds_clip(seeds, scratch, i, 0);
            vor_gaps_find(&polish->gaps, seeds, scratch, i);
        } else if (!summed)
            vor_seeds_within(seeds, scratch, i, crowd_reach(polish, i));
        vor_stretched_distances(&scratch->crowd, &seeds->stretched, seeds->xyz, i);
        if (!(polish->covers && towards_centroid(polish, scratch, i, v)) && !summed)
            repulsion(polish, scratch, i, v);
        move(polish, scratch, i, v);
    }
    glide(polish, &far);
}

static void place_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct polish *polish = ctx;
    const struct vor_seeds *seeds = polish->seeds;

    for (size_t i = begin; i < end; i++) {
        memcpy(&polish->at[4 * i], &seeds->xyz[3 * i], 3 * sizeof(float));
        polish->at[4 * i + 3] = (float)vor_wanted_at(&seeds->wanted, i);
    }
}

static vor_status measure(struct vor_stage *stage, struct vor_error *err)
{
    const struct polish *polish = stage->of;
    struct vor_uniformity even;
    vor_status status = vor_seeds_uniformity(&even, stage->nearest, stage->seeds, stage->xyz,
                                             &stage->seeds->run, err);

    if (status != VOR_OK)
        return status;
    vor_stage_note(stage, &even);
    vor_stage_note_move(stage, polish->step);
    return VOR_OK;
}

/* The pace of a step: after a warm start nearer to that of the last one, which keeps points in
 * their places. 20,000 points at rest with noise of 0.2 spacings, 50 steps: a point moves by 0.16 /
 * 0.09 spacings from frame to frame at a coherence of 0 / 1, delta 0.018 each. */
static struct vor_repel_pace pace_at(const struct polish *polish, unsigned done, unsigned steps)
{
    unsigned hard = polish->aim->hard;
    struct vor_repel_pace pace = vor_repel_pace_at(hard, done, steps);
    double coherence = polish->seeds->coherence;

    if (coherence > 0) {
        struct vor_repel_pace last = vor_repel_pace_at(hard, steps - 1, steps);

        pace.power += (unsigned)(coherence * (last.power - pace.power));
        pace.gain += coherence * (last.gain - pace.gain);
        pace.momentum += coherence * (last.momentum - pace.momentum);
        pace.pull = 1 - pace.momentum;
    }
    return pace;
}

/* One step of all seeds, in seeds->xyz. Before the last ones, moves the seeds to the whole of the
 * input. */
static vor_status step_once(struct vor_stage *stage, struct vor_error *err)
{
    struct polish *polish = stage->of;
    const struct aim *aim = polish->aim;
    struct vor_seeds *seeds = polish->seeds;
    size_t moving = vor_seeds_moving(seeds);
    vor_status status = VOR_OK;
    unsigned done = polish->stage.record.step, steps = polish->stage.record.of;
    int is_cover = stage->spec->value[VOR_PARAM_EVENNESS] == VOR_EVENNESS_COVER;
    int is_fresh = done + FRESH >= steps;

    if (!vor_seeds_on_whole(seeds) && (done + ON_WHOLE >= steps || vor_stage_is_enough(stage))) {
        stage->unfinished = 0;
        status = vor_attach_to_whole(seeds, polish->recall.keep_holes, err);
        if (status == VOR_OK)
            status = vor_stage_restart(stage, err);
    }
    polish->h = polish->stage.spacing;
    polish->pace = pace_at(polish, done, steps);
    if (aim->gain > 0) {
        polish->pace.gain = aim->gain;
        polish->pace.momentum = aim->momentum;
        polish->pace.pull = VOR_GAP_PULL;
    }
    /* In the last 16 / 40 of 100 steps, 4 seeds: gap of the sphere 0.695 / 0.691 spacings, delta of
     * fandisk 0.0219 / 0.0217, instructions of bunny + 3.0 / + 6.3 %. */
    polish->looks = aim == &even_distances && 5 * done >= 3 * steps;
    polish->covers = is_cover && 2 * done >= steps;
    polish->gaps.wide = VOR_GAP_WIDE;
    polish->gaps.share = polish->pace.pull;
    if (polish->covers) { /* half as far above a lattice's */
        polish->gaps.wide = VOR_GAP_WIDE / 2 + 0.25 / VOR_HEXAGON_HEIGHT;
        stage->keep_last = 1;
        memset(polish->gaps.quiet, 0, seeds->n);
    }
    polish->recall.slack = is_fresh ? SLACK_FRESH : VOR_SEEDS_SLACK;
    polish->recall.lazy =
        aim == &even_distances && done % (unsigned)(is_fresh ? CELLS_EVEN : QUIET_EVEN) > 0;
    polish->recall.refine = 2 * done >= steps && vor_domain_is_exact(polish->seeds->whole);
    polish->forces = (struct vor_forces){
        .h2 = (float)(polish->h * polish->h),
        .reach2 = (float)(force_reach(polish) * force_reach(polish)),
        .overlap2 = (float)(OVERLAP * OVERLAP),
        .most = vor_repel_most(stage->spec, polish->pace.power),
        .power = polish->pace.power,
    };
    VOR_THEN(status, vor_seeds_index(seeds, stage->run, err));
    if (status == VOR_OK)
        status = vor_run_for(stage->run, seeds->n, VOR_SEEDS_BLOCK, place_block, polish, err);
    if (status == VOR_OK)
        status = vor_run_for(stage->run, moving, vor_seeds_block(seeds->domain), move_block, polish,
                             err);
    if (status != VOR_OK)
        return status;
    memcpy(seeds->xyz, polish->next, 3 * moving * sizeof *seeds->xyz);
    return VOR_OK;
}

/* Evens the seeds out. keep_holes is as vor_attach found it, here or before a checkpoint. */
static vor_status repel(struct vor_seeds *seeds, struct vor_outcome *told, int *keep_holes,
                        const struct vor_spec *spec, const struct vor_run *run,
                        struct vor_error *err)
{
    int for_triangles = vor_process_takes(spec->process, VOR_PARAM_SOUP) &&
                        spec->value[VOR_PARAM_METRIC] == VOR_METRIC_ISOTROPIC &&
                        !seeds->whole->known.sheets;
    int by_short = !seeds->policy.keep_border || seeds->whole->known.sheets;
    double area = told->steps[VOR_RUN_STAGE_ITERATE] > 0 ? told->area_even : seeds->area;
    double cells = (double)seeds->n - (double)seeds->half / 2;
    size_t row = 3 * sizeof(float);
    struct polish polish = {.seeds = seeds,
                            .aim = for_triangles ? &six_around
                                   : by_short    ? &short_steps
                                                 : &even_distances,
                            .recall = {.keep_holes = *keep_holes},
                            .gaps = {.pitch = sqrt(area / (VOR_HEXAGON_HEIGHT * cells))}};
    struct vor_memory *memory = seeds->run.memory;
    int reached; /* what the request asked for, which nothing may spoil */
    vor_status status;

    if (vor_spec_polish(spec) == 0 || told->stopped == VOR_STOPPED_CALLER)
        return VOR_OK;
    polish.stage = (struct vor_stage){.spec = spec,
                                      .run = run,
                                      .told = told,
                                      .record = told->last,
                                      .of = &polish,
                                      .step = step_once,
                                      .measure = measure,
                                      .measure_every = EVEN_EVERY,
                                      .measure_last = FRESH,
                                      .tell_every = RECORD_EVERY,
                                      .share = 1,
                                      .follows = 1,
                                      .unfinished = !vor_seeds_on_whole(seeds),
                                      .saves = 1};
    polish.stage.record.stage = VOR_RUN_STAGE_POLISH;
    polish.stage.record.of = vor_spec_polish(spec);
    polish.stage.record.step = polish.stage.record.ahead = 0;
    polish.at = vor_malloc(memory, seeds->n, 4 * sizeof *polish.at);
    polish.next = vor_malloc(memory, seeds->n, row);
    polish.step = vor_calloc(memory, seeds->n, row);
    polish.gaps.pull = vor_calloc(memory, seeds->n, row);
    polish.gaps.quiet = vor_calloc(memory, seeds->n, 1);
    if (polish.at == NULL || polish.next == NULL || polish.step == NULL ||
        polish.gaps.pull == NULL || polish.gaps.quiet == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    else
        status = vor_stage_of_seeds(&polish.stage, seeds, err);
    VOR_THEN(status, vor_leash_make(&polish.leash, seeds, err));
    polish.stage.part[0] = (struct vor_part){polish.step, seeds->n * row};
    polish.stage.part[1] = (struct vor_part){polish.gaps.pull, seeds->n * row};
    polish.stage.part[2] = (struct vor_part){polish.gaps.quiet, seeds->n};
    polish.stage.part[3] = (struct vor_part){&polish.recall, sizeof polish.recall};
    polish.stage.part[4] = (struct vor_part){polish.leash.at, polish.leash.size};
    VOR_THEN(status, vor_stage_run(&polish.stage, err));
    reached = told->stopped == VOR_STOPPED_DELTA || told->stopped == VOR_STOPPED_ETA;
    if (status == VOR_OK && polish.aim == &even_distances && !polish.covers && !reached &&
        told->steps[VOR_RUN_STAGE_POLISH] > 0 && !vor_run_is_late(&seeds->run))
        status = vor_gaps_narrow(&polish.gaps, seeds, polish.next, &polish.recall, err);
    told->refined = polish.recall.refine;
    *keep_holes = polish.recall.keep_holes;
    vor_leash_free(&polish.leash, memory);
    VOR_FREE_ALL(memory, polish.gaps.quiet, polish.gaps.pull, polish.step, polish.next, polish.at);
    vor_stage_free(&polish.stage);
    return status;
}

vor_status vor_polish(struct vor_seeds *seeds, struct vor_outcome *told,
                      const struct vor_spec *spec, const struct vor_run *run, struct vor_error *err)
{
    double before = vor_run_clock(run);
    int keep_holes = 0;
    vor_status status = VOR_OK;

    if (vor_stage_was_late(told, spec, run))
        status = vor_attach_fast(seeds, err);
    else if (!vor_checkpoint_is(run)) /* of seeds that are attached */
        status = vor_attach(seeds, &keep_holes, err);
    VOR_THEN(status, repel(seeds, told, &keep_holes, spec, run, err));
    VOR_THEN(status, vor_attach_to_whole(seeds, keep_holes, err));
    if (status == VOR_OK && told->steps[VOR_RUN_STAGE_POLISH] > 0)
        status = vor_attach_last(seeds, err);
    VOR_THEN(status, vor_former_weigh(seeds, err));
    VOR_THEN(status, vor_attach_steep(seeds, err));
    if (status == VOR_OK)
        vor_attach_to_box(seeds);
    told->seconds[VOR_RUN_STAGE_POLISH] = vor_run_clock(run) - before;
    return status;
}
