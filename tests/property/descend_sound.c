/* Runs that minimise an energy, on any shape, stopped at any moment, with any number of
 * threads: as many points as asked for. */
#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { N = 80, SHAPES = 6 };

/* Answers with `answer` from the at-th question on. */
struct trap {
    atomic_uint asked;
    unsigned at;
    enum vor_answer answer;
};

static enum vor_answer ask(void *ctx)
{
    struct trap *trap = ctx;

    return atomic_fetch_add(&trap->asked, 1) + 1 >= trap->at ? trap->answer : VOR_CONTINUE;
}

/* One run of three iterations on half a sphere. */
static vor_status run(struct vor_cloud *out, struct vor_report *report, struct trap *trap,
                      struct vor_memory *memory)
{
    struct vor_watch watch = {.ctx = trap, .poll = ask};
    struct vt_engine engine;
    struct vor_cloud in;
    vor_status status;

    vt_engine_open(&engine, 1);
    engine.run.watch = &watch;
    engine.run.memory = memory;
    vt_cloud_dome(&in, 1, N);
    vt_engine_count(&engine, "points", N / 2);
    vt_engine_set(&engine, "metric", "lp");
    vt_engine_set(&engine, "iterations", "3");
    status = vt_engine_try(&engine, out, report, &in);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
    return status;
}

static unsigned questions(void)
{
    struct trap trap = {.at = UINT32_MAX};
    struct vor_cloud out;
    struct vor_report report;

    vt_assert_ok(run(&out, &report, &trap, &vt_memory));
    ck_assert_uint_eq(report.iterations, 3);
    vor_cloud_free(&out);
    return atomic_load(&trap.asked);
}

START_TEST(a_stop_at_any_question_hands_back_the_last_whole_iterate)
{
    unsigned all = questions(), by_caller = 0;

    for (unsigned at = 1; at <= all; at += VT_STEP) {
        struct trap trap = {.at = at, .answer = VOR_STOP};
        struct vor_cloud out;
        struct vor_report report;

        vt_assert_ok(run(&out, &report, &trap, &vt_memory));
        ck_assert_uint_eq(out.n, N / 2);
        ck_assert_uint_eq(vt_coincident(&out), 0);
        ck_assert(report.stopped == VOR_STOPPED_CALLER || report.iterations == 3);
        by_caller += report.stopped == VOR_STOPPED_CALLER;
        vor_cloud_free(&out);
        vt_assert_no_leak();
    }
    ck_assert_uint_gt(VT_STEP * by_caller, all / 4);
}
END_TEST

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

START_TEST(any_shape_gives_the_points_asked_for_whatever_the_threads)
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
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("descend_sound");

    vt_add(suite, a_stop_at_any_question_hands_back_the_last_whole_iterate);
    vt_add_loop(suite, any_shape_gives_the_points_asked_for_whatever_the_threads, SHAPES);
    return vt_run(suite);
}
