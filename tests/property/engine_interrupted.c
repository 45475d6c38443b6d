/* How soon a cancel ends a run, what a stop hands back, and what a cap on memory lets through. */
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

int main(void)
{
    Suite *suite = suite_create("engine_interrupted");

    vt_add(suite, a_cancel_starts_no_further_block);
    vt_add(suite, a_stop_at_any_question_hands_back_a_whole_cloud);
    vt_add(suite, a_job_beyond_its_cap_is_refused_and_within_its_peak_it_runs);
    return vt_run(suite);
}
