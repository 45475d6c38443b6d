/* Oracles for seeds with a metric: cells that stop at the security radius, and nearest distances
 * from lists, against a look at every seed. */
#include "core/geom/integrate.h"
#include "core/input/anisotropy.h"
#include "core/input/input.h"
#include "core/seeds/seeds.h"
#include "core/seeds/uniformity.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 2, POINTS = 1500 };

struct bed {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_seeds seeds;
};

/* Seeds at random points of a torus, every one moved a little off it. */
static void open_bed(struct bed *bed, uint64_t seed, size_t n, const char *most)
{
    const struct vor_spec *spec = &bed->engine.spec;

    vt_engine_open(&bed->engine, 1);
    vt_engine_set(&bed->engine, "metric", "anisotropic");
    vt_engine_set(&bed->engine, "maxAspect", most);
    vt_engine_count(&bed->engine, "points", n);
    vt_cloud_torus(&bed->cloud, seed, POINTS);
    vt_assert_ok(vor_input_prepare(&bed->domain, &bed->cloud, spec, &bed->engine.run, &vt_err));
    vt_assert_ok(
        vor_anisotropy_make(&bed->domain, &bed->cloud, n, spec, &bed->engine.run, &vt_err));
    vt_assert_ok(
        vor_seeds_init(&bed->seeds, &bed->domain, n, vt_policy, &bed->engine.run, &vt_err));
    for (size_t i = 0; i < 3 * n; i++) {
        size_t from = (size_t)vor_rng_below(seed, 41, i / 3, bed->domain.n);

        bed->seeds.xyz[i] =
            bed->domain.xyz[3 * from + i % 3] + (float)(0.01 * (vt_unit(seed + 9, i) - 0.5));
    }
    vt_assert_ok(vor_seeds_index(&bed->seeds, &bed->seeds.run, &vt_err));
}

static void close_bed(struct bed *bed)
{
    vor_seeds_free(&bed->seeds);
    vor_domain_free(&bed->domain);
    vor_cloud_free(&bed->cloud);
    vt_engine_close(&bed->engine);
}

/* The same patch clipped by every other seed, in the order of their numbers. */
static void clip_by_all(struct vor_cell *cell, const struct vor_seeds *seeds,
                        const struct vor_scratch *scratch, size_t i, const struct vor_disc *disc)
{
    const struct vor_surface *surface = &scratch->here.surface;
    const struct vor_stretch *stretch = &scratch->stretch;
    double x[3], local[3];

    vor_seeds_position(seeds, i, x);
    vor_surface_to_local(surface, x, local);
    vor_stretch_local(stretch, local);
    vor_cell_begin(cell, disc, &stretch->surface, local, scratch->radius);
    for (size_t j = 0; j < seeds->n; j++) {
        double other[3], offset[3];

        if (j == i)
            continue;
        vor_seeds_position(seeds, j, other);
        vor_surface_to_local(surface, other, offset);
        vor_stretch_local(stretch, offset);
        for (int c = 0; c < 3; c++)
            offset[c] -= local[c];
        vor_cell_clip(cell, offset);
    }
    vor_stretch_undo(cell, stretch);
}

/* Mean distance to the six nearest in the metric of seed i. */
static double mean_of_six(const struct vor_seeds *seeds, const struct vor_scratch *scratch,
                          size_t i)
{
    double near[6] = {INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY}, sum = 0;

    for (size_t j = 0; j < seeds->n; j++) {
        double d[3], local[3] = {0};
        int at = 6;

        for (size_t c = 0; c < 3; c++)
            d[c] = (double)seeds->xyz[3 * j + c] - (double)seeds->xyz[3 * i + c];
        for (int c = 0; c < 3; c++)
            for (int e = 0; e < 3; e++)
                local[c] += scratch->here.surface.axis[c][e] * d[e];
        vor_stretch_local(&scratch->stretch, local);
        for (; j != i && at > 0 && vor_dot(local, local) < near[at - 1]; at--)
            if (at < 6)
                near[at] = near[at - 1];
        if (at < 6)
            near[at] = vor_dot(local, local);
    }
    for (int k = 0; k < 6; k++)
        sum += sqrt(near[k]);
    return sum / 6;
}

