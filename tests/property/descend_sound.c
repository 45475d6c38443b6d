/* Runs that minimise an energy, on any shape, with one thread and three: as many points as asked
 * for. */
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { SHAPES = 6 };

/* Closed; with a border; with edges; flat, dense towards one side; a few places with many points;
 * hardly more than a plane. */
static void shape(struct vor_cloud *cloud, int kind)
{
    static void (*const make[SHAPES])(struct vor_cloud *, uint64_t,
                                      size_t) = {vt_cloud_sphere, vt_cloud_dome,   vt_cloud_box,
                                                 vt_cloud_square, vt_cloud_sphere, vt_cloud_square};

    make[kind](cloud, 3, kind == 5 ? 5 : 800);
    for (size_t i = 0; i < cloud->n; i++) {
        if (kind == 3)
            cloud->xyz[3 * i] *= cloud->xyz[3 * i];
        if (kind == 4)
            memcpy(&cloud->xyz[3 * i], &cloud->xyz[3 * (i % 40)], 3 * sizeof *cloud->xyz);
    }
}

VT_TEST_LOOP(any_shape_gives_the_points_asked_for_whatever_the_threads, SHAPES)
{
    static const char *const ways[3][2] = {
        {"metric", "lp"}, {"cells", "euclid"}, {"metric", "anisotropic"}};
    static const size_t points[4] = {1, 2, 7, 150};

    for (int k = 0; k < 4; k++) {
        uint64_t first = 0;

        for (unsigned threads = 1; threads <= 3; threads += 2) {
            struct vt_engine engine;
            struct vor_cloud in, out;
            struct vor_report report;

            shape(&in, _i);
            vt_engine_open(&engine, threads);
            vt_engine_count(&engine, "points", _i == 5 ? 1 + points[k] % 60 : points[k]);
            vt_engine_set(&engine, ways[k % 3][0], ways[k % 3][1]);
            vt_engine_set(&engine, "cells", k % 3 == 2 ? "euclid" : "metric");
            vt_engine_set(&engine, ways[k % 3][0], ways[k % 3][1]);
            vt_engine_set(&engine, "iterations", "4");
            vt_engine_set(&engine, k == 3 ? "patch" : "boundary", k == 3 ? "plane" : "free");
            vt_engine_resample(&engine, &out, &report, &in);
            for (size_t i = 0; i < 3 * out.n; i++)
                ck_assert(isfinite(out.xyz[i]));
            ck_assert_double_le(report.descent_worst, 1);
            if (threads == 1)
                first = vt_cloud_hash(&out);
            ck_assert(vt_cloud_hash(&out) == first);
            vor_cloud_free(&out);
            vor_cloud_free(&in);
            vt_engine_close(&engine);
        }
    }
}
