/* Inputs of many more points than the result: they are iterated on some of their points and end on
 * all of them, whatever ends the run. */
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <stdlib.h>

enum { SEEDS = 3, DENSE = 60000, FEW = 800, RECORDS = 200 };

#define WAVE 0.002 /* height of waves that the thinner input is too coarse for */
#define OFF (WAVE / 50)

/* A sheet with waves. */
static void make_waves(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_square(cloud, seed, n);
    for (size_t i = 0; i < n; i++)
        cloud->xyz[3 * i + 2] = (float)(WAVE * sin(200 * (double)cloud->xyz[3 * i]));
}

static double off_waves(const double x[3])
{
    return fabs(x[2] - WAVE * sin(200 * x[0]));
}

static const struct vt_shape waves = {"waves", make_waves, off_waves, 1};

static void open_run(struct vt_engine *engine, unsigned threads, const char *polish)
{
    vt_engine_open(engine, threads);
    vt_engine_count(engine, "points", FEW);
    vt_engine_set(engine, "polish", polish);
}

static void assert_whole(const struct vor_cloud *out, const struct vt_shape *shape)
{
    ck_assert_uint_eq(out->n, FEW);
    ck_assert_uint_eq(vt_coincident(out), 0);
    ck_assert_msg(vt_off_mean(shape, out) < OFF, "%s: %g off", shape->name,
                  vt_off_mean(shape, out));
}

VT_TEST_FIGURES(the_result_lies_on_all_of_the_input, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    static const char *const ends[][2] = {
        {"0", "0"}, {"0", "12"}, {"30", "3"}, {"120", "0"}, {"120", "12"}}; /* polish, iterations */
    struct vor_cloud in, out;
    struct vor_report report;

    waves.make(&in, (uint64_t)_i, 4 * DENSE);
    for (size_t k = 0; k < sizeof ends / sizeof *ends; k++) {
        struct vt_engine engine;

        open_run(&engine, 2, ends[k][0]);
        vt_engine_set(&engine, "iterations", ends[k][1]);
        vt_engine_resample(&engine, &out, &report, &in);
        assert_whole(&out, &waves);
        vor_cloud_free(&out);
        vt_engine_close(&engine);
    }
    vor_cloud_free(&in);
}

VT_TEST_FIGURES(a_run_without_limits_ends_as_even_as_one_on_few_points,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS) * VT_SMOOTH))
{
    const struct vt_shape *shape = &vt_shapes[_i % VT_SMOOTH];
    struct vor_report dense, sparse;
    struct vor_cloud in, out;

    for (int polish = 0; polish < 2; polish++) {
        struct vt_engine engine;

        open_run(&engine, 2, polish ? "120" : "0");
        shape->make(&in, (uint64_t)_i, DENSE);
        vt_engine_resample(&engine, &out, &dense, &in);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
        shape->make(&in, (uint64_t)_i, DENSE / 6);
        vt_engine_resample(&engine, &out, &sparse, &in);
        ck_assert_msg(dense.delta < 1.15 * sparse.delta, "delta %g, of few %g", dense.delta,
                      sparse.delta);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
        vt_engine_close(&engine);
    }
}

VT_TEST_FIGURES(a_delta_that_is_asked_for_holds_of_the_result, VT_FEWER(VT_SMOOTH))
{
    static const char *const wanted[] = {"0.2", "0.09", "0.06", "0.035", "0.001"};
    const struct vt_shape *shape = &vt_shapes[_i % VT_SMOOTH];
    struct vor_cloud in, out;
    struct vor_report report;
    unsigned stopped = 0;

    shape->make(&in, (uint64_t)_i, DENSE);
    for (size_t k = 0; k < 5; k++)
        for (int polish = 0; polish < 2; polish++) {
            struct vt_engine engine;

            open_run(&engine, 2, polish ? "120" : "0");
            vt_engine_set(&engine, "delta", wanted[k]);
            vt_engine_resample(&engine, &out, &report, &in);
            if (report.stopped == VOR_STOPPED_DELTA) {
                ck_assert_double_le(report.delta, atof(wanted[k]));
                stopped++;
            }
            vor_cloud_free(&out);
            vt_engine_close(&engine);
        }
    ck_assert_uint_ge(stopped, 5);
    vor_cloud_free(&in);
}

struct stopper {
    unsigned left, told;
};

static enum vor_answer stop_at(void *ctx, const struct vor_record *record)
{
    struct stopper *stopper = ctx;

    (void)record;
    stopper->told++;
    return stopper->left-- == 0 ? VOR_STOP : VOR_CONTINUE;
}

VT_TEST_LOOP(stopped_at_any_record_it_hands_back_points_of_the_whole, 1)
{
    struct vor_report report = {0};
    struct vor_cloud in, out;
    unsigned at;

    waves.make(&in, (uint64_t)_i, 4 * DENSE);
    for (int polish = 0; polish < 2; polish++) {
        report.stopped = VOR_STOPPED_CALLER;
        for (at = 0; report.stopped == VOR_STOPPED_CALLER && at < RECORDS; at += 8) {
            struct stopper stopper = {at, 0};
            struct vor_watch watch = {.ctx = &stopper, .progress = stop_at};
            struct vt_engine engine;

            open_run(&engine, 2, polish ? "60" : "0");
            vt_engine_set(&engine, "iterations", "8");
            engine.run.watch = &watch;
            vt_engine_resample(&engine, &out, &report, &in);
            assert_whole(&out, &waves);
            vor_cloud_free(&out);
            vt_engine_close(&engine);
        }
        ck_assert_uint_gt(at, 9); /* more than one was */
        ck_assert_uint_lt(at, RECORDS);
    }
    vor_cloud_free(&in);
}

/* An open cloud: nobody is left where only the thinner input allowed it. */
VT_TEST_FIGURES(nobody_is_left_beyond_a_border, VT_FEWER(SEEDS))
{
    struct vor_cloud in, out;
    struct vor_report report;
    double spacing = sqrt(1.0 / DENSE), most = 0;

    vt_cloud_square(&in, (uint64_t)_i, DENSE);
    for (int polish = 0; polish < 2; polish++) {
        struct vt_engine engine;

        open_run(&engine, 2, polish ? "120" : "0");
        vt_engine_resample(&engine, &out, &report, &in);
        for (size_t i = 0; i < out.n; i++) {
            double x[3];

            vor_cloud_position(&out, i, x);
            for (int c = 0; c < 2; c++)
                most = fmax(most, fmax(-x[c], x[c] - 1));
        }
        ck_assert_msg(most <= 2 * spacing, "%g spacings out", most / spacing);
        vor_cloud_free(&out);
        vt_engine_close(&engine);
    }
    vor_cloud_free(&in);
}
