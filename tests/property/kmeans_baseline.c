/* The baseline k-means as a request runs it: exactly n points, the same for any number of threads,
 * interrupted at any moment, and its refusals. */
#include "tests/support/vt_shape.h"
#include "tests/support/vt_trace.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { N = 3000, OUT = 500, STEPS = 8 };

static void open_engine(struct vt_engine *engine, unsigned threads, size_t points)
{
    vt_engine_open(engine, threads);
    vt_engine_set(engine, "method", "kmeans");
    vt_engine_count(engine, "points", points);
}

START_TEST(it_gives_exactly_n_points_on_the_surface)
{
    static const size_t counts[] = {1, 2, 7, OUT, N};
    const struct vt_shape *sphere = &vt_shapes[VT_SPHERE];
    struct vor_cloud in, out;

    sphere->make(&in, 1, N);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        static struct vt_trace trace;
        struct vor_report report;
        struct vt_engine engine;

        open_engine(&engine, 2, counts[i]);
        vt_engine_count(&engine, "iterations", STEPS);
        vt_trace_attach(&trace, &engine);
        vt_engine_resample(&engine, &out, &report, &in);
        ck_assert_uint_eq(out.n, counts[i]);
        ck_assert_uint_eq(report.iterations, STEPS);
        ck_assert_uint_eq(report.polish_steps, 0);
        ck_assert_int_eq(report.stopped, VOR_STOPPED_ITERATIONS);
        ck_assert_uint_ge(trace.count, STEPS + 1);
        for (uint32_t step = 0; step <= STEPS; step++) {
            ck_assert_uint_eq(trace.record[step].step, step);
            ck_assert_uint_eq(trace.record[step].of, STEPS);
        }
        if (counts[i] >= OUT) /* means of the points of a cell alone lie 1 / (2 OUT) inside */
            ck_assert_double_le(vt_off_mean(sphere, &out), 0.2 / (2 * OUT));
        vor_cloud_free(&out);
        vt_engine_close(&engine);
    }
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

/* A baseline: more even than the random subset it starts at, less than the default method. */
START_TEST(it_is_more_even_than_chance_and_less_than_cells)
{
    static struct vt_trace trace;
    struct vor_report kmeans, cvt;
    struct vt_engine engine;
    struct vor_cloud in, out;

    vt_shapes[VT_SPHERE].make(&in, 2, N);
    open_engine(&engine, 2, OUT);
    vt_trace_attach(&trace, &engine);
    vt_engine_resample(&engine, &out, &kmeans, &in);
    vor_cloud_free(&out);
    vt_engine_set(&engine, "method", "cvt");
    engine.run.watch = NULL;
    vt_engine_resample(&engine, &out, &cvt, &in);
    ck_assert_double_lt(kmeans.delta, 0.6 * trace.record[0].delta);
    ck_assert_double_gt(kmeans.delta, 2 * cvt.delta);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
    vt_assert_no_leak();
}
END_TEST

