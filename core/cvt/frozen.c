#include "core/cvt/frozen.h"

#include "core/base/linalg.h"
#include "core/knn/knn.h"

#include <string.h>

/* Over the mean distance to the six nearest, which is the radius of the paper's patch. */
#define PATCH 1.2
/* Likewise, of the way that a seed may go. */
#define REACH 0.4
/* Rounds of means of the crosses: the first time, when nothing is known, and later. */
enum { ROUNDS_FIRST = 40, ROUNDS = 4 };
/* Seeds around whose crosses count. */
enum { AROUND = 6 };
/* Of a spacing: how far apart seeds begin that share a place. */
#define APART 1e-3
/* Share of the largest second derivative of a cell that each is at least: of a cell with no area
 * there is none. */
#define BEND_MIN 1e-6

vor_status vor_frozen_init(struct vor_frozen *out, struct vor_seeds *seeds, int crossed,
                           struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct vor_frozen f = {.seeds = seeds, .crossed = crossed};
    size_t n = seeds->n, cuts = n * VOR_FROZEN_CUT;

    f.width = n > VOR_FROZEN_NEAR ? VOR_FROZEN_NEAR : (unsigned)n - 1;
    f.spacing = sqrt(seeds->area / (VOR_HEXAGON_HEIGHT * (double)n));
    f.plane = vor_calloc(memory, n, sizeof *f.plane);
    f.middle = vor_malloc(memory, n, 3 * sizeof *f.middle);
    f.axes = vor_malloc(memory, n, 9 * sizeof *f.axes);
    f.near = vor_malloc(memory, n, (f.width > 0 ? f.width : 1) * sizeof *f.near);
    f.bend = vor_malloc(memory, n, 2 * sizeof *f.bend);
    f.place = vor_malloc(memory, n, 3 * sizeof *f.place);
    f.value = vor_malloc(memory, n, sizeof *f.value);
    f.cut = vor_malloc(memory, cuts, sizeof *f.cut);
    f.by = vor_malloc(memory, cuts, sizeof *f.by);
    f.cuts = vor_malloc(memory, n, 1);
    f.sums = vor_calloc(memory, vor_blocks_of(n, VOR_SEEDS_BLOCK), sizeof *f.sums);
    if (f.plane == NULL || f.middle == NULL || f.axes == NULL || f.near == NULL || f.bend == NULL ||
        f.place == NULL || f.value == NULL || f.cut == NULL || f.by == NULL || f.cuts == NULL ||
        f.sums == NULL || vor_crosses_init(&f.crosses, n, memory, err) != VOR_OK) {
        vor_frozen_free(&f);
        return vor_fail(err, VOR_E_NOMEM, "the energy of %zu points", n);
    }
    *out = f;
    return VOR_OK;
}

void vor_frozen_free(struct vor_frozen *f)
{
    struct vor_memory *memory;

    if (f->seeds == NULL)
        return;
    memory = f->seeds->run.memory;
    vor_crosses_free(&f->crosses);
    vor_free(memory, f->sums);
    vor_free(memory, f->cuts);
    vor_free(memory, f->by);
    vor_free(memory, f->cut);
    vor_free(memory, f->value);
    vor_free(memory, f->place);
    vor_free(memory, f->bend);
    vor_free(memory, f->near);
    vor_free(memory, f->axes);
    vor_free(memory, f->middle);
    vor_free(memory, f->plane);
    memset(f, 0, sizeof *f);
}

/* --- what stands still ------------------------------------------------------------------------ */

/* What the tasks of a freeze share. */
struct freeze {
    struct vor_frozen *frozen;
    const struct vor_knn *knn;
    double *y;
};

/* The seeds nearest to seed i, without it; returns the distance to the nearest. *radius: mean
 * distance to the six nearest, normalised; with fewer seeds 2, which spans everything. */
