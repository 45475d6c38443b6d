/* Two sheets nearer to each other than the spacing of the input or of the result: points are on one
 * of them or the other, none in between. */
#include "core/geom/patch.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>

enum { SEEDS = 2, N = 8000, POINTS = 1000, DENSE = 60000 };

#define OFF 0.1 /* of the gap: a point farther than that from both sheets is between them */

static void add_noise(struct vor_cloud *cloud, uint64_t seed, double sigma)
{
    for (size_t i = 0; i < cloud->n; i++)
        cloud->xyz[3 * i + 2] += (float)(sigma * vt_normal(seed, i));
}

/* Counts among points away from the border those off both sheets, and those on the upper one. */
static void count(const struct vor_cloud *out, double gap, double margin, size_t counts[3])
{
    double x[3];

    counts[0] = counts[1] = counts[2] = 0;
    for (size_t i = 0; i < out->n; i++) {
        vor_cloud_position(out, i, x);
        if (x[0] < margin || x[0] > 1 - margin || x[1] < margin || x[1] > 1 - margin)
            continue;
        counts[0]++;
        counts[1] += fabs(x[2]) > OFF * gap && fabs(x[2] - gap) > OFF * gap;
        counts[2] += x[2] > gap / 2;
    }
}

static uint64_t resample(struct vor_cloud *out, const struct vor_cloud *in, unsigned threads,
                         const char *neighbors)
{
    struct vt_engine engine;
    struct vor_report report;
    uint64_t hash;

    vt_engine_open(&engine, threads);
    vt_engine_count(&engine, "points", POINTS);
    vt_engine_set(&engine, "polish", "20");
    vt_engine_set(&engine, "neighbors", neighbors);
    vt_engine_resample(&engine, out, &report, in);
    hash = vt_cloud_hash(out);
    vt_engine_close(&engine);
    return hash;
}

/* Noise leaves the few percent of the gap that a fit is off, and one in a hundred farther; so do
 * some draws of exact sheets, the first of which is held to more. Half a spacing apart, a few
 * points see neighbours on both sheets alike. */
static size_t allowed(size_t points, uint64_t seed, double gaps, double noise)
{
    if (noise > 0 || seed > 0)
        return points / 100;
    return gaps < 1 ? points / 300 : 0;
}

static void check(uint64_t seed, double gaps, double noise, const char *neighbors)
{
    double spacing = sqrt(2.0 / N), gap = gaps * spacing;
    struct vor_cloud in, out;
    size_t counts[3];

    vt_cloud_sheets(&in, seed, N, gap);
    add_noise(&in, seed + 1000, noise * gap);
    (void)resample(&out, &in, 2, neighbors);
    count(&out, gap, 6 * spacing, counts);
    ck_assert_uint_ge(counts[0], POINTS / 3);
    ck_assert_msg(counts[1] <= allowed(counts[0], seed, gaps, noise),
                  "gap %g, noise %g, %s neighbours: %zu of %zu are between", gaps, noise, neighbors,
                  counts[1], counts[0]);
    ck_assert_msg(counts[2] > 0.4 * (double)counts[0] && counts[2] < 0.6 * (double)counts[0],
                  "gap %g: %zu of %zu are on the upper sheet", gaps, counts[2], counts[0]);
    vor_cloud_free(&in);
    vor_cloud_free(&out);
}

START_TEST(no_point_lies_between_two_sheets)
{
    static const double gaps[] = {0.5, 1, 1.5, 2, 3};

    for (size_t i = 0; i < sizeof gaps / sizeof *gaps; i += VT_STEP)
        check((uint64_t)_i, gaps[i], 0, "auto");
    check((uint64_t)_i, 1, 0, "30");
    vt_assert_no_leak();
}
END_TEST

START_TEST(nor_where_they_are_noisy)
{
    check((uint64_t)_i, 1, 0.1, "auto");
    check((uint64_t)_i, 2, 0.1, "45");
    vt_assert_no_leak();
}
END_TEST

/* The input is dense: fits to all of it see one sheet, fits to its thinned points see both. */
START_TEST(nor_where_they_are_half_a_spacing_of_the_result_apart)
{
    double gap = 0.5 * sqrt(2 / (VOR_HEXAGON_HEIGHT * POINTS));
    struct vor_cloud in, out;
    size_t counts[3];

    vt_cloud_sheets(&in, (uint64_t)_i, DENSE, gap);
    (void)resample(&out, &in, 2, "auto");
    count(&out, gap, -1, counts); /* the border too, and what lies beyond it */
    ck_assert_uint_eq(counts[0], POINTS);
    ck_assert_msg(counts[1] == 0, "%zu of %d are between", counts[1], POINTS);
    vor_cloud_free(&in);
    vor_cloud_free(&out);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("engine_sheets");

    vt_add_loop(suite, no_point_lies_between_two_sheets, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_figures(suite, nor_where_they_are_noisy, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)));
    vt_add_figures(suite, nor_where_they_are_half_a_spacing_of_the_result_apart,
                   VT_FEWER(VT_SOAK_LOOPS(2 * SEEDS, 10 * SEEDS)));
    return vt_run(suite);
}
