/* Xiao et al. 2024, Sec. III and IV-A, B: surfaces, cells, initialisation, Lloyd. */
#include "core/base/linalg.h"
#include "core/cvt/lloyd.h"
#include "core/geom/integrate.h"
#include "core/metrics/uniformity.h"
#include "core/seeds/start.h"
#include "tests/support/vt_trace.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 3 };

#define GERSHO 0.16037507477489605 /* 5 / (18 sqrt 3): energy x n / area^2 of regular hexagons */

/* --- Fig. 2 and 8, row X1 -----------------------------------------------------------------------
 */

/* Largest distance to the unit sphere over a patch one neighbourhood wide. */
static double off_sphere(const struct vor_surface *surface)
{
    double most = 0;

    for (int a = 0; a < 24; a++)
        for (double r = 0; r <= 0.8; r += 0.2) {
            double u = surface->center[0] + r * surface->reach * cos(a), x[3];
            double v = surface->center[1] + r * surface->reach * sin(a);
            double local[3] = {u, v, vor_surface_height(surface, u, v, NULL)};

            vor_surface_to_world(surface, local, x);
            most = fmax(most, fabs(sqrt(vor_dot(x, x)) - 1));
        }
    return most;
}

VT_TEST_LOOP(fig_8_a_quadric_is_ten_times_nearer_to_a_sphere_than_its_plane, SEEDS)
{
    struct vor_cloud cloud;
    struct vor_knn *knn;
    double quadrics = 0, planes = 0;

    vt_cloud_sphere(&cloud, (uint64_t)_i, 2000);
    vt_assert_ok(vor_knn_build(&knn, cloud.xyz, cloud.n, &vt_memory, &vt_err));
    for (size_t i = 0; i < 200; i++) {
        uint32_t index[20];
        float distance2[20], near[60];
        struct vor_surface surface;
        double mean = 0;

        vor_knn_search(knn, &cloud.xyz[3 * i], 1, 20, index, distance2);
        for (size_t j = 0; j < 20; j++)
            memcpy(&near[3 * j], &cloud.xyz[3 * (size_t)index[j]], 3 * sizeof *near);
        vor_surface_fit(&surface, near, 20);
        ck_assert_int_eq(surface.kind, VOR_SURFACE_QUADRIC);
        quadrics += off_sphere(&surface);
        for (size_t j = 0; j < 20; j++) {
            double x[3] = {(double)near[3 * j], (double)near[3 * j + 1], (double)near[3 * j + 2]};
            double local[3];

            vor_surface_to_local(&surface, x, local);
            mean += local[2] / 20;
        }
        memset(surface.c, 0, sizeof surface.c); /* the best plane is across the normal */
        surface.c[0] = mean;
        planes += off_sphere(&surface);
    }
    ck_assert_double_lt(quadrics, planes / 10);
    vor_knn_free(knn);
    vor_cloud_free(&cloud);
}

/* --- Sec. III-B step 2 and III-C, rows X2 and X4 ------------------------------------------------
 */

/* --- Eq. 5, row X8 ------------------------------------------------------------------------------
 */

/* A hexagonal lattice in a plane is a centroidal tessellation: its cells are regular hexagons and
 * every inner seed is the centroid of its own. */
VT_TEST(eq_5_a_hexagonal_lattice_in_a_plane_stands_still)
{
    enum { SIDE = 12 };
    const double h = 0.05, area = sqrt(3) / 2 * h * h;
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_seeds seeds;
    unsigned inner = 0;

    vt_engine_open(&engine, 1);
    vt_cloud_square(&cloud, 1, 4000);
    vt_assert_ok(vor_domain_init(&domain, &cloud, &engine.run, &vt_err));
    vt_assert_ok(vor_seeds_init(&seeds, &domain, SIDE * SIDE, vt_policy, &engine.run, &vt_err));
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        double row = (double)(i / SIDE), column = (double)(i % SIDE);

        seeds.xyz[3 * i] =
            (float)((0.15 + h * (column + 0.5 * (double)(i / SIDE % 2))) / domain.unit);
        seeds.xyz[3 * i + 1] = (float)((0.2 + h * row * sqrt(3) / 2) / domain.unit);
        seeds.xyz[3 * i + 2] = 0;
    }
    vt_assert_ok(vor_seeds_index(&seeds, &seeds.run, &vt_err));
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        struct vor_moments m;
        double scale = domain.unit * domain.unit;

        if (i < 2 * SIDE || i >= (SIDE - 2) * SIDE || i % SIDE < 2 || i % SIDE >= SIDE - 2)
            continue;
        ck_assert_int_ne(vor_seeds_cell(&seeds, &seeds.scratch[0], i), VOR_SURFACE_NONE);
        ck_assert(vor_cell_moments(&m, &seeds.scratch[0].cell));
        ck_assert_double_eq_tol(m.area * scale / area, 1, 1e-5);
        ck_assert_double_eq_tol(m.energy * scale * scale / (GERSHO * area * area), 1, 1e-5);
        for (int c = 0; c < 3; c++)
            ck_assert_double_le(fabs(m.centroid[c] - seeds.scratch[0].cell.seed[c]) * domain.unit,
                                1e-6 * h);
        inner++;
    }
    ck_assert_uint_eq(inner, (SIDE - 4) * (SIDE - 4));
    vor_seeds_free(&seeds);
    vor_domain_free(&domain);
    vor_cloud_free(&cloud);
    vt_engine_close(&engine);
}

