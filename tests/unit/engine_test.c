/* The door of the engine: targets, stops, the report, measures. */
#include "core/metrics/measure.h"
#include "tests/support/vt_ask.h"

#include <math.h>
#include <string.h>

enum { N = 800 };

/* What the watch of a test does and has seen. */
struct spy {
    uint32_t records; /* of a step each */
    uint32_t results; /* told of a step once more: what is handed back */
    struct vor_record last, first, result;
    double now, step;            /* clock: read, then advanced by step */
    uint32_t stop_at, cancel_at; /* record number, counted from 1; 0 never */
    double best;                 /* least delta */
    int in_order;
};

static enum vor_answer see(void *ctx, const struct vor_record *record)
{
    struct spy *spy = ctx;

    if (spy->records > 0 && record->iteration == spy->last.iteration &&
        record->polish == spy->last.polish) {
        spy->result = *record;
        spy->results++;
        return VOR_CONTINUE;
    }
    spy->in_order &= record->iteration == spy->records;
    if (spy->records++ == 0)
        spy->first = *record;
    spy->last = *record;
    spy->best = fmin(spy->best, record->delta);
    if (spy->records == spy->cancel_at)
        return VOR_CANCEL;
    return spy->records == spy->stop_at ? VOR_STOP : VOR_CONTINUE;
}

static double tick(void *ctx)
{
    struct spy *spy = ctx;

    return spy->now += spy->step;
}

/* One run on a sphere with a spy. */
struct job {
    struct vt_engine engine;
    struct vor_watch watch;
    struct spy spy;
    struct vor_cloud in, out;
    struct vor_report report;
};

static void open_job(struct job *job)
{
    memset(job, 0, sizeof *job);
    job->spy.in_order = 1;
    job->spy.best = INFINITY;
    job->watch = (struct vor_watch){.ctx = &job->spy, .progress = see, .clock = tick};
    vt_engine_open(&job->engine, 2);
    job->engine.run.watch = &job->watch;
    vt_cloud_sphere(&job->in, 1, N);
}

static void run_job(struct job *job, const char *options)
{
    vt_ask_set(&job->engine, options);
    vt_engine_resample(&job->engine, &job->out, &job->report, &job->in);
}

static void close_job(struct job *job)
{
    vor_cloud_free(&job->out);
    vor_cloud_free(&job->in);
    vt_engine_close(&job->engine);
}

VT_TEST(explicit_iterations_are_run_to_the_last)
{
    static const size_t counts[5] = {0, 1, 2, 17, 60};

    for (int k = 0; k < 5; k++) {
        struct job job;

        open_job(&job);
        vt_engine_set(&job.engine, "points", "50");
        vt_engine_count(&job.engine, "iterations", counts[k]);
        run_job(&job, "polish=0");
        ck_assert_uint_eq(job.report.iterations, counts[k]);
        ck_assert_uint_eq(job.report.polish_steps, 0);
        ck_assert_uint_eq(job.spy.last.polish, 0);
        ck_assert_int_eq(job.report.stopped, VOR_STOPPED_ITERATIONS);
        ck_assert_uint_eq(job.spy.records, counts[k] + 1);
        ck_assert_uint_le(job.spy.results, 1);
        if (job.spy.results > 0)
            ck_assert_double_eq(job.spy.result.best_delta, job.report.delta);
        ck_assert(job.spy.in_order);
        ck_assert_uint_eq(job.out.n, 50);
        close_job(&job);
    }
}

VT_TEST(a_plateau_ends_the_default_only)
{
    struct job job;

    open_job(&job);
    run_job(&job, "points=12 polish=0");
    ck_assert_int_eq(job.report.stopped, VOR_STOPPED_PLATEAU);
    ck_assert_uint_gt(job.report.iterations, 10);
    ck_assert_uint_lt(job.report.iterations, 100);
    close_job(&job);
    open_job(&job);
    run_job(&job, "points=12 iterations=100");
    ck_assert_int_eq(job.report.stopped, VOR_STOPPED_ITERATIONS);
    ck_assert_uint_eq(job.report.iterations, 100);
    close_job(&job);
}

/* What the request does not name is left to the engine: how it iterates, and that it polishes. */
VT_TEST(a_request_without_more_iterates_briefly_and_is_polished)
{
    for (size_t points = 12; points <= 600; points *= 7) {
        struct job job;
        const double *value = job.report.parameters.value;

        open_job(&job);
        vt_engine_count(&job.engine, "points", points);
        run_job(&job, "");
        ck_assert_uint_gt(job.report.iterations, 0);
        ck_assert_uint_le(job.report.iterations, 12);
        ck_assert(job.report.stopped == VOR_STOPPED_ITERATIONS ||
                  job.report.stopped == VOR_STOPPED_PLATEAU);
        ck_assert_uint_eq(job.report.polish_steps, (uint32_t)value[VOR_PARAM_POLISH]);
        ck_assert_uint_gt(job.report.polish_steps, 0);
        ck_assert(!vor_spec_given(&job.report.parameters, VOR_PARAM_ANDERSON));
        close_job(&job);
    }
}