START_TEST(one_two_three_and_eight_threads_give_the_same_bytes)
{
    static const unsigned threads[] = {1, 2, 3, 8};
    struct vor_cloud in, out;
    uint64_t first = 0;

    vt_cloud_box(&in, 3, N);
    for (size_t i = 0; i < sizeof threads / sizeof *threads; i++) {
        struct vt_engine engine;
        struct vor_report report;

        open_engine(&engine, threads[i], OUT);
        vt_engine_resample(&engine, &out, &report, &in);
        first = i == 0 ? vt_cloud_hash(&out) : first;
        ck_assert(vt_cloud_hash(&out) == first);
        vor_cloud_free(&out);
        vt_engine_close(&engine);
    }
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

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

static vor_status run_trapped(struct vor_cloud *out, struct vor_report *report, struct trap *trap)
{
    struct vor_watch watch = {.ctx = trap, .poll = ask};
    struct vt_engine engine;
    struct vor_cloud in;
    vor_status status;

    open_engine(&engine, 1, 50);
    vt_engine_count(&engine, "iterations", STEPS);
    engine.run.watch = &watch;
    vt_cloud_sphere(&in, 1, 200);
    status = vt_engine_try(&engine, out, report, &in);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
    return status;
}

START_TEST(a_cancel_ends_with_nothing_and_a_stop_with_all_points)
{
    struct trap all = {.at = UINT32_MAX};
    unsigned by_caller = 0;
    struct vor_report report;
    struct vor_cloud out;

    vt_assert_ok(run_trapped(&out, &report, &all));
    vor_cloud_free(&out);
    ck_assert_uint_gt(atomic_load(&all.asked), 20);
    for (unsigned at = 1; at <= atomic_load(&all.asked); at += VT_STEP) {
        struct trap cancel = {.at = at, .answer = VOR_CANCEL};
        struct trap stop = {.at = at, .answer = VOR_STOP};

        vt_assert_fails(VOR_E_CANCELLED, run_trapped(&out, &report, &cancel));
        ck_assert(out.n == 0 && out.xyz == NULL);
        vt_assert_ok(run_trapped(&out, &report, &stop));
        ck_assert_uint_eq(out.n, 50);
        by_caller += report.stopped == VOR_STOPPED_CALLER;
        vor_cloud_free(&out);
        vt_assert_no_leak();
    }
    ck_assert_uint_gt(VT_STEP * by_caller, STEPS);
}
END_TEST

START_TEST(a_failure_of_any_allocation_ends_clearly_and_leaks_nothing)
{
    struct vt_engine engine;
    struct vor_memory memory;
    struct vor_cloud in, out;
    struct vor_report report;
    vor_status status = VOR_E_NOMEM;

    open_engine(&engine, 2, 50);
    vt_engine_count(&engine, "iterations", 2);
    engine.run.memory = &memory;
    vt_cloud_sphere(&in, 1, 200);
    for (size_t fail = 1; status != VOR_OK; fail += VT_STEP) {
        ck_assert_uint_lt(fail, 1000);
        vor_memory_init(&memory, SIZE_MAX);
        memory.fail_at = fail;
        vor_cloud_init(&out, &memory);
        status = vt_run_engine(&out, &report, &in, &engine.spec, &engine.run, &vt_err);
        ck_assert(status == VOR_OK || status == VOR_E_NOMEM);
        vor_cloud_free(&out);
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
    vor_cloud_free(&in);
    vt_engine_close(&engine);
}
END_TEST

START_TEST(more_points_than_the_input_has_are_refused)
{
    struct vt_engine engine;
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, 1, 200);
    memcpy(&in.xyz[3], in.xyz, 3 * sizeof *in.xyz); /* in one place with another */
    open_engine(&engine, 2, 200);
    vt_assert_fails(VOR_E_TARGET, vt_engine_try(&engine, &out, &report, &in));
    ck_assert_str_eq(vt_err.message,
                     "200 points are asked for, want 1 to 199: kmeans takes means of the input's "
                     "points at different places");
    ck_assert_uint_eq(out.n, 0);
    vt_engine_set(&engine, "points", "100");
    vt_engine_set(&engine, "density", "curvature");
    vt_assert_fails(VOR_E_DENSITY, vt_engine_try(&engine, &out, &report, &in));
    ck_assert_str_eq(vt_err.message,
                     "method kmeans follows no density, want uniform, or method cvt");
    ck_assert_uint_eq(out.n, 0);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("kmeans_baseline");

    vt_add(suite, it_gives_exactly_n_points_on_the_surface);
    vt_add(suite, it_is_more_even_than_chance_and_less_than_cells);
    vt_add(suite, one_two_three_and_eight_threads_give_the_same_bytes);
    vt_add(suite, a_cancel_ends_with_nothing_and_a_stop_with_all_points);
    vt_add(suite, a_failure_of_any_allocation_ends_clearly_and_leaks_nothing);
    vt_add(suite, more_points_than_the_input_has_are_refused);
    return vt_run(suite);
}
