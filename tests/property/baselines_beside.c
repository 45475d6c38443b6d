/* The simple methods beside a result: the same result, numbers that can be measured
 * again, and what a stop leaves of them. */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_shape.h"
#include "tests/support/vt_trace.h"

enum { N = 4000, OUT = 500 };

static void open_engine(struct vt_engine *engine, unsigned threads, size_t points)
{
    vt_engine_open(engine, threads);
    vt_engine_count(engine, "points", points);
    vt_engine_set(engine, "baselines", "true");
}

VT_TEST_FIGURES(the_result_is_the_same_with_baselines_beside_it, 0)
{
    struct vor_report with, without;
    struct vt_engine engine;
    struct vor_cloud in, out;
    uint64_t hash;

    vt_cloud_torus(&in, 1, N);
    open_engine(&engine, 2, OUT);
    vt_engine_resample(&engine, &out, &with, &in);
    hash = vt_cloud_hash(&out);
    vor_cloud_free(&out);
    vt_engine_set(&engine, "baselines", "false");
    vt_engine_resample(&engine, &out, &without, &in);
    ck_assert(vt_cloud_hash(&out) == hash);
    ck_assert_int_eq(with.has_baselines, 1);
    ck_assert_int_eq(without.has_baselines, 0);
    ck_assert_double_eq(with.delta, without.delta);
    ck_assert_double_eq(with.ref_to_out.max, without.ref_to_out.max);
    vt_engine_close(&engine);
    vt_free_last(&out, &in);
}

/* Paper: Chen et al. 2018, Sec. 5.1. Of points spread by chance in a plane, delta is
 * sqrt(4 / pi - 1) = 0.52. */
