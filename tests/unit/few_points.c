/* Inputs of so few points that they do not say how the surface goes on beyond them. */
#include "tests/support/vt_ask.h"

#include <math.h>

enum { FEWEST = 4, MOST = 15, SEEDS = 1 };

/* A tenth of the largest side, and what float32 rounds off. */
static const double room = 0.1 + 1e-6;

/* Points of a cube, a slab and a sphere. */
static void few_points(struct vor_cloud *cloud, uint64_t seed, int shape, size_t n)
{
    if (shape == 2)
        vt_cloud_sphere(cloud, seed, n);
    else
        vt_cloud_cube(cloud, seed, n);
    for (size_t i = 0; shape == 1 && i < n; i++)
        cloud->xyz[3 * i + 2] /= 10;
}

struct box {
    double low[3], high[3];
};

static struct box box_of(const struct vor_cloud *cloud)
{
    struct box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

    for (size_t i = 0; i < cloud->n; i++) {
        double x[3];

        vor_cloud_position(cloud, i, x);
        for (int c = 0; c < 3; c++) {
            box.low[c] = fmin(box.low[c], x[c]);
            box.high[c] = fmax(box.high[c], x[c]);
        }
    }
    return box;
}

VT_TEST_LOOP(few_points_give_a_result_near_their_box, 3 * (MOST - FEWEST + 1) * SEEDS)
{
    int shape = _i % 3;
    size_t n = FEWEST + (size_t)(_i / 3) % (MOST - FEWEST + 1);
    uint64_t seed = 1 + (uint64_t)(_i / 3) / (MOST - FEWEST + 1);
    struct vor_cloud in, out;
    struct vor_report report;
    struct box before, after;
    double side = 0;

    few_points(&in, seed, shape, n);
    before = box_of(&in);
    vt_resample(&out, &report, &in, "points=%zu", 5 * n);
    after = box_of(&out);
    for (int c = 0; c < 3; c++)
        side = fmax(side, before.high[c] - before.low[c]);
    for (int c = 0; c < 3; c++) {
        ck_assert_double_ge(after.low[c], before.low[c] - room * side);
        ck_assert_double_le(after.high[c], before.high[c] + room * side);
    }
    ck_assert_uint_eq(out.n, 5 * n);
    ck_assert_uint_eq(vt_coincident(&out), 0);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
}
