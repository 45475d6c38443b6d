/* Oracles for what stops early: the restricted Voronoi cell at the security radius (row X4), and
 * the nearest distances from lists after a move. */
#include "core/geom/integrate.h"
#include "core/seeds/seeds.h"
#include "core/seeds/uniformity.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 8 };

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_seeds seeds;
};

/* Seeds on a cloud: random points of the domain, every one moved a little off it. */
static void open_bed_as(struct bed *bed, uint64_t seed, size_t points, size_t n,
                        struct vor_seeds_policy policy)
{
    vt_engine_open(&bed->engine, 1);
    if (seed % 2)
        vt_cloud_dome(&bed->cloud, seed, points);
    else
        vt_cloud_box(&bed->cloud, seed, points);
    vt_assert_ok(vor_domain_init(&bed->domain, &bed->cloud, &bed->engine.run, &vt_err));
    vt_assert_ok(vor_seeds_init(&bed->seeds, &bed->domain, n, policy, &bed->engine.run, &vt_err));
    for (size_t i = 0; i < 3 * n; i++) {
        size_t from = (size_t)vor_rng_below(seed, 41, i / 3, bed->domain.n);

        bed->seeds.xyz[i] =
            bed->domain.xyz[3 * from + i % 3] + (float)(0.01 * (vt_unit(seed + 9, i) - 0.5));
    }
    vt_assert_ok(vor_seeds_index(&bed->seeds, &bed->seeds.run, &vt_err));
}

static void open_bed(struct bed *bed, uint64_t seed, size_t points, size_t n)
{
    open_bed_as(bed, seed, points, n, vt_policy);
}

static void close_bed(struct bed *bed)
{
    vor_seeds_free(&bed->seeds);
    vor_domain_free(&bed->domain);
    vor_cloud_free(&bed->cloud);
    vt_engine_close(&bed->engine);
}

/* Moves up to `most` in any direction. */
static void move_all(float *moved, const struct vor_seeds *seeds, uint64_t seed, double most)
{
    for (size_t i = 0; i < 3 * seeds->n; i++)
        moved[i] = (float)((double)seeds->xyz[i] + most / sqrt(3) * (2 * vt_unit(seed, i) - 1));
}

/* A patch clipped by every other seed, in the order of their numbers. */
static void clip_by_all(struct vor_cell *cell, const struct vor_seeds *seeds,
                        const struct vor_scratch *scratch, size_t i, const struct vor_disc *disc)
{
    const struct vor_surface *surface = &scratch->here.surface;
    double x[3], local[3], side[2], room;

    vor_seeds_position(seeds, i, x);
    vor_surface_to_local(surface, x, local);
    vor_cell_begin(cell, disc, surface, local, scratch->radius);
    room = vor_boundary_room(surface, scratch->here.near, scratch->here.k, local,
                             scratch->radius / seeds->policy.widen, side);
    if (seeds->policy.keep_border && room < scratch->radius)
        vor_cell_clip(cell, (double[3]){2 * room * side[0], 2 * room * side[1], 0});
    for (size_t j = 0; j < seeds->n; j++) {
        double other[3], offset[3];

        if (j == i)
            continue;
        vor_seeds_position(seeds, j, other);
        vor_surface_to_local(surface, other, offset);
        for (int c = 0; c < 3; c++)
            offset[c] -= local[c];
        vor_cell_clip(cell, offset);
    }
}

/* By how much of the patch the cell at hand differs from one of this disc. */
static double apart(const struct vor_seeds *seeds, const struct vor_scratch *scratch, size_t i,
                    const struct vor_disc *disc)
{
    static struct vor_cell all;
    struct vor_moments found = {.area = 0}, expected = {.area = 0};
    double patch = scratch->radius * scratch->radius, most;

    clip_by_all(&all, seeds, scratch, i, disc);
    if (!vor_cell_moments(&expected, &all))
        return vor_cell_moments(&found, &scratch->cell) ? INFINITY : 0;
    if (!vor_cell_moments(&found, &scratch->cell))
        return INFINITY;
    most = fmax(fabs(found.area - expected.area) / patch,
                fabs(found.energy - expected.energy) / (patch * patch));
    for (int c = 0; c < 3; c++)
        most = fmax(most, fabs(found.centroid[c] - expected.centroid[c]) * expected.area /
                              (patch * scratch->radius));
    return most;
}