static double find_near(const struct freeze *freeze, size_t i, double *radius)
{
    const struct vor_frozen *f = freeze->frozen;
    uint32_t index[VOR_FROZEN_NEAR + 1], *near = &f->near[i * f->width];
    float distance2[VOR_FROZEN_NEAR + 1];
    double sum = 0, first = 0;
    unsigned found = 0;

    vor_knn_search(freeze->knn, &f->seeds->xyz[3 * i], 1, f->width + 1, index, distance2);
    for (unsigned j = 0; j <= f->width && found < f->width; j++) {
        if (index[j] == i)
            continue;
        near[found] = index[j];
        first = found == 0 ? sqrt((double)distance2[j]) : first;
        sum += found < 6 ? sqrt((double)distance2[j]) : 0;
        found++;
    }
    *radius = found >= 6 ? sum / 6 : 2;
    return first;
}

/* Two tangents and the normal at a local point of the surface. */
static void set_axes(double axes[9], const struct vor_surface *surface, const double at[3])
{
    double side[3] = {0}, length;
    double *normal = &axes[6];

    vor_surface_normal(surface, at, normal);
    /* The tangent of the surface that is farther from its normal. */
    memcpy(side,
           surface->axis[fabs(vor_dot(surface->axis[0], normal)) <
                                 fabs(vor_dot(surface->axis[1], normal))
                             ? 0
                             : 1],
           sizeof side);
    vor_cross(&axes[3], normal, side);
    length = sqrt(vor_dot(&axes[3], &axes[3]));
    for (int c = 0; c < 3; c++)
        axes[3 + c] /= length;
    vor_cross(axes, &axes[3], normal);
}

/* Where the cell ends at the border of the input (rule 2 of geom/boundary.h). */
static void set_wall(struct vor_energy_plane *flat, const struct vor_frozen *f,
                     const struct vor_place *here, const double axes[9], const double at[3],
                     double radius)
{
    const struct vor_surface *surface = &here->surface;
    double side[2] = {0}, way[3];

    flat->wall[0] = flat->wall[1] = 0;
    flat->room = INFINITY;
    if (!f->seeds->policy.keep_border)
        return;
    flat->room = vor_boundary_room(surface, here->near, here->k, at, radius, side) / f->spacing;
    for (int c = 0; c < 3; c++)
        way[c] = side[0] * surface->axis[0][c] + side[1] * surface->axis[1][c];
    flat->wall[0] = vor_dot(&axes[0], way);
    flat->wall[1] = vor_dot(&axes[3], way);
}

/* Sets the cross of seed i, at x, by a quadric also where fits are planes. */
static void set_cross(struct vor_frozen *f, const struct vor_place *here, size_t i,
                      const double x[3])
{
    struct vor_surface bent = here->surface;
    double at[3];

    if (f->seeds->policy.planes)
        vor_surface_fit(&bent, here->near, here->k);
    vor_surface_to_local(&bent, x, at);
    vor_crosses_set(&f->crosses, i, &bent, here->k, at, &f->axes[9 * i], f->spacing);
}

/* Fits the surface of seed i and takes its plane there. */
static void freeze_seed(const struct freeze *freeze, struct vor_scratch *scratch, size_t i)
{
    struct vor_frozen *f = freeze->frozen;
    struct vor_frozen_plane *plane = &f->plane[i];
    double radius, x[3], at[3], *axes = &f->axes[9 * i];

    vor_seeds_position(f->seeds, i, x);
    for (size_t c = 0; c < 3; c++)
        f->middle[3 * i + c] = x[c] / f->spacing;
    freeze->y[2 * i] = freeze->y[2 * i + 1] = 0;
    memset(axes, 0, 9 * sizeof *axes);
    plane->flat.radius = plane->reach = 0;
    if (vor_seeds_fit(f->seeds, scratch, i) == VOR_SURFACE_NONE)
        return;
    if (!(find_near(freeze, i, &radius) > 0) && f->width > 0)
        vor_seeds_part(i, f->near[i * f->width], APART, &freeze->y[2 * i]);
    vor_surface_to_local(&scratch->here.surface, x, at);
    set_axes(axes, &scratch->here.surface, at);
    set_wall(&plane->flat, f, &scratch->here, axes, at, radius);
    plane->flat.power = f->power;
    plane->flat.factor[0] = plane->flat.factor[1] = 1;
    plane->flat.radius = PATCH * radius / f->spacing;
    plane->reach = REACH * radius / f->spacing;
    if (f->crossed)
        set_cross(f, &scratch->here, i, x);
}