static void trace_run(struct vt_trace *trace, struct vor_report *report, const struct vor_cloud *in,
                      const char *points, const char *iterations, const char *window)
{
    struct vt_engine engine;
    struct vor_cloud out;

    vt_engine_open(&engine, 2);
    vt_trace_attach(trace, &engine);
    vt_engine_set(&engine, "points", points);
    vt_engine_set(&engine, "iterations", iterations);
    vt_engine_set(&engine, "anderson", window);
    vt_engine_set(&engine, "polish", "0");
    vt_engine_resample(&engine, &out, report, in);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
}

/* The more seeds settle, the nearer to hexagons: Gersho's bound is that of hexagons only. */
VT_TEST_LOOP(the_energy_of_a_sphere_comes_near_that_of_hexagons_and_not_below, SEEDS)
{
    static struct vt_trace trace;
    struct vor_report report;
    struct vor_cloud in;
    double normalised;

    vt_cloud_sphere(&in, (uint64_t)_i, 4000);
    trace_run(&trace, &report, &in, "600", "60", "4");
    normalised = trace.record[60].energy * 600 / (report.area * report.area);
    ck_assert_double_gt(normalised, GERSHO * 0.995);
    ck_assert_double_lt(normalised, GERSHO * 1.05);
    vor_cloud_free(&in);
}

/* --- Fig. 6(e), rows X5 and X8 ------------------------------------------------------------------
 */

static double mean_energy(const struct vt_trace *trace, size_t from)
{
    double sum = 0;

    for (size_t i = from; i < from + 10; i++)
        sum += trace->record[i].energy / 10;
    return sum;
}

VT_TEST_LOOP(fig_6e_energy_and_delta_fall_overall, SEEDS)
{
    static struct vt_trace trace;
    struct vor_report report;
    struct vor_cloud in;

    vt_cloud_sphere(&in, (uint64_t)_i, 4000);
    trace_run(&trace, &report, &in, "600", "40", _i == 0 ? "0" : "4");
    ck_assert_uint_ge(trace.count, 41); /* one more tells of the result */
    for (size_t i = 1; i <= 40; i++)
        ck_assert_double_gt(trace.record[i].energy, 0);
    ck_assert_double_lt(mean_energy(&trace, 11), mean_energy(&trace, 1));
    ck_assert_double_lt(mean_energy(&trace, 31), mean_energy(&trace, 11));
    ck_assert_double_lt(trace.record[40].energy, 0.85 * trace.record[1].energy);
    ck_assert_double_lt(trace.record[40].delta, 0.35 * trace.record[0].delta);
    vor_cloud_free(&in);
}

/* --- Fig. 5, rows X6 and X7 ---------------------------------------------------------------------
 */

/* A square whose left half is ten times as dense. */
static void uneven_square(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_square(cloud, seed, n);
    for (size_t i = 0; i < n; i++)
        cloud->xyz[3 * i] = cloud->xyz[3 * i] / 2 + (i % 11 == 0 ? 0.5f : 0);
}

/* delta after ten iterations from either start; *left gets the share of the seeds that start in the
 * dense half. */
static double delta_from(const struct vor_cloud *cloud, uint64_t seed, int random, double *left)
{
    enum { START = 500 };
    struct vt_engine engine;
    struct vor_domain domain;
    struct vor_seeds seeds;
    struct vor_outcome told = {0};
    struct vor_uniformity even;
    struct vor_knn *knn;
    float nearest[START];

    vt_engine_open(&engine, 2);
    vt_engine_set(&engine, "iterations", "10");
    vt_engine_set(&engine, "anderson", "4"); /* as in the paper, and no polish */
    vt_engine_set(&engine, "polish", "0");
    vt_engine_set(&engine, "neighbors", "20");
    vt_engine_count(&engine, "seed", (size_t)seed);
    vt_assert_ok(vor_domain_init(&domain, cloud, &engine.run, &vt_err));
    if (random)
        vt_assert_ok(vor_seeds_init(&seeds, &domain, START, vt_policy, &engine.run, &vt_err));
    else
        vt_assert_ok(vor_start_seeds(&seeds, &domain, START, &engine.spec, &engine.run, &vt_err));
    *left = 0;
    for (size_t i = 0; i < START; i++) {
        size_t from = (size_t)vor_rng_below(seed, 71, i, domain.n);

        if (random)
            memcpy(&seeds.xyz[3 * i], &domain.xyz[3 * from], 3 * sizeof *seeds.xyz);
        *left += (double)seeds.xyz[3 * i] * domain.unit + domain.shift[0] < 0.5;
    }
    *left /= START;
    vt_assert_ok(vor_lloyd_run(&seeds, &told, &engine.spec, &engine.run, &vt_err));
    vt_assert_ok(vor_knn_build(&knn, seeds.xyz, START, &vt_memory, &vt_err));
    vt_assert_ok(vor_nearest_distances(nearest, seeds.xyz, START, knn, &engine.run, &vt_err));
    vor_uniformity_from(&even, nearest, START);
    vor_knn_free(knn);
    vor_seeds_free(&seeds);
    vor_domain_free(&domain);
    vt_engine_close(&engine);
    return even.delta;
}

VT_TEST_LOOP(fig_5_a_start_by_area_beats_a_random_one_on_an_uneven_cloud, SEEDS)
{
    struct vor_cloud cloud;
    double left_area, left_random, by_area, by_random;

    uneven_square(&cloud, (uint64_t)_i, 5500);
    by_area = delta_from(&cloud, (uint64_t)_i, 0, &left_area);
    by_random = delta_from(&cloud, (uint64_t)_i, 1, &left_random);
    ck_assert_double_eq_tol(left_area, 0.5, 0.06);
    ck_assert_double_gt(left_random, 0.85);
    ck_assert_double_lt(by_area, 0.75 * by_random);
    vor_cloud_free(&cloud);
}