VT_TEST_FIGURES(each_is_as_even_as_its_method_is_known_to_be, 2)
{
    struct vor_report report;
    struct vt_engine engine;
    struct vor_cloud in, out;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    open_engine(&engine, 2, OUT);
    vt_engine_resample(&engine, &out, &report, &in);
    ck_assert_uint_eq(report.kmeans.points, OUT);
    ck_assert_uint_eq(report.random.points, OUT);
    ck_assert_uint_eq(report.farthest.points, OUT);
    ck_assert_double_eq_tol((double)report.voxel.points, OUT, 0.02 * OUT);
    ck_assert_double_eq_tol(report.random.delta, 0.52, 0.06);
    ck_assert_double_lt(report.voxel.delta, 0.8 * report.random.delta);
    ck_assert_double_lt(report.farthest.delta, 0.5 * report.random.delta);
    ck_assert_double_lt(report.kmeans.delta, 0.5 * report.random.delta);
    ck_assert_double_lt(2 * report.delta, report.farthest.delta);
    ck_assert_double_lt(2 * report.delta, report.kmeans.delta);
    ck_assert_double_gt(report.six_share, report.kmeans.six_share);
    ck_assert_double_gt(report.kmeans.six_share, report.random.six_share);
    ck_assert_double_lt(report.farthest.ref_to_out.max, 0.6 * report.random.ref_to_out.max);
    ck_assert_double_lt(report.ref_to_out.mean, report.random.ref_to_out.mean);
    ck_assert_uint_eq(report.random.ref_to_out.points, N);
    vt_engine_close(&engine);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(kmeans_is_the_method_of_that_name, 0)
{
    struct vor_report beside, own;
    struct vt_engine engine;
    struct vor_cloud in, out;

    vt_cloud_box(&in, 5, N);
    open_engine(&engine, 2, OUT);
    vt_engine_resample(&engine, &out, &beside, &in);
    vor_cloud_free(&out);
    vt_engine_set(&engine, "method", "kmeans");
    vt_engine_resample(&engine, &out, &own, &in);
    ck_assert_double_eq(beside.kmeans.delta, own.delta);
    ck_assert_double_eq(beside.kmeans.sigma, own.sigma);
    ck_assert_double_eq(beside.kmeans.epsilon, own.epsilon);
    ck_assert_double_eq(beside.kmeans.spacing, own.spacing_mean);
    /* Those of the method lie on the surfaces that its last steps found. */
    ck_assert_double_eq_tol(beside.kmeans.six_share, own.six_share, 0.03);
    ck_assert_double_eq(beside.kmeans.ref_to_out.mean, own.ref_to_out.mean);
    ck_assert_double_eq(beside.kmeans.ref_to_out.max, own.ref_to_out.max);
    vt_engine_close(&engine);
    vt_free_last(&out, &in);
}

VT_TEST(records_tell_each_baseline_after_the_polish)
{
    static struct vt_trace trace;
    struct vor_report report;
    struct vt_engine engine;
    struct vor_cloud in, out;
    size_t last;

    vt_cloud_sphere(&in, 1, 800);
    open_engine(&engine, 2, 100);
    vt_trace_attach(&trace, &engine);
    vt_engine_resample(&engine, &out, &report, &in);
    ck_assert_uint_gt(trace.count, 5);
    last = trace.count - 5;
    ck_assert_int_eq(trace.record[last - 1].stage, VOR_RUN_STAGE_POLISH);
    for (uint32_t done = 0; done <= 4; done++) {
        const struct vor_record *record = &trace.record[last + done];

        ck_assert_int_eq(record->stage, VOR_RUN_STAGE_BASELINES);
        ck_assert_uint_eq(record->step, done);
        ck_assert_uint_eq(record->of, 4);
        ck_assert_uint_eq(record->ahead, 0);
        ck_assert_uint_eq(record->polish, report.polish_steps);
        ck_assert_double_eq(record->best_delta, report.delta);
    }
    ck_assert_int_eq(report.stages[report.stages_count - 1].stage, VOR_RUN_STAGE_BASELINES);
    ck_assert_uint_eq(report.stages[report.stages_count - 1].steps, 4);
    vt_engine_close(&engine);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(of_fewer_input_points_all_are_taken, 0)
{
    struct vor_report report;
    struct vt_engine engine;
    struct vor_cloud in, out;

    vt_cloud_sphere(&in, 1, 300);
    open_engine(&engine, 2, 900);
    vt_engine_resample(&engine, &out, &report, &in);
    ck_assert_uint_eq(out.n, 900);
    ck_assert_uint_eq(report.kmeans.points, 300);
    ck_assert_uint_eq(report.random.points, 300);
    ck_assert_uint_eq(report.farthest.points, 300);
    ck_assert_uint_le(report.voxel.points, 300);
    ck_assert_uint_ge(report.voxel.points, 290);
    ck_assert_double_eq(report.random.delta, report.farthest.delta);
    ck_assert_double_eq(report.farthest.ref_to_out.max, 0);
    vt_engine_close(&engine);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(filters_alone_have_no_baselines_beside_them, 0)
{
    struct vor_report report;
    struct vor_cloud in, out;

    vt_cloud_sphere(&in, 1, 800);
    vt_resample(&out, &report, &in, "baselines=true filters=mls");
    ck_assert_uint_eq(out.n, 800);
    ck_assert_int_eq(report.has_baselines, 0);
    vt_free_last(&out, &in);
}

static enum vor_answer stop(void *ctx)
{
    (void)ctx;
    return VOR_STOP;
}

VT_TEST(a_run_that_is_stopped_has_no_baselines)
{
    struct vor_watch watch = {.poll = stop};
    struct vor_report report;
    struct vt_engine engine;
    struct vor_cloud in, out;

    vt_cloud_sphere(&in, 1, 200);
    open_engine(&engine, 1, 40);
    engine.run.watch = &watch;
    vt_engine_resample(&engine, &out, &report, &in);
    ck_assert_uint_eq(out.n, 40);
    ck_assert_int_eq(report.stopped, VOR_STOPPED_CALLER);
    ck_assert_int_eq(report.has_baselines, 0);
    vt_engine_close(&engine);
    vt_free_last(&out, &in);
}