/* How far bent cells are from those of the finest patch: made at once, and clipped. Of a bed with
 * few of them, one may be as much of a patch farther. */
static double bent[2];
#define LUCK 0.3

/* Cells that are clipped are the same; those made at once are of numbers in float32, and where the
 * surface bends in the mean nearer to it than clipped ones (0.020 and 0.035 here). */
static void compare_cells(struct vor_seeds *seeds, size_t i)
{
    struct vor_scratch *scratch = &seeds->scratch[0];
    const struct vor_disc *disc;
    struct vor_disc fine;
    uint64_t before = scratch->triangles;

    ck_assert_int_ne(vor_seeds_cell(seeds, scratch, i), VOR_SURFACE_NONE);
    disc = scratch->triangles - before == 1 ? &seeds->flat : &seeds->disc;
    if (apart(seeds, scratch, i, disc) <= 1e-12)
        return;
    vor_disc_init(&fine, disc->sides, VOR_PATCH_RINGS_MAX - (disc->sides == VOR_PATCH_OCTAGON));
    if (disc == &seeds->flat) {
        ck_assert_double_le(apart(seeds, scratch, i, disc), 1e-6);
        return;
    }
    bent[0] += apart(seeds, scratch, i, &fine);
    clip_by_all(&scratch->cell, seeds, scratch, i, disc);
    bent[1] += apart(seeds, scratch, i, &fine);
}

VT_TEST_LOOP(a_cell_that_stops_at_the_security_radius_is_clipped_by_all_seeds, SEEDS)
{
    static const size_t counts[4] = {2, 7, 60, 700};

    for (int k = 0; k < 4; k++)
        for (int keep = 0; keep < 2; keep++) {
            struct bed bed;

            open_bed(&bed, (uint64_t)_i, 3000, counts[k]);
            bed.seeds.policy.keep_border = keep;
            for (size_t i = 0; i < bed.seeds.n; i++)
                compare_cells(&bed.seeds, i);
            close_bed(&bed);
        }
    ck_assert_double_le(bent[0], bent[1] + LUCK);
}

/* Chen 2018, Sec. 4.2: octagons in the planes of the input. */
VT_TEST_LOOP(a_cell_in_a_plane_is_an_octagon_clipped_by_all_seeds, SEEDS)
{
    static const size_t counts[4] = {2, 7, 60, 700};

    for (int k = 0; k < 4; k++) {
        struct vor_seeds_policy policy = {.keep_border = k % 2, .widen = 1, .planes = 1};
        const struct vor_scratch *scratch;
        struct vor_cell whole;
        struct bed bed;

        open_bed_as(&bed, (uint64_t)_i, 3000, counts[k], policy);
        scratch = &bed.seeds.scratch[0];
        for (size_t i = 0; i < bed.seeds.n; i++) {
            const struct vor_surface *surface = &scratch->here.surface;

            compare_cells(&bed.seeds, i);
            ck_assert_int_eq(surface->kind, VOR_SURFACE_PLANE);
            ck_assert(surface->c[3] == 0 && surface->c[4] == 0 && surface->c[5] == 0);
            vor_cell_begin(&whole, &bed.seeds.flat, surface, scratch->cell.seed, scratch->radius);
            ck_assert(whole.count == 1 && whole.piece[0].count == VOR_PATCH_OCTAGON);
        }
        close_bed(&bed);
    }
}

/* Sends `jumpers` of the seeds to where other ones are, a little beside, and moves the rest by less
 * than what makes the lists anew. */
static void jump(struct vor_seeds *seeds, uint64_t seed, size_t jumpers)
{
    float *moved = vor_malloc(&vt_memory, seeds->n, 3 * sizeof *moved);

    move_all(moved, seeds, seed, 0.2 * seeds->point_lists.spacing);
    for (size_t j = 0; j < jumpers; j++) {
        size_t who = (size_t)vor_rng_below(seed, 42, j, seeds->n);
        size_t where = (size_t)vor_rng_below(seed, 43, j, seeds->n);

        for (size_t c = 0; c < 3; c++)
            moved[3 * who + c] =
                seeds->xyz[3 * where + c] +
                (float)(0.5 * seeds->point_lists.spacing * vt_unit(seed, 3 * j + c));
    }
    memcpy(seeds->xyz, moved, 3 * seeds->n * sizeof *moved);
    vor_free(&vt_memory, moved);
}