static void freeze_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct freeze *freeze = ctx;

    for (size_t i = begin; i < end; i++)
        freeze_seed(freeze, &freeze->frozen->seeds->scratch[worker], i);
}

/* Turns the axes of all seeds to their crosses, and the walls with them. */
static void turn(struct vor_frozen *f)
{
    for (size_t i = 0; i < f->seeds->n; i++) {
        struct vor_energy_plane *flat = &f->plane[i].flat;
        double *axes = &f->axes[9 * i], way[3];

        if (!(flat->radius > 0))
            continue;
        for (int c = 0; c < 3; c++)
            way[c] = flat->wall[0] * axes[c] + flat->wall[1] * axes[3 + c];
        vor_crosses_turn(&f->crosses, i, axes);
        flat->wall[0] = vor_dot(&axes[0], way);
        flat->wall[1] = vor_dot(&axes[3], way);
    }
}

static void set_place(const struct vor_frozen *f, const double *y, size_t i)
{
    const double *axes = &f->axes[9 * i];

    for (size_t c = 0; c < 3; c++)
        f->place[3 * i + c] =
            f->middle[3 * i + c] + y[2 * i] * axes[c] + y[2 * i + 1] * axes[3 + c];
}

/* The seeds around seed i in the coordinates of its plane. */
static void localize(double (*other)[3], const struct vor_frozen *f, size_t i)
{
    const double *middle = &f->middle[3 * i], *axes = &f->axes[9 * i];

    for (unsigned k = 0; k < f->width; k++) {
        const double *x = &f->place[3 * (size_t)f->near[i * f->width + k]];
        double d[3] = {x[0] - middle[0], x[1] - middle[1], x[2] - middle[2]};

        for (int c = 0; c < 3; c++)
            other[k][c] = vor_dot(&axes[3 * c], d);
    }
}

/* The direction in which the patch of a cell was not cut; false where it was all around. */
static int open_way(double way[2], const struct vor_flat *cell)
{
    double length;

    way[0] = way[1] = 0;
    for (unsigned e = 0; e < cell->count; e++) {
        unsigned f = e + 1 < cell->count ? e + 1 : 0;

        if (cell->id[e] < VOR_FLAT_SIDE || cell->id[e] == VOR_ENERGY_WALL)
            continue;
        way[0] += cell->y[f] - cell->y[e]; /* across the side, as long as that */
        way[1] += cell->x[e] - cell->x[f];
    }
    length = sqrt(way[0] * way[0] + way[1] * way[1]);
    if (!(length > 0))
        return 0;
    way[0] /= length;
    way[1] /= length;
    return 1;
}

/* Where no other seed cuts the cell of seed i the input may end, farther from the seed than the
 * points that its surface was fitted to: the wall is where it ends as seen from there. */