VT_TEST(a_delta_ends_the_run_at_the_first_iterate_that_reaches_it)
{
    struct job job;

    open_job(&job);
    run_job(&job, "points=200 iterations=200 polish=0 delta=0.12");
    ck_assert_int_eq(job.report.stopped, VOR_STOPPED_DELTA);
    ck_assert_double_le(job.spy.last.delta, 0.12);
    ck_assert_double_gt(job.spy.first.delta, 0.12);
    ck_assert_uint_lt(job.report.iterations, 200);
    ck_assert_double_eq_tol(job.report.delta, job.spy.last.delta, 0.005);
    close_job(&job);
    open_job(&job);
    run_job(&job, "points=200 delta=10");
    ck_assert_int_eq(job.report.stopped, VOR_STOPPED_DELTA);
    ck_assert_uint_eq(job.report.iterations, 0);
    close_job(&job);
}

/* The clock advances by 0.25 s at every reading; the budget is met, not passed. */
VT_TEST(a_budget_of_seconds_ends_the_run_by_the_watchs_clock)
{
    struct job job;

    open_job(&job);
    job.spy.step = 0.25;
    run_job(&job, "points=100 iterations=1000 polish=0 seconds=10");
    ck_assert_int_eq(job.report.stopped, VOR_STOPPED_SECONDS);
    ck_assert_uint_gt(job.report.iterations, 5);
    ck_assert_double_le(job.spy.last.seconds, 10);
    ck_assert_double_gt(job.spy.last.seconds, 9);
    close_job(&job);
}

VT_TEST(without_a_clock_no_budget_ends_the_run)
{
    struct job job;

    open_job(&job);
    job.watch.clock = NULL;
    run_job(&job, "points=50 iterations=5 seconds=0");
    ck_assert_int_eq(job.report.stopped, VOR_STOPPED_ITERATIONS);
    ck_assert(job.report.seconds_iterate == 0 && job.spy.last.seconds == 0);
    close_job(&job);
}

VT_TEST(a_caller_who_stops_gets_the_best_cloud_so_far)
{
    for (uint32_t at = 1; at <= 20; at += 6) {
        struct job job;

        open_job(&job);
        job.spy.stop_at = at;
        run_job(&job, "points=150 iterations=20");
        ck_assert_int_eq(job.report.stopped, VOR_STOPPED_CALLER);
        ck_assert_uint_eq(job.report.iterations, at - 1);
        ck_assert_uint_eq(job.out.n, 150);
        ck_assert_double_le(job.report.delta, job.spy.first.delta * 1.02);
        close_job(&job);
    }
}

/* The last iterate need not be the best: on a coarse cloud delta goes up and down. Putting the
 * points onto the surface once more costs some of it. */
VT_TEST(the_result_is_the_most_even_iterate)
{
    unsigned last_is_worse = 0;

    for (size_t seed = 1; seed <= 12; seed++) {
        struct job job;

        open_job(&job);
        vt_ask_set(&job.engine, "points=60 iterations=40 anderson=0 polish=0");
        vt_engine_count(&job.engine, "seed", seed);
        run_job(&job, "");
        ck_assert_double_le(job.report.delta, 1.04 * job.spy.best);
        if (job.spy.last.delta > 1.005 * job.spy.best) {
            ck_assert_double_lt(job.report.delta, (job.spy.last.delta + job.spy.best) / 2);
            last_is_worse++;
        }
        close_job(&job);
    }
    ck_assert_uint_gt(last_is_worse, 0);
}

VT_TEST(the_report_says_what_the_result_is)
{
    struct job job;
    struct vor_measure measure;

    open_job(&job);
    job.spy.step = 0.5;
    run_job(&job, "ratio=0.25 neighbors=auto iterations=10");
    vt_assert_ok(vor_measure_clouds(&measure, &job.out, &job.in, 0, &job.engine.run, &vt_err));
    ck_assert_uint_eq(job.report.points_in, N);
    ck_assert_uint_eq(job.report.points_out, N / 4);
    ck_assert_double_eq_tol(job.report.delta, measure.delta, 1e-5);
    ck_assert_double_eq_tol(job.report.sigma, measure.sigma, 1e-5);
    ck_assert_double_eq_tol(job.report.epsilon, measure.epsilon, 1e-5);
    ck_assert_double_eq_tol(job.report.spacing_mean, measure.mean_nn, 1e-6);
    ck_assert_double_eq_tol(job.report.area, 4 * M_PI, 0.3);
    ck_assert(job.report.parameters.value[VOR_PARAM_POINTS] == N / 4);
    ck_assert(job.report.parameters.value[VOR_PARAM_NEIGHBORS] == 20);
    ck_assert(job.report.seconds_index > 0 && job.report.seconds_init > 0 &&
              job.report.seconds_iterate > 0);
    ck_assert(job.report.seconds_read == 0 && job.report.seconds_write == 0);
    ck_assert_uint_ge(job.report.memory_peak_bytes, N * 12);
    ck_assert_uint_eq(job.report.memory_peak_bytes, atomic_load(&vt_memory.peak));
    close_job(&job);
}