VT_TEST_LOOP(a_cell_from_lists_of_before_is_clipped_by_all_seeds_as_they_are_now, SEEDS)
{
    static const size_t counts[3] = {15, 60, 500}, jumpers[4] = {0, 1, 5, 40};
    static const double widen[4] = {1, 1.5, 1, 2};

    for (int k = 0; k < 3; k++)
        for (int j = 0; j < 4; j++) {
            struct bed bed;

            open_bed(&bed, (uint64_t)_i, 3000, counts[k]);
            bed.seeds.policy.widen = widen[j];
            jump(&bed.seeds, (uint64_t)(10 * _i + j), jumpers[j]);
            vt_assert_ok(vor_seeds_index(&bed.seeds, &bed.seeds.run, &vt_err));
            ck_assert_uint_eq(bed.seeds.point_lists.indexed, 1);
            for (size_t i = 0; i < bed.seeds.n; i++)
                compare_cells(&bed.seeds, i);
            close_bed(&bed);
        }
    ck_assert_double_le(bent[0], bent[1] + LUCK);
}

/* Cells are disjoint: a sample of one is nearer to its own seed than to any other. */
VT_TEST_LOOP(a_sample_of_a_cell_is_nearest_to_its_own_seed, SEEDS)
{
    struct bed bed;
    struct vor_scratch *scratch;

    open_bed(&bed, (uint64_t)_i, 3000, 200);
    scratch = &bed.seeds.scratch[0];
    for (size_t i = 0; i < 200; i++) {
        struct vor_moments moments;
        double unit[3], local[3], x[3], own = 0, rounding;

        ck_assert_int_ne(vor_seeds_cell(&bed.seeds, scratch, i), VOR_SURFACE_NONE);
        if (!vor_cell_moments(&moments, &scratch->cell))
            continue;
        rounding = scratch->radius * (scratch->cell.count > 1 ? 1e-3 : 1e-6);
        for (size_t c = 0; c < 3; c++)
            unit[c] = vt_unit((uint64_t)_i + 3, 3 * i + c);
        vor_cell_sample(&scratch->cell, moments.area, 1, &unit, &local);
        vor_surface_to_world(&scratch->here.surface, local, x);
        for (size_t c = 0; c < 3; c++)
            own += pow(x[c] - (double)bed.seeds.xyz[3 * i + c], 2);
        for (size_t j = 0; j < 200; j++) {
            double other = 0;

            for (size_t c = 0; c < 3; c++)
                other += pow(x[c] - (double)bed.seeds.xyz[3 * j + c], 2);
            ck_assert_double_le(sqrt(own), sqrt(other) + rounding);
        }
    }
    close_bed(&bed);
}

static double nearest_other(const float *xyz, size_t n, size_t i)
{
    double best = INFINITY;

    for (size_t j = 0; j < n; j++) {
        double d2 = 0;

        for (size_t c = 0; c < 3; c++)
            d2 += pow((double)xyz[3 * i + c] - (double)xyz[3 * j + c], 2);
        if (j != i)
            best = fmin(best, d2);
    }
    return sqrt(best);
}

VT_TEST_LOOP(nearest_distances_after_a_move_are_those_of_a_look_at_every_seed, SEEDS)
{
    static const double moves[5] = {0, 0.001, 0.02, 0.2, 2};
    static const size_t counts[5] = {1, 2, 15, 300, 1200};

    for (int k = 0; k < 5; k++)
        for (int m = 0; m < 5; m++) {
            struct bed bed;
            struct vor_uniformity even, expected;
            size_t n = counts[k];
            float *moved = vor_malloc(&vt_memory, n, 4 * sizeof *moved), *nearest = moved + 3 * n;

            open_bed(&bed, (uint64_t)_i, 2000, n);
            move_all(moved, &bed.seeds, (uint64_t)(100 * k + m), moves[m]);
            vt_assert_ok(
                vor_seeds_uniformity(&even, nearest, &bed.seeds, moved, &bed.seeds.run, &vt_err));
            for (size_t i = 0; i < n; i++) {
                double brute = n > 1 ? nearest_other(moved, n, i) : 0;

                ck_assert_double_le(fabs((double)nearest[i] - brute), 1e-6 * brute);
            }
            vor_uniformity_from(&expected, nearest, n);
            ck_assert(memcmp(&even, &expected, sizeof even) == 0);
            vor_free(&vt_memory, moved);
            close_bed(&bed);
        }
}
