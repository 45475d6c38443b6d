/* A run that is cancelled, stopped or short of memory at any moment: a clear status, nothing
 * written, nothing left behind. */
#include "core/metrics/measure.h"
#include "tests/support/vt_engine.h"

#include <stdatomic.h>
#include <string.h>

enum { N = 200 };

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

/* One run on a sphere, with the trap set; the number of questions asked. */
static vor_status run_trapped(struct vor_cloud *out, struct vor_report *report, struct trap *trap,
                              size_t points, unsigned threads)
{
    struct vor_watch watch = {.ctx = trap, .poll = ask};
    struct vt_engine engine;
    struct vor_cloud in;
    vor_status status;

    vt_engine_open(&engine, threads);
    engine.run.watch = &watch;
    vt_cloud_sphere(&in, 1, points);
    vt_engine_count(&engine, "points", points / 2);
    vt_engine_set(&engine, "iterations", "6");
    vt_engine_set(&engine, "polish", "4"); /* the questions are tried one by one */
    vt_engine_set(&engine, "normals", "fit");
    status = vt_engine_try(&engine, out, report, &in);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
    return status;
}

static unsigned questions_of(size_t points, unsigned threads)
{
    struct trap trap = {.at = UINT32_MAX};
    struct vor_cloud out;
    struct vor_report report;

    vt_assert_ok(run_trapped(&out, &report, &trap, points, threads));
    vor_cloud_free(&out);
    return atomic_load(&trap.asked);
}

START_TEST(a_cancel_at_any_question_ends_with_nothing)
{
    unsigned all = questions_of(N, 1);

    ck_assert_uint_gt(all, 20);
    for (unsigned at = 1; at <= all; at += VT_STEP) {
        struct trap trap = {.at = at, .answer = VOR_CANCEL};
        struct vor_cloud out;
        struct vor_report report;

        vt_assert_fails(VOR_E_CANCELLED, run_trapped(&out, &report, &trap, N, 1));
        ck_assert(out.n == 0 && out.xyz == NULL && report.points_out == 0);
        vt_assert_no_leak();
    }
}
END_TEST

/* At most the blocks in work are finished: no thread asks again. */
START_TEST(a_cancel_starts_no_further_block)
{
    static const unsigned moments[5] = {1, 7, 50, 120, 200};
    unsigned all = questions_of(4000, 3);

    for (int k = 0; k < 5; k++) {
        struct trap trap = {.at = moments[k], .answer = VOR_CANCEL};
        struct vor_cloud out;
        struct vor_report report;

        ck_assert_uint_gt(all, moments[k] + 20);
        vt_assert_fails(VOR_E_CANCELLED, run_trapped(&out, &report, &trap, 4000, 3));
        ck_assert_uint_lt(atomic_load(&trap.asked), moments[k] + 20);
        ck_assert_uint_eq(out.n, 0);
        vt_assert_no_leak();
    }
}
END_TEST

START_TEST(a_stop_at_any_question_hands_back_a_whole_cloud)
{
    unsigned all = questions_of(N, 1), by_caller = 0;

    for (unsigned at = 1; at <= all; at += VT_STEP) {
        struct trap trap = {.at = at, .answer = VOR_STOP};
        struct vor_cloud out;
        struct vor_report report;

        vt_assert_ok(run_trapped(&out, &report, &trap, N, 1));
        ck_assert_uint_eq(out.n, N / 2);
        ck_assert(report.stopped == VOR_STOPPED_CALLER || report.iterations == 6);
        by_caller += report.stopped == VOR_STOPPED_CALLER;
        ck_assert_ptr_nonnull(vor_cloud_find(&out, VOR_NORMAL));
        ck_assert_uint_eq(vt_coincident(&out), 0);
        vor_cloud_free(&out);
        vt_assert_no_leak();
    }
    /* The others are asked by normals=fit, at the end. */
    ck_assert_uint_gt(VT_STEP * by_caller, all / 4);
}
END_TEST

/* G11: every allocation in turn fails, until the run passes untouched. What FLANN allocates by
 * itself is outside. */
