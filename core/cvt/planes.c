#include "core/cvt/planes.h"

#include "core/base/linalg.h"
#include "core/cvt/lloyd.h"
#include "core/geom/patch.h"
#include "core/knn/knn.h"

#include <string.h>

/* Figures are the four-fold order psi4 (tests/paper/chen2018_lp_test.c) with p of 8 on a tube,
 * 20,000 points to 2,000, two seeds, and on the fillets of a rounded cube, 40,000 to 3,000. Other
 * seeds move them by 0.01. */

/* Over the mean distance to the six nearest, which is the radius of the paper's patch. At 0.8 / 0.9
 * / 1.2: tube 0.89 / 0.89 / 0.85, fillets 0.93 / 0.92 / 0.94, delta of the tube 0.052 / 0.066 /
 * 0.090: wide patches reach beyond its ends. */
#define PATCH 0.9
/* Spacings that count as that distance at most: seeds beyond a border that is free would go the
 * farther, the farther they are. With / without, armadillo_half to 5,000: 28 and 1,660 spacings off
 * (Lloyd's method 33). */
#define ALONE 2.0
/* Times the curvature: a plane is no wider where the surface bends within less, as at the tip of a
 * horn, where seeds would crowd. At 1 / 1.4 / 2 / unbounded, p of 8: delta of cow, 110,000 to
 * 5,000, 0.111 / 0.099 / 0.096 / 0.124, of armadillo_half 0.110 / 0.098 / 0.093 / 0.129, its
 * smallest distance over the mean 0.27 / 0.30 / 0.16 / 0.01. */
#define BENT 1.4

vor_status vor_planes_init(struct vor_planes *out, struct vor_seeds *seeds, int crossed,
                           struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct vor_planes p = {.seeds = seeds, .crossed = crossed};
    size_t n = seeds->n;

    p.width = n > VOR_SEEDS_LISTED ? VOR_SEEDS_LISTED : (unsigned)n - 1;
    p.spacing = sqrt(seeds->area / (VOR_HEXAGON_HEIGHT * (double)n));
    p.plane = vor_calloc(memory, n, sizeof *p.plane);
    p.middle = vor_malloc(memory, n, 3 * sizeof *p.middle);
    p.axes = vor_malloc(memory, n, 9 * sizeof *p.axes);
    p.near = vor_malloc(memory, n, (p.width > 0 ? p.width : 1) * sizeof *p.near);
    p.place = vor_malloc(memory, n, 3 * sizeof *p.place);
    if (p.plane == NULL || p.middle == NULL || p.axes == NULL || p.near == NULL ||
        p.place == NULL || vor_crosses_init(&p.crosses, n, memory, err) != VOR_OK) {
        vor_planes_free(&p);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    }
    *out = p;
    return VOR_OK;
}

void vor_planes_free(struct vor_planes *p)
{
    struct vor_memory *memory;

    if (p->seeds == NULL)
        return;
    memory = p->seeds->run.memory;
    vor_crosses_free(&p->crosses);
    VOR_FREE_ALL(memory, p->place, p->near, p->axes, p->middle, p->plane);
    memset(p, 0, sizeof *p);
}

/* What the tasks of a freeze share. */
struct freeze {
    struct vor_planes *planes;
    const struct vor_knn *knn;
    unsigned power;
    double *y;
};

/* The seeds nearest to seed i, without it; returns the distance to the nearest. *radius: mean
 * distance to the six nearest, normalised; with fewer seeds 2, which spans everything. */
