/* neighbors=auto brings a result nearer to the surface than one number for all of it. */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_shape.h"

#include <math.h>

enum { SEEDS = 4, N = 12000, PLATES = 3 };

/* Distance between neighbours of n points on that area, in a square lattice. */
static double spacing(const struct vt_shape *shape, size_t n)
{
    return sqrt(shape->area / (double)n);
}

static void add_noise(struct vor_cloud *cloud, uint64_t seed, double sigma)
{
    for (size_t i = 0; i < 3 * cloud->n; i++)
        cloud->xyz[i] += (float)(sigma * vt_normal(seed, i));
}

/* The same where x > 0 only. */
static void add_noise_to_half(struct vor_cloud *cloud, uint64_t seed, double sigma)
{
    for (size_t i = 0; i < cloud->n; i++) {
        int noisy = cloud->xyz[3 * i] > 0;

        for (size_t c = 0; noisy && c < 3; c++)
            cloud->xyz[3 * i + c] += (float)(sigma * vt_normal(seed, 3 * i + c));
    }
}

/* Mean distance to its surface of a result with that many neighbours. */
static double off(const struct vor_cloud *in, const struct vt_shape *shape, const char *neighbors,
                  struct vor_report *report)
{
    struct vt_engine engine;
    struct vor_cloud out;
    double mean;

    vt_engine_open(&engine, 2);
    vt_engine_set(&engine, "points", "2000");
    vt_engine_set(&engine, "neighbors", neighbors);
    vt_engine_set(&engine, "polish", "30");
    vt_engine_resample(&engine, &out, report, in);
    mean = vt_off_mean(shape, &out);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return mean;
}

static double neighbors(const struct vor_report *report)
{
    return report->parameters.value[VOR_PARAM_NEIGHBORS];
}

VT_TEST_LOOP(what_it_finds_denoises_and_the_report_says_what_it_was,
             VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    const struct vt_shape *sphere = &vt_shapes[VT_SPHERE];
    struct vor_report report;
    struct vor_cloud cloud;
    double few, found;

    vt_cloud_sphere(&cloud, (uint64_t)_i, N);
    add_noise(&cloud, (uint64_t)_i, 0.8 * spacing(sphere, N));
    few = off(&cloud, sphere, "20", &report);
    ck_assert(neighbors(&report) == 20);
    found = off(&cloud, sphere, "auto", &report);
    ck_assert(neighbors(&report) > 20);
    ck_assert_msg(found < few / 2, "%g off with %g, %g with 20", found, neighbors(&report), few);
    vor_cloud_free(&cloud);
}

VT_TEST_FIGURES(a_cloud_noisy_in_parts_is_off_by_less_than_with_any_one_number,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    static const char *const ladder[] = {"20", "45", "70", "150"};
    const struct vt_shape *torus = &vt_shapes[VT_TORUS];
    struct vor_report report;
    struct vor_cloud cloud;
    double found, one;
    uint64_t counted = 0;

    vt_cloud_torus(&cloud, (uint64_t)_i, N);
    add_noise_to_half(&cloud, (uint64_t)_i, 0.8 * spacing(torus, N));
    found = off(&cloud, torus, "auto", &report);
    ck_assert_uint_ge(report.fitted_count, 3);
    for (unsigned i = 0; i < report.fitted_count; i++) {
        ck_assert(i == 0 || report.fitted[i].neighbors > report.fitted[i - 1].neighbors);
        counted += report.fitted[i].points;
    }
    ck_assert_uint_eq(counted, report.points_out);
    for (size_t i = 0; i < sizeof ladder / sizeof *ladder; i++) {
        one = off(&cloud, torus, ladder[i], &report);
        ck_assert_msg(found < one, "%g off, %g with %s", found, one, ladder[i]);
    }
    vor_cloud_free(&cloud);
}

/* A disc of radius 1, so many spacings thick, its rim round. */
static void make_plate(struct vor_cloud *cloud, uint64_t seed, size_t n, double thick)
{
    double gap = thick * sqrt(2 * M_PI / (double)n);

    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double turn = 2 * M_PI * vt_unit(seed, 3 * i), share = vt_unit(seed, 3 * i + 1);
        int rim = vt_unit(seed, 3 * i + 2) < M_PI * gap / (2 + M_PI * gap); /* by area */
        double up = M_PI * (rim ? share - 0.5 : i % 2 ? 0.5 : -0.5);
        double r = rim ? 1 + gap / 2 * cos(up) : sqrt(share);

        cloud->xyz[3 * i] = (float)(r * cos(turn));
        cloud->xyz[3 * i + 1] = (float)(r * sin(turn));
        cloud->xyz[3 * i + 2] = (float)(gap / 2 * sin(up)) + cloud->xyz[3 * i] / 3; /* rounded */
    }
}

/* Two without noise, one whose sides are seven times its noise apart: a fit to 100 neighbours runs
 * between them. */
VT_TEST_LOOP(the_sides_of_a_plate_are_not_noise, VT_SOAK_LOOPS(PLATES, SEEDS *PLATES))
{
    static const double thick[PLATES] = {2, 8, 3.4}, noise[PLATES] = {0, 0, 0.5};
    int plate = _i % PLATES;
    struct vt_engine engine;
    struct vor_cloud cloud, out;
    struct vor_report report;

    make_plate(&cloud, (uint64_t)_i, 4000, thick[plate]);
    add_noise(&cloud, (uint64_t)_i, noise[plate] * sqrt(2 * M_PI / (double)cloud.n));
    vt_engine_open(&engine, 2);
    vt_ask_set(&engine, "points=400 polish=0");
    vt_engine_resample(&engine, &out, &report, &cloud);
    ck_assert(neighbors(&report) == 20 && (plate != 1 || report.fitted_count == 1));
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    vor_cloud_free(&cloud);
}
