/* Edges of an exact input are rounded off less than the fit of one number of neighbours does. */
#include "tests/support/vt_engine.h"

#include <math.h>

enum { SEEDS = 4, N = 6000, POINTS = 1500 };

/* Distance from the surface of the unit cube that vt_cloud_box lies on. */
static double off_box(const double x[3])
{
    double outside2 = 0, inside = INFINITY;

    for (int c = 0; c < 3; c++) {
        double d = fabs(x[c] - 0.5) - 0.5;

        outside2 += d > 0 ? d * d : 0;
        inside = fmin(inside, -d);
    }
    return outside2 > 0 ? sqrt(outside2) : inside;
}

static double mean_off(const struct vor_cloud *in, const char *neighbors)
{
    struct vt_engine engine;
    struct vor_report report;
    struct vor_cloud out;
    double sum = 0, x[3];

    vt_engine_open(&engine, 2);
    vt_engine_count(&engine, "points", POINTS);
    vt_engine_set(&engine, "neighbors", neighbors);
    vt_engine_resample(&engine, &out, &report, in);
    for (size_t i = 0; i < out.n; i++) {
        vor_cloud_position(&out, i, x);
        sum += off_box(x);
    }
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return sum / POINTS;
}

/* With 21 neighbours nothing is fitted to fewer of them. */
VT_TEST_LOOP(points_lie_nearer_to_the_edges_of_a_box, VT_FEWER(SEEDS))
{
    struct vor_cloud in;
    double fine, coarse;

    vt_cloud_box(&in, (uint64_t)_i, N);
    fine = mean_off(&in, "20");
    coarse = mean_off(&in, "21");
    ck_assert_msg(fine < 0.88 * coarse, "%g against %g", fine, coarse);
    vor_cloud_free(&in);
}

/* Regression: the border of a small sheet is a large share of it, and counted as gaps of the
 * sampling. Points were .94 beyond it. */
VT_TEST_LOOP(an_open_sheet_does_not_grow, 2)
{
    enum { SIDE = 24 };
    struct vt_engine engine;
    struct vor_report report;
    struct vor_cloud in, out;

    vt_cloud_lattice(&in, SIDE);
    vt_engine_open(&engine, 2);
    vt_engine_count(&engine, "points", 4 * in.n);
    vt_engine_count(&engine, "iterations", _i == 0 ? 1 : 12);
    vt_engine_count(&engine, "polish", _i == 0 ? 8 : 60);
    vt_engine_resample(&engine, &out, &report, &in);
    for (size_t i = 0; i < 3 * out.n; i++)
        ck_assert_msg(i % 3 == 2 || (out.xyz[i] > in.xyz[i % 3] - 0.5F &&
                                     out.xyz[i] < in.xyz[i % 3] + SIDE - 0.5F),
                      "coordinate %zu is %g", i, (double)out.xyz[i]);
    ck_assert_double_lt(report.delta, 0.2);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
}
