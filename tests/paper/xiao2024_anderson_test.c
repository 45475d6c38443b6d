/* Xiao et al. 2024, Sec. IV-C: Lloyd's method with Anderson acceleration and its safeguard. */
#include "tests/support/vt_trace.h"

enum { SEEDS = 4, PLAIN = 50 };

/* Without a window: the engine's own, which is momentum. */
static void trace_some(struct vt_trace *trace, const struct vor_cloud *in, size_t points,
                       size_t iterations, const char *window, uint64_t seed)
{
    struct vt_engine engine;
    struct vor_cloud out;
    struct vor_report report;

    vt_engine_open(&engine, 2);
    vt_trace_attach(trace, &engine);
    vt_engine_count(&engine, "points", points);
    vt_engine_count(&engine, "iterations", iterations);
    if (window != NULL)
        vt_engine_set(&engine, "anderson", window);
    vt_engine_set(&engine, "polish", "0");
    vt_engine_count(&engine, "seed", (size_t)seed);
    vt_engine_resample(&engine, &out, &report, in);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
}

static void trace_of(struct vt_trace *trace, const struct vor_cloud *in, const char *window,
                     uint64_t seed)
{
    trace_some(trace, in, 700, PLAIN, window, seed);
}

/* Eq. 12 as its text has it. Both runs start alike; until two iterates are known there is nothing
 * to mix; at the second iteration the plain step is one of the two candidates. */
VT_TEST_LOOP(eq_12_an_accelerated_iteration_is_at_least_as_even_as_the_plain_one, VT_FEWER(SEEDS))
{
    static struct vt_trace plain, mixed;
    struct vor_cloud in;

    if (_i % 2)
        vt_cloud_sphere(&in, (uint64_t)_i, 4000);
    else
        vt_cloud_box(&in, (uint64_t)_i, 4000);
    trace_some(&plain, &in, 700, 2, "0", (uint64_t)_i);
    trace_some(&mixed, &in, 700, 2, "4", (uint64_t)_i);
    ck_assert(mixed.record[0].delta == plain.record[0].delta);
    ck_assert(mixed.record[1].delta == plain.record[1].delta);
    ck_assert_double_le(mixed.record[2].delta, plain.record[2].delta);
    vor_cloud_free(&in);
}

/* Row X11: never diverges, for any window and on a surface with edges. */
VT_TEST_LOOP(no_window_makes_the_iteration_diverge, VT_FEWER(SEEDS))
{
    static const char *const windows[4] = {"1", "2", "8", "16"};
    static struct vt_trace trace;
    struct vor_cloud in;

    vt_cloud_box(&in, (uint64_t)_i, 4000);
    trace_of(&trace, &in, windows[_i % 4], (uint64_t)_i);
    for (size_t i = 10; i <= PLAIN; i++) {
        ck_assert_double_lt(trace.record[i].delta, 0.5 * trace.record[0].delta);
        ck_assert_double_le(trace.record[i].delta, 1.3 * vt_trace_best(&trace, i));
    }
    vor_cloud_free(&in);
}