static void assert_refused(struct job *job, vor_status status, const char *parameter)
{
    vor_cloud_init(&job->out, &vt_memory);
    vt_assert_fails(status, vt_run_engine(&job->out, &job->report, &job->in, &job->engine.spec,
                                          &job->engine.run, &vt_err));
    ck_assert_str_eq(vt_err.parameter, parameter);
    ck_assert_uint_eq(job->out.n, 0);
    ck_assert_uint_eq(job->report.points_out, 0);
    ck_assert_uint_eq(job->spy.records, 0);
}

VT_TEST(a_number_of_points_out_of_range_is_refused_by_value_and_range)
{
    static const struct {
        const char *name, *text, *says;
    } requests[6] = {{"points", "12801", "1 to 12800"},  {"ratio", "0.0001", "0 points"},
                     {"spacing", "100", "0 points"},     {"spacing", "0.001", "1 to 12800"},
                     {"spacing", "1e-20", "1 to 12800"}, {"spacing", "1e30", "0 points"}};

    for (int k = 0; k < 6; k++) {
        struct job job;

        open_job(&job);
        vt_engine_set(&job.engine, requests[k].name, requests[k].text);
        assert_refused(&job, VOR_E_TARGET, requests[k].name);
        ck_assert_msg(strstr(vt_err.message, requests[k].says) != NULL, "%s", vt_err.message);
        close_job(&job);
    }
}

/* Hand values, in a frame of another origin and with the reference in yet another. */
VT_TEST(a_measure_has_its_hand_computed_values)
{
    static const float xyz[9] = {0, 0, 0, 1, 0, 0, 3, 0, 0};
    struct vt_engine engine;
    struct vor_cloud cloud, reference;
    struct vor_measure m;

    vt_engine_open(&engine, 1);
    vt_cloud_make(&cloud, 3);
    memcpy(cloud.xyz, xyz, sizeof xyz);
    cloud.origin[0] = 500000;
    vt_assert_ok(vor_measure_clouds(&m, &cloud, NULL, 0, &engine.run, &vt_err));
    ck_assert_uint_eq(m.n, 3);
    ck_assert(!m.has_reference);
    ck_assert_double_eq_tol(m.mean_nn, 4.0 / 3, 1e-7);
    ck_assert_double_eq_tol(m.delta, sqrt(0.125), 1e-7);
    ck_assert_double_eq_tol(m.sigma, 4.0 / 9, 1e-7);
    ck_assert_double_eq_tol(m.min_over_mean, 0.75, 1e-7);
    ck_assert_double_eq_tol(m.max_over_mean, 1.5, 1e-7);
    ck_assert_uint_eq(m.coincident, 0);
    vt_cloud_make(&reference, 7);
    for (int i = 0; i < 21; i++)
        reference.xyz[i] = i % 3 == 0 ? (float)(i / 3) - 2 : 0;
    reference.origin[0] = 500002;
    reference.origin[1] = 0.5;
    vt_assert_ok(vor_measure_clouds(&m, &cloud, &reference, 0, &engine.run, &vt_err));
    ck_assert(m.has_reference);
    ck_assert_double_eq_tol(m.out_to_ref_mean, 0.5, 1e-6);
    ck_assert_double_eq_tol(m.out_to_ref_max, 0.5, 1e-6);
    ck_assert_double_eq_tol(m.ref_to_out_max, hypot(3, 0.5), 1e-6);
    ck_assert_double_eq_tol(m.hausdorff_relative, hypot(3, 0.5) / 6, 1e-6);
    vt_engine_close(&engine);
    vt_free_last(&reference, &cloud);
}

VT_TEST(a_measure_of_no_extent_is_refused)
{
    struct vt_engine engine;
    struct vor_cloud cloud, reference;
    struct vor_measure m = {.n = 77};

    vt_engine_open(&engine, 1);
    vt_cloud_cube(&reference, 1, 6);
    for (size_t n = 1; n <= 3; n++) {
        vt_cloud_make(&cloud, n);
        for (size_t i = 0; i < 3 * n; i++)
            cloud.xyz[i] = 3;
        vt_assert_fails(VOR_E_DEGENERATE,
                        vor_measure_clouds(&m, &cloud, NULL, 0, &engine.run, &vt_err));
        vor_cloud_free(&cloud);
    }
    vt_cloud_cube(&cloud, 1, 50);
    vt_assert_fails(VOR_E_DEGENERATE,
                    vor_measure_clouds(&m, &cloud, &reference, 0, &engine.run, &vt_err));
    ck_assert_uint_eq(m.n, 77);
    vt_engine_close(&engine);
    vt_free_last(&cloud, &reference);
}