static double find_near(const struct freeze *freeze, size_t i, double *radius)
{
    const struct vor_planes *p = freeze->planes;
    uint32_t index[VOR_SEEDS_LISTED + 1], *near = &p->near[i * p->width];
    float distance2[VOR_SEEDS_LISTED + 1];
    double sum = 0, first = 0;
    unsigned found = 0;

    vor_knn_search(freeze->knn, &p->seeds->xyz[3 * i], 1, p->width + 1, index, distance2);
    for (unsigned j = 0; j <= p->width && found < p->width; j++) {
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

/* Turns the axes of seed i to those of its metric, and sets M: a root of it, whose factors are 1
 * over and the root of its aspect. The patch is as much longer as cells are to be. */
static void set_metric(struct vor_planes *p, size_t i)
{
    struct vor_energy_plane *flat = &p->plane[i].flat;
    double *axes = &p->axes[9 * i], g[6], plane[3], way[2], first[3], aspect;
    const double tangent[2][3] = {{axes[0], axes[1], axes[2]}, {axes[3], axes[4], axes[5]}};

    for (int c = 0; c < 6; c++)
        g[c] = (double)p->seeds->stretched.near[i].tensor[c];
    vor_metric_restrict(plane, g, tangent);
    (void)vor_metric_even(plane, p->seeds->stretched.field->most);
    aspect = vor_metric_aspect(plane);
    vor_metric_long_side(way, plane);
    for (int c = 0; c < 3; c++)
        first[c] = way[0] * axes[c] + way[1] * axes[3 + c];
    vor_cross(&axes[3], &axes[6], first);
    memcpy(axes, first, sizeof first);
    flat->factor[0] = 1 / sqrt(aspect);
    flat->factor[1] = sqrt(aspect);
    flat->radius *= sqrt(aspect);
}

/* Where the cell ends at the border of the input (rule 2 of geom/boundary.h). */
static void set_wall(struct vor_energy_plane *flat, const struct vor_planes *p,
                     const struct vor_place *here, const double axes[9], const double at[3],
                     double radius)
{
    const struct vor_surface *surface = &here->surface;
    double side[2] = {0}, way[3];

    flat->wall[0] = flat->wall[1] = 0;
    flat->room = INFINITY;
    if (!p->seeds->policy.keep_border)
        return;
    flat->room = vor_boundary_room(surface, here->near, here->k, at, radius, side) / p->spacing;
    for (int c = 0; c < 3; c++)
        way[c] = side[0] * surface->axis[0][c] + side[1] * surface->axis[1][c];
    flat->wall[0] = vor_dot(&axes[0], way);
    flat->wall[1] = vor_dot(&axes[3], way);
}

/* Fits the surface of seed i and takes its plane there. */
static void freeze_seed(const struct freeze *freeze, struct vor_scratch *scratch, size_t i)
{
    struct vor_planes *p = freeze->planes;
    struct vor_plane *plane = &p->plane[i];
    const double *bend;
    double radius, x[3], at[3], *axes = &p->axes[9 * i];

    vor_seeds_position(p->seeds, i, x);
    for (size_t c = 0; c < 3; c++)
        p->middle[3 * i + c] = x[c] / p->spacing;
    freeze->y[2 * i] = freeze->y[2 * i + 1] = 0;
    memset(axes, 0, 9 * sizeof *axes);
    plane->flat.radius = plane->reach = 0;
    if (vor_seeds_fit(p->seeds, scratch, i) == VOR_SURFACE_NONE)
        return;
    if (!(find_near(freeze, i, &radius) > 0) && p->width > 0)
        vor_seeds_part(i, p->near[i * p->width], VOR_ROUNDED, &freeze->y[2 * i]);
    bend = scratch->here.surface.c;
    radius = fmin(fmin(radius, ALONE * p->spacing),
                  BENT / (2 * (fabs(bend[3]) + fabs(bend[4]) + fabs(bend[5]))));
    vor_surface_to_local(&scratch->here.surface, x, at);
    set_axes(axes, &scratch->here.surface, at);
    plane->flat.power = freeze->power;
    plane->flat.factor[0] = plane->flat.factor[1] = 1;
    plane->flat.radius = PATCH * radius / p->spacing;
    plane->reach = VOR_LLOYD_LONG_STEP * radius / p->spacing;
    if (vor_stretched_are(&p->seeds->stretched))
        set_metric(p, i);
    set_wall(&plane->flat, p, &scratch->here, axes, at, radius);
    if (p->crossed) {
        struct vor_surface bent = scratch->here.surface; /* a quadric also where fits are planes */
        struct vor_cross_fit fit = {.surface = &bent, .k = scratch->here.k};

        if (p->seeds->policy.planes)
            vor_surface_fit(&bent, scratch->here.near, scratch->here.k);
        vor_surface_to_local(&bent, x, fit.at);
        vor_crosses_set(&p->crosses, i, &fit, &p->axes[9 * i]);
    }
}

static void freeze_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct freeze *freeze = ctx;

    for (size_t i = begin; i < end; i++)
        freeze_seed(freeze, &freeze->planes->seeds->scratch[worker], i);
}

void vor_planes_place(struct vor_planes *p, const double *y, size_t i)
{
    const double *axes = &p->axes[9 * i];

    for (size_t c = 0; c < 3; c++)
        p->place[3 * i + c] =
            p->middle[3 * i + c] + y[2 * i] * axes[c] + y[2 * i + 1] * axes[3 + c];
}

/* The seeds around seed i in the coordinates of its plane. */
void vor_planes_localize(double (*other)[3], const struct vor_planes *p, size_t i)
{
    const double *middle = &p->middle[3 * i], *axes = &p->axes[9 * i];

    for (unsigned k = 0; k < p->width; k++) {
        const double *x = &p->place[3 * (size_t)p->near[i * p->width + k]];
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
    struct vor_planes *p = freeze->planes;
    struct vor_energy_plane *flat = &p->plane[i].flat;
    const struct vor_surface *surface = &p->seeds->last_fit[i].surface;
    const double *axes = &p->axes[9 * i];
    double other[VOR_SEEDS_LISTED][3], way[2], side[2], at[3], x[3], along[3], end, length;
    struct vor_flat cell;

    vor_planes_localize(other, p, i);
    vor_energy_cut(&cell, flat, &freeze->y[2 * i], (const double(*)[3])other, p->width);
    if (!open_way(way, &cell))
        return;
    for (size_t c = 0; c < 3; c++) {
        along[c] = way[0] * axes[c] + way[1] * axes[3 + c];
        x[c] = p->spacing * (p->middle[3 * i + c] + flat->radius * along[c]);
    }
    if (vor_seeds_fit_at(p->seeds, scratch, &scratch->there, x) == VOR_SURFACE_NONE)
        return;
    vor_seeds_position(p->seeds, i, x);
    vor_surface_to_local(surface, x, at);
    for (int d = 0; d < 2; d++)
        side[d] = vor_dot(surface->axis[d], along);
    length = sqrt(side[0] * side[0] + side[1] * side[1]);
    if (!(length > 0))
        return;
    side[0] /= length;
    side[1] /= length;
    end = fmax(vor_boundary_end(surface, at, side, scratch->there.near, scratch->there.k),
               VOR_EDGE_ROOM * scratch->there.surface.spacing);
    if (!(end / p->spacing < flat->room))
        return;
    flat->room = end / p->spacing;
    memcpy(flat->wall, way, sizeof way);
}

static void end_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    const struct freeze *freeze = ctx;
    const struct vor_planes *p = freeze->planes;

    for (size_t i = begin; i < end; i++)
        if (p->plane[i].flat.radius > 0)
            find_end(freeze, &p->seeds->scratch[worker], i);
}

vor_status vor_planes_set(struct vor_planes *p, unsigned power, double *y,
                          const struct vor_run *run, struct vor_error *err)
{
    struct freeze freeze = {.planes = p, .power = power, .y = y};
    struct vor_knn *knn = NULL;
    size_t n = p->seeds->n;
    vor_status status = vor_stretched_renew(&p->seeds->stretched, p->seeds->xyz, run, err);

    VOR_THEN(status, vor_knn_build(&knn, p->seeds->xyz, n, p->seeds->run.memory, err));
    if (status != VOR_OK)
        return status;
    freeze.knn = knn;
    status = vor_run_for(run, n, VOR_SEEDS_BLOCK, freeze_block, &freeze, err);
    vor_knn_free(knn);
    if (status == VOR_OK && p->crossed) {
        status = vor_crosses_smooth(&p->crosses, p->axes, p->near, p->width,
                                    p->width < VOR_PATCH_HEXAGON ? p->width : VOR_PATCH_HEXAGON,
                                    run, err);
        if (status == VOR_OK) {
            /* The axes of all seeds turn to their crosses, and the walls with them. */
            for (size_t i = 0; i < p->seeds->n; i++) {
                struct vor_energy_plane *flat = &p->plane[i].flat;
                double *axes = &p->axes[9 * i], way[3];

                if (!(flat->radius > 0))
                    continue;
                for (int c = 0; c < 3; c++)
                    way[c] = flat->wall[0] * axes[c] + flat->wall[1] * axes[3 + c];
                vor_crosses_turn(&p->crosses, i, axes);
                flat->wall[0] = vor_dot(&axes[0], way);
                flat->wall[1] = vor_dot(&axes[3], way);
            }
        }
    }
    if (status != VOR_OK || !p->seeds->policy.keep_border)
        return status;
    for (size_t i = 0; i < n; i++)
        vor_planes_place(p, y, i);
    return vor_run_for(run, n, VOR_SEEDS_BLOCK, end_block, &freeze, err);
}