VT_TEST_LOOP(a_cell_in_a_metric_is_clipped_by_all_seeds, SEEDS)
{
    static const size_t counts[3] = {7, 60, 500};
    static struct vor_cell all;

    for (int k = 0; k < 3; k++) {
        struct bed bed;
        struct vor_scratch *scratch;

        open_bed(&bed, (uint64_t)_i, counts[k], _i % 2 ? "10" : "6");
        bed.seeds.policy.keep_border = 0;
        scratch = &bed.seeds.scratch[0];
        for (size_t i = 0; i < bed.seeds.n; i++) {
            struct vor_moments found, expected;
            double patch;

            const struct vor_disc *disc;
            uint64_t before = scratch->triangles;

            ck_assert_int_ne(vor_seeds_cell(&bed.seeds, scratch, i), VOR_SURFACE_NONE);
            disc = scratch->triangles - before == 1 ? &bed.seeds.flat : &bed.seeds.disc;
            clip_by_all(&all, &bed.seeds, scratch, i, disc);
            ck_assert_int_eq(vor_cell_moments(&found, &scratch->cell),
                             vor_cell_moments(&expected, &all));
            if (!vor_cell_moments(&expected, &all))
                continue;
            patch = scratch->radius * scratch->radius;
            ck_assert_double_le(fabs(found.area - expected.area), 1e-10 * patch);
            ck_assert_double_le(fabs(found.energy - expected.energy), 1e-10 * patch * patch);
            for (int c = 0; c < 3; c++)
                ck_assert_double_le(fabs(found.centroid[c] - expected.centroid[c]) * expected.area,
                                    1e-10 * patch * scratch->radius);
            if (counts[k] > 100) /* of fewer, a list holds all of them */
                ck_assert_double_le(mean_of_six(&bed.seeds, scratch, i),
                                    scratch->radius * (1 + 1e-6));
        }
        close_bed(&bed);
    }
}

static double nearest_other(const struct vor_seeds *seeds, const float *xyz, size_t i)
{
    double best = INFINITY;

    for (size_t j = 0; j < seeds->n; j++) {
        const float *a = seeds->stretched.near[i].tensor, *b = seeds->stretched.near[j].tensor;
        double d[3] = {0}, g[6];

        for (size_t c = 0; c < 3; c++)
            d[c] = (double)xyz[3 * i + c] - (double)xyz[3 * j + c];
        for (int c = 0; c < 6; c++)
            g[c] = ((double)a[c] + (double)b[c]) / 2;
        if (j != i)
            best = fmin(best, vor_metric_length2(g, d));
    }
    return sqrt(best);
}

/* Moves from none to beyond what lists serve for, and some seeds far off. */
VT_TEST_LOOP(nearest_distances_in_a_metric_are_those_of_a_look_at_every_seed, SEEDS)
{
    static const double moves[4] = {0, 0.005, 0.05, 2};
    static const size_t counts[4] = {2, 15, 100, 500};

    for (int k = 0; k < 4; k++)
        for (int m = 0; m < 4; m++) {
            struct bed bed;
            struct vor_uniformity even, expected;
            size_t n = counts[k];
            float *moved = vor_malloc(&vt_memory, n, 4 * sizeof *moved), *nearest = moved + 3 * n;

            open_bed(&bed, (uint64_t)_i, n, "6");
            for (size_t i = 0; i < 3 * n; i++) {
                double most = i / 3 % 50 == 7 && m > 0 ? 0.3 : moves[m];

                moved[i] = (float)((double)bed.seeds.xyz[i] +
                                   most * (vt_unit((uint64_t)(100 * k + m), i) - 0.5));
            }
            vt_assert_ok(
                vor_seeds_uniformity(&even, nearest, &bed.seeds, moved, &bed.seeds.run, &vt_err));
            for (size_t i = 0; i < n; i++) {
                double brute = nearest_other(&bed.seeds, moved, i);

                ck_assert_double_le(fabs((double)nearest[i] - brute), 1e-6 * brute);
            }
            vor_uniformity_from(&expected, nearest, n);
            ck_assert(memcmp(&even, &expected, sizeof even) == 0);
            vor_free(&vt_memory, moved);
            close_bed(&bed);
        }
}