static void find_end(const struct freeze *freeze, struct vor_scratch *scratch, size_t i)
{
    struct vor_frozen *f = freeze->frozen;
    struct vor_energy_plane *flat = &f->plane[i].flat;
    const struct vor_surface *surface = &f->seeds->last_fit[i].surface;
    const double *axes = &f->axes[9 * i];
    double other[VOR_FROZEN_NEAR][3], way[2], side[2], at[3], x[3], along[3], end, length;
    struct vor_flat cell;

    localize(other, f, i);
    vor_energy_cut(&cell, flat, &freeze->y[2 * i], (const double(*)[3])other, f->width);
    if (!open_way(way, &cell))
        return;
    for (size_t c = 0; c < 3; c++) {
        along[c] = way[0] * axes[c] + way[1] * axes[3 + c];
        x[c] = f->spacing * (f->middle[3 * i + c] + flat->radius * along[c]);
    }
    if (vor_seeds_fit_at(f->seeds, scratch, &scratch->there, x) == VOR_SURFACE_NONE)
        return;
    vor_seeds_position(f->seeds, i, x);
    vor_surface_to_local(surface, x, at);
    for (int d = 0; d < 2; d++)
        side[d] = vor_dot(surface->axis[d], along);
    length = sqrt(side[0] * side[0] + side[1] * side[1]);
    if (!(length > 0))
        return;
    side[0] /= length;
    side[1] /= length;
    end = vor_boundary_end(surface, at, side, &scratch->there.surface, scratch->there.near,
                           scratch->there.k);
    if (!(end / f->spacing < flat->room))
        return;
    flat->room = end / f->spacing;
    memcpy(flat->wall, way, sizeof way);
}

static void end_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct freeze *freeze = ctx;
    const struct vor_frozen *f = freeze->frozen;

    for (size_t i = begin; i < end; i++)
        if (f->plane[i].flat.radius > 0)
            find_end(freeze, &f->seeds->scratch[worker], i);
}

static vor_status take_planes(struct vor_frozen *f, double *y, struct vor_error *err)
{
    struct freeze freeze = {.frozen = f, .y = y};
    struct vor_knn *knn = NULL;
    size_t n = f->seeds->n;
    vor_status status = vor_knn_build(&knn, f->seeds->xyz, n, f->seeds->run.memory, err);

    if (status != VOR_OK)
        return status;
    freeze.knn = knn;
    status = vor_run_for(f->run, n, VOR_SEEDS_BLOCK, freeze_block, &freeze, err);
    vor_knn_free(knn);
    if (status == VOR_OK && f->crossed) {
        status = vor_crosses_smooth(&f->crosses, f->axes, f->near, f->width,
                                    f->width < AROUND ? f->width : AROUND,
                                    f->set == 0 ? ROUNDS_FIRST : ROUNDS, f->run, err);
        if (status == VOR_OK)
            turn(f);
    }
    if (status != VOR_OK || !f->seeds->policy.keep_border)
        return status;
    for (size_t i = 0; i < n; i++)
        set_place(f, y, i);
    return vor_run_for(f->run, n, VOR_SEEDS_BLOCK, end_block, &freeze, err);
}

/* --- the function ----------------------------------------------------------------------------- */

/* An evaluation. */
struct evaluation {
    struct vor_frozen *frozen;
    const double *y;
    double *gradient;
};

/* Energy of the cell of seed i. What it changes by moving others is kept in their planes. */
static void evaluate_seed(const struct evaluation *evaluation, size_t i)
{
    struct vor_frozen *f = evaluation->frozen;
    const struct vor_energy_plane *flat = &f->plane[i].flat;
    const double *at = &evaluation->y[2 * i], *axes = &f->axes[9 * i];
    double other[VOR_FROZEN_NEAR][3];
    struct vor_energy energy;
    struct vor_flat cell;
    unsigned kept;

    localize(other, f, i);
    vor_energy_cut(&cell, flat, at, (const double(*)[3])other, f->width);
    vor_energy_of(&energy, &cell, flat, at, (const double(*)[3])other);
    kept = energy.count < VOR_FROZEN_CUT ? energy.count : VOR_FROZEN_CUT;
    f->value[i] = energy.value;
    f->cuts[i] = (unsigned char)kept;
    for (int d = 0; d < 2; d++) {
        evaluation->gradient[2 * i + (size_t)d] = energy.own[d];
        if (!f->bent)
            f->bend[2 * i + (size_t)d] =
                energy.bend[d] + BEND_MIN * (energy.bend[0] + energy.bend[1] + 1);
    }
    for (unsigned k = 0; k < kept; k++) {
        size_t at_k = i * VOR_FROZEN_CUT + k, j = f->near[i * f->width + energy.id[k]];
        const double *there = &f->axes[9 * j];
        double way[3];

        for (int c = 0; c < 3; c++)
            way[c] = energy.by[k][0] * axes[c] + energy.by[k][1] * axes[3 + c] +
                     energy.by[k][2] * axes[6 + c];
        f->cut[at_k] = (uint32_t)j;
        f->by[at_k][0] = vor_dot(&there[0], way);
        f->by[at_k][1] = vor_dot(&there[3], way);
    }
}