START_TEST(a_failure_of_any_allocation_ends_clearly_and_leaks_nothing)
{
    struct vt_engine engine;
    struct vor_cloud in, out;
    struct vor_report report;
    struct vor_memory memory;
    vor_status status = VOR_E_NOMEM;
    size_t fail;

    vt_engine_open(&engine, 2);
    engine.run.memory = &memory;
    vt_cloud_sphere(&in, 1, N);
    vt_assert_ok(vor_cloud_add_attribute(&in, "label", VOR_GENERIC, VOR_INT32, 1, NULL, &vt_err));
    memset(in.attributes[0].data, 7, N * sizeof(int32_t));
    vt_engine_set(&engine, _i == 0 ? "points" : "spacing", _i == 0 ? "100" : "0.4");
    vt_engine_set(&engine, "iterations", "5");
    vt_engine_set(&engine, "polish", "3");
    vt_engine_set(&engine, "normals", "fit");
    for (fail = 1; status != VOR_OK; fail += VT_STEP_FAILS) {
        ck_assert_uint_lt(fail, 1000);
        vor_memory_init(&memory, SIZE_MAX);
        memory.fail_at = fail;
        vor_cloud_init(&out, &memory);
        report.points_out = 77;
        status = vt_run_engine(&out, &report, &in, &engine.spec, &engine.run, &vt_err);
        if (status != VOR_OK) {
            ck_assert_msg(status == VOR_E_NOMEM, "allocation %zu: %s", fail, vt_err.message);
            ck_assert(vt_err.message[0] != '\0');
            ck_assert(out.n == 0 && report.points_out == 77);
        }
        vor_cloud_free(&out);
        ck_assert_msg(atomic_load(&memory.used) == 0, "allocation %zu: %zu bytes are left", fail,
                      atomic_load(&memory.used));
    }
    ck_assert_uint_gt(fail, 1);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
}
END_TEST

START_TEST(a_job_beyond_its_cap_is_refused_and_within_its_peak_it_runs)
{
    struct vt_engine engine;
    struct vor_cloud in, out;
    struct vor_report report;
    struct vor_memory memory;
    size_t peak;

    vt_engine_open(&engine, 2);
    engine.run.memory = &memory;
    vt_cloud_sphere(&in, 1, 2000);
    vt_engine_set(&engine, "points", "500");
    vt_engine_set(&engine, "iterations", "3");
    vt_engine_set(&engine, "polish", "3");
    vor_memory_init(&memory, SIZE_MAX);
    vt_engine_resample(&engine, &out, &report, &in);
    vor_cloud_free(&out);
    peak = atomic_load(&memory.peak);
    ck_assert_uint_eq(report.memory_peak_bytes, peak);
    for (size_t share = 0; share <= 8; share++) {
        vor_memory_init(&memory, share < 8 ? peak * share / 8 : peak);
        vor_cloud_init(&out, &memory);
        if (share < 8)
            vt_assert_fails(VOR_E_NOMEM,
                            vt_run_engine(&out, &report, &in, &engine.spec, &engine.run, &vt_err));
        else
            vt_assert_ok(vt_run_engine(&out, &report, &in, &engine.spec, &engine.run, &vt_err));
        ck_assert_uint_le(atomic_load(&memory.peak), memory.cap);
        vor_cloud_free(&out);
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
    vor_cloud_free(&in);
    vt_engine_close(&engine);
}
END_TEST

START_TEST(a_measure_short_of_memory_or_cancelled_leaks_nothing)
{
    struct vt_engine engine;
    struct vor_cloud in, reference;
    struct vor_memory memory;
    struct vor_measure measure = {.n = 77};
    struct trap trap = {.at = 2, .answer = VOR_CANCEL};
    struct vor_watch watch = {.ctx = &trap, .poll = ask};
    vor_status status = VOR_E_NOMEM;

    vt_engine_open(&engine, 2);
    engine.run.memory = &memory;
    vt_cloud_sphere(&in, 1, 3 * N);
    vt_cloud_sphere(&reference, 2, 3 * N);
    for (size_t fail = 1; status != VOR_OK; fail += VT_STEP_FAILS) {
        vor_memory_init(&memory, SIZE_MAX);
        memory.fail_at = fail;
        ck_assert_uint_eq(measure.n, 77);
        status = vor_measure_clouds(&measure, &in, &reference, 0, &engine.run, &vt_err);
        ck_assert(status == VOR_OK || status == VOR_E_NOMEM);
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
    ck_assert_uint_eq(measure.n, 3 * N);
    engine.run.watch = &watch;
    vor_memory_init(&memory, SIZE_MAX);
    vt_assert_fails(VOR_E_CANCELLED,
                    vor_measure_clouds(&measure, &in, &reference, 0, &engine.run, &vt_err));
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    vor_cloud_free(&reference);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("engine_interrupted");

    vt_add(suite, a_cancel_at_any_question_ends_with_nothing);
    vt_add(suite, a_cancel_starts_no_further_block);
    vt_add(suite, a_stop_at_any_question_hands_back_a_whole_cloud);
    vt_add_loop(suite, a_failure_of_any_allocation_ends_clearly_and_leaks_nothing, 2);
    vt_add(suite, a_job_beyond_its_cap_is_refused_and_within_its_peak_it_runs);
    vt_add(suite, a_measure_short_of_memory_or_cancelled_leaks_nothing);
    return vt_run(suite);
}
