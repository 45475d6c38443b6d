#include "core/cvt/frozen.h"

#include "core/base/linalg.h"

#include <string.h>

vor_status vor_frozen_init(struct vor_frozen *out, struct vor_seeds *seeds, int crossed,
                           struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct vor_frozen f = {.seeds = seeds};
    size_t n = seeds->n, cuts = n * VOR_POLYGON_MAX;

    f.bend = vor_malloc(memory, n, 2 * sizeof *f.bend);
    f.value = vor_malloc(memory, n, sizeof *f.value);
    f.cut = vor_malloc(memory, cuts, sizeof *f.cut);
    f.by = vor_malloc(memory, cuts, sizeof *f.by);
    f.cuts = vor_malloc(memory, n, 1);
    f.sums = vor_calloc(memory, vor_blocks_of(n, VOR_SEEDS_BLOCK), sizeof *f.sums);
    if (f.bend == NULL || f.value == NULL || f.cut == NULL || f.by == NULL || f.cuts == NULL ||
        f.sums == NULL || vor_planes_init(&f.planes, seeds, crossed, err) != VOR_OK) {
        vor_frozen_free(&f);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
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
    vor_planes_free(&f->planes);
    VOR_FREE_ALL(memory, f->sums, f->cuts, f->by, f->cut, f->value, f->bend);
    memset(f, 0, sizeof *f);
}

struct evaluation {
    struct vor_frozen *frozen;
    const double *y;
    double *gradient;
};

/* Energy of the cell of seed i. What it changes by moving others is kept in their planes. */
static void evaluate_seed(const struct evaluation *evaluation, size_t i)
{
    struct vor_frozen *f = evaluation->frozen;
    const struct vor_energy_plane *flat = &f->planes.plane[i].flat;
    const double *at = &evaluation->y[2 * i], *axes = f->planes.axes + 9 * i;
    double other[VOR_SEEDS_LISTED][3];
    struct vor_energy energy;
    struct vor_flat cell;

    vor_planes_localize(other, &f->planes, i);
    vor_energy_cut(&cell, flat, at, (const double(*)[3])other, f->planes.width);
    vor_energy_of(&energy, &cell, flat, at, (const double(*)[3])other);
    f->value[i] = energy.value;
    f->cuts[i] = (unsigned char)energy.count;
    for (int d = 0; d < 2; d++) {
        evaluation->gradient[2 * i + (size_t)d] = energy.own[d];
        if (!f->bent)
            f->bend[2 * i + (size_t)d] =
                energy.bend[d] + VOR_ROUNDED * (energy.bend[0] + energy.bend[1] + 1);
    }
    for (unsigned k = 0; k < energy.count; k++) {
        size_t at_k = i * VOR_POLYGON_MAX + k,
               j = f->planes.near[i * f->planes.width + energy.id[k]];
        const double *there = f->planes.axes + 9 * j;
        double way[3];

        for (int c = 0; c < 3; c++)
            way[c] = energy.by[k][0] * axes[c] + energy.by[k][1] * axes[3 + c] +
                     energy.by[k][2] * axes[6 + c];
        f->cut[at_k] = (uint32_t)j;
        f->by[at_k][0] = vor_dot(&there[0], way);
        f->by[at_k][1] = vor_dot(&there[3], way);
    }
}

static void place_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct evaluation *evaluation = ctx;

    for (size_t i = begin; i < end; i++)
        vor_planes_place(&evaluation->frozen->planes, evaluation->y, i);
}

static void evaluate_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct evaluation *evaluation = ctx;
    struct vor_frozen *f = evaluation->frozen;

    for (size_t i = begin; i < end; i++) {
        if (f->planes.plane[i].flat.radius > 0) {
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

/* Adds up values and gradients, in the order of the seeds. Fixed ones have none. */
static double add_up(const struct evaluation *evaluation)
{
    const struct vor_frozen *f = evaluation->frozen;
    double sum = 0;

    for (size_t i = 0; i < f->seeds->n; i++) {
        sum += f->value[i];
        for (size_t k = i * VOR_POLYGON_MAX; k < i * VOR_POLYGON_MAX + f->cuts[i]; k++) {
            size_t j = f->cut[k];

            evaluation->gradient[2 * j] += f->by[k][0];
            evaluation->gradient[2 * j + 1] += f->by[k][1];
        }
    }
    for (size_t d = 2 * vor_seeds_moving(f->seeds); d < 2 * f->seeds->n; d++)
        evaluation->gradient[d] = 0;
    return sum;
}

vor_status vor_frozen_at(void *ctx, const double *y, double *value, double *gradient,
                         struct vor_error *err)
{
    struct evaluation evaluation = {ctx, y, gradient};
    struct vor_frozen *f = ctx;
    size_t n = f->seeds->n;
    vor_status status = vor_run_for(f->run, n, VOR_SEEDS_BLOCK, place_block, &evaluation, err);

    VOR_THEN(status, vor_run_for(f->run, n, VOR_SEEDS_BLOCK, evaluate_block, &evaluation, err));
    if (status != VOR_OK)
        return status;
    f->bent = 1;
    *value = add_up(&evaluation);
    return VOR_OK;
}

vor_status vor_frozen_set(struct vor_frozen *frozen, unsigned power, double *y,
                          const struct vor_run *run, struct vor_error *err)
{
    frozen->run = run;
    frozen->bent = 0;
    return vor_planes_set(&frozen->planes, power, y, run, err);
}

void vor_frozen_shorten(void *ctx, const double *y, double *step)
{
    const struct vor_frozen *f = ctx;

    for (size_t i = 0; i < f->seeds->n; i++) {
        const double *at = &y[2 * i];
        double *by = &step[2 * i], reach = f->planes.plane[i].reach,
               a = by[0] * by[0] + by[1] * by[1];
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
    double other[VOR_SEEDS_LISTED][3], mean, apart;
    struct vor_energy_shape shape;
    struct vor_flat cell;

    f->value[i] = 1;
    vor_planes_localize(other, &f->planes, i);
    vor_energy_cut(&cell, &f->planes.plane[i].flat, at, (const double(*)[3])other, f->planes.width);
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
        xyz[c] = (float)(f->planes.spacing * f->planes.place[3 * i + c]);
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
    vor_to_floats(xyz, x);
    sums->moved = fmax(sums->moved, sqrt(vor_distance2f(from, xyz)));
}

static void take_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct take *take = ctx;
    struct vor_frozen *f = take->frozen;
    struct vor_frozen_sums sums = {0};

    for (size_t i = begin; i < end; i++) {
        sum_cell(take, &sums, i);
        if (i < vor_seeds_moving(f->seeds))
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

    VOR_THEN(status, vor_run_for(frozen->run, n, VOR_SEEDS_BLOCK, take_block, &take, err));
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