static void place_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct evaluation *evaluation = ctx;

    (void)worker;
    for (size_t i = begin; i < end; i++)
        set_place(evaluation->frozen, evaluation->y, i);
}

static void evaluate_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct evaluation *evaluation = ctx;
    struct vor_frozen *f = evaluation->frozen;

    (void)worker;
    for (size_t i = begin; i < end; i++) {
        if (f->plane[i].flat.radius > 0) {
            evaluate_seed(evaluation, i);
            continue;
        }
        f->value[i] = 0;
        f->cuts[i] = 0;
        for (size_t d = 2 * i; d < 2 * i + 2; d++) {
            evaluation->gradient[d] = 0;
            f->bend[d] = 1;
        }
    }
}

/* Adds up values and gradients, in the order of the seeds. */
static double add_up(const struct evaluation *evaluation)
{
    const struct vor_frozen *f = evaluation->frozen;
    double sum = 0;

    for (size_t i = 0; i < f->seeds->n; i++) {
        sum += f->value[i];
        for (size_t k = i * VOR_FROZEN_CUT; k < i * VOR_FROZEN_CUT + f->cuts[i]; k++) {
            size_t j = f->cut[k];

            evaluation->gradient[2 * j] += f->by[k][0];
            evaluation->gradient[2 * j + 1] += f->by[k][1];
        }
    }
    return sum;
}

vor_status vor_frozen_at(void *ctx, const double *y, double *value, double *gradient,
                         struct vor_error *err)
{
    struct evaluation evaluation = {ctx, y, gradient};
    struct vor_frozen *f = ctx;
    size_t n = f->seeds->n;
    vor_status status = vor_run_for(f->run, n, VOR_SEEDS_BLOCK, place_block, &evaluation, err);

    if (status == VOR_OK)
        status = vor_run_for(f->run, n, VOR_SEEDS_BLOCK, evaluate_block, &evaluation, err);
    if (status != VOR_OK)
        return status;
    f->bent = 1;
    *value = add_up(&evaluation);
    return VOR_OK;
}

vor_status vor_frozen_set(struct vor_frozen *frozen, unsigned power, double *y,
                          const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    frozen->power = power;
    frozen->run = run;
    frozen->bent = 0;
    status = take_planes(frozen, y, err);
    frozen->set += status == VOR_OK;
    return status;
}

void vor_frozen_shorten(void *ctx, const double *y, double *step)
{
    const struct vor_frozen *f = ctx;

    for (size_t i = 0; i < f->seeds->n; i++) {
        const double *at = &y[2 * i];
        double *by = &step[2 * i], reach = f->plane[i].reach, a = by[0] * by[0] + by[1] * by[1];
        double b = at[0] * by[0] + at[1] * by[1], c = at[0] * at[0] + at[1] * at[1] - reach * reach;
        double most;

        if (!(a > 0) || a + 2 * b + c <= 0)
            continue;
        most = c < 0 ? (sqrt(b * b - a * c) - b) / a : 0; /* |at + most by| = reach */
        most = fmin(most, 1);
        by[0] *= most;
        by[1] *= most;
    }
}

/* --- back to the surface ---------------------------------------------------------------------- */

/* What the tasks of a take share. */
struct take {
    struct vor_frozen *frozen;
    unsigned char *held;
    const double *y;
};

