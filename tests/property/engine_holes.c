/* Holes of a regular input stay open, however narrow; the gaps of one that is all gaps do not. */
#include "tests/support/vt_ask.h"

#include <math.h>

enum { SEEDS = 4, SIDE = 70, POINTS = 900, HOLES = 3 };

#define RADIUS 2.3 /* of the holes, in spacings: 21 points are missing */
/* Spacings from the input. From the rim it is 2.5 to the middle of a hole, and where nothing holds
 * them points come to lie at 1.6 and more; at 1.3, the nearest point of the rim may be seen so much
 * from the side that the rim goes on beyond. */
#define WITHIN 1.4

/* A lattice a little shaken, at one spacing along x and `across` along y, without the points of
 * some holes. */
static void make(struct vor_cloud *cloud, uint64_t seed, double across, int holes)
{
    size_t n = 0;

    vt_cloud_make(cloud, SIDE * SIDE);
    for (size_t i = 0; i < cloud->n; i++) {
        double x = (double)(i % SIDE), y = (double)(i / SIDE);
        int inside = 0;

        for (uint64_t h = 0; h < (uint64_t)holes; h++) {
            double dx = rint(8 + 50 * vt_unit(seed, 2 * h)) - x;
            double dy = rint(8 + 50 * vt_unit(seed, 2 * h + 1)) - y;

            inside |= hypot(dx, dy) < RADIUS;
        }
        if (inside)
            continue;
        cloud->xyz[3 * n] = (float)(x + 0.05 * vt_normal(seed, 1000 + 2 * i));
        cloud->xyz[3 * n + 1] = (float)(across * y + 0.05 * vt_normal(seed, 1001 + 2 * i));
        cloud->xyz[3 * n++ + 2] = 0;
    }
    cloud->n = n;
}

static double farthest(const struct vor_cloud *out, const struct vor_cloud *in)
{
    double far2 = 0, x[3];

    for (size_t i = 0; i < out->n; i++) {
        vor_cloud_position(out, i, x);
        far2 = fmax(far2, vt_nearest2(in, x, NULL));
    }
    return sqrt(far2);
}

static double resampled_farthest(const struct vor_cloud *in, const char *polish, double *delta)
{
    struct vor_report report;
    struct vor_cloud out;
    double far;

    vt_resample(&out, &report, in, "points=%d polish=%s", POINTS, polish);
    far = farthest(&out, in);
    *delta = report.delta;
    vor_cloud_free(&out);
    return far;
}

VT_TEST_LOOP(no_point_lies_in_a_hole_of_a_regular_input, VT_FEWER(SEEDS))
{
    static const char *const polishes[] = {"0", "20", "100"};
    struct vor_cloud in;
    double delta;

    make(&in, (uint64_t)_i, 1, HOLES);
    for (int p = 0; p < 3; p++)
        ck_assert_double_lt(resampled_farthest(&in, polishes[p], &delta), WITHIN);
    vor_cloud_free(&in);
}

VT_TEST_LOOP(the_gaps_between_scan_lines_are_filled, VT_FEWER(SEEDS))
{
    struct vor_cloud in;
    double delta, far;

    make(&in, (uint64_t)_i, 3, 0);
    far = resampled_farthest(&in, "100", &delta);
    ck_assert_double_gt(far, 1.4); /* half way to the next line, and between two points */
    ck_assert_double_lt(far, 1.8);
    ck_assert_double_lt(delta, 0.06);
    vor_cloud_free(&in);
}