/* Area, energy and aspect of the cell of seed i, before it moves. */
static void sum_cell(const struct take *take, struct vor_frozen_sums *sums, size_t i)
{
    struct vor_frozen *f = take->frozen;
    const double *at = &take->y[2 * i];
    double other[VOR_FROZEN_NEAR][3], mean, apart;
    struct vor_energy_shape shape;
    struct vor_flat cell;

    f->value[i] = 1;
    localize(other, f, i);
    vor_energy_cut(&cell, &f->plane[i].flat, at, (const double(*)[3])other, f->width);
    if (!vor_energy_shape_of(&shape, &cell, at))
        return;
    sums->area += shape.area;
    sums->energy += shape.energy;
    mean = (shape.moment[0] + shape.moment[2]) / 2;
    apart = (shape.moment[0] - shape.moment[2]) / 2;
    apart = sqrt(apart * apart + shape.moment[1] * shape.moment[1]);
    if (mean > apart)
        f->value[i] = sqrt((mean + apart) / (mean - apart));
}

/* Moves seed i to its place, onto the surface there and inside the input. */
static void take_seed(const struct take *take, struct vor_scratch *scratch,
                      struct vor_frozen_sums *sums, size_t i)
{
    struct vor_frozen *f = take->frozen;
    struct vor_seeds *seeds = f->seeds;
    float *xyz = &seeds->xyz[3 * i], from[3];
    struct vor_border border;
    enum vor_surface_kind kind;
    double x[3];

    memcpy(from, xyz, sizeof from);
    for (size_t c = 0; c < 3; c++)
        xyz[c] = (float)(f->spacing * f->place[3 * i + c]);
    kind = vor_seeds_fit(seeds, scratch, i);
    sums->plane += kind == VOR_SURFACE_PLANE && !seeds->policy.planes;
    sums->left += kind == VOR_SURFACE_NONE;
    take->held[i] &= (unsigned char)~VOR_FROZEN_HELD;
    if (kind == VOR_SURFACE_NONE) {
        memcpy(xyz, from, sizeof from);
        return;
    }
    vor_seeds_position(seeds, i, x);
    vor_surface_put(&scratch->here.surface, x);
    if (seeds->policy.keep_border) {
        vor_seeds_border(seeds, scratch, &scratch->here, &border, x);
        if (vor_boundary_restrict(&border, VOR_OUTSIDE_MOVING, x))
            take->held[i] |= VOR_FROZEN_HELD | VOR_FROZEN_HELD_EVER;
    }
    for (int c = 0; c < 3; c++)
        xyz[c] = (float)x[c];
    sums->moved = fmax(sums->moved, sqrt(vor_distance2f(from, xyz)));
}

static void take_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct take *take = ctx;
    struct vor_frozen *f = take->frozen;
    struct vor_frozen_sums sums = {0};

    for (size_t i = begin; i < end; i++) {
        sum_cell(take, &sums, i);
        take_seed(take, &f->seeds->scratch[worker], &sums, i);
        sums.held += take->held[i] & VOR_FROZEN_HELD;
    }
    f->sums[begin / VOR_SEEDS_BLOCK] = sums;
}

vor_status vor_frozen_take(struct vor_frozen *frozen, const double *y, unsigned char *held,
                           struct vor_frozen_sums *sums, struct vor_error *err)
{
    struct take take = {frozen, held, y};
    struct evaluation places = {frozen, y, NULL};
    size_t n = frozen->seeds->n;
    vor_status status = vor_run_for(frozen->run, n, VOR_SEEDS_BLOCK, place_block, &places, err);

    if (status == VOR_OK)
        status = vor_run_for(frozen->run, n, VOR_SEEDS_BLOCK, take_block, &take, err);
    if (status != VOR_OK)
        return status;
    memset(sums, 0, sizeof *sums);
    for (size_t b = 0; b < vor_blocks_of(n, VOR_SEEDS_BLOCK); b++) {
        const struct vor_frozen_sums *part = &frozen->sums[b];

        sums->area += part->area;
        sums->energy += part->energy;
        sums->moved = fmax(sums->moved, part->moved);
        sums->plane += part->plane;
        sums->left += part->left;
        sums->held += part->held;
    }
    return VOR_OK;
}
