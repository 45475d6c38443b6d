/* What we claim beside Xiao et al. 2024: momentum in the place of the Anderson mix, and a polish.
 * Each is compared with the paper's own on clouds of which the truth is known, with enough points
 * that the delta of a run hardly depends on the draw. */
#include "core/metrics/measure.h"
#include "tests/support/vt_shape.h"
#include "tests/support/vt_trace.h"

enum { SEEDS = 2, FROM = 12000, TO = 3000, PLAIN = 50, SOON = 25, CONVERGED = 100, DENSE = 60000 };

/* A window of NULL is momentum; `trace` may be NULL. */
static void run(struct vor_cloud *out, struct vor_report *report, struct vt_trace *trace,
                const struct vor_cloud *in, const char *window, size_t iterations)
{
    struct vt_engine engine;

    vt_engine_open(&engine, 2);
    if (trace != NULL)
        vt_trace_attach(trace, &engine);
    vt_engine_count(&engine, "points", TO);
    if (iterations > 0) {
        vt_engine_count(&engine, "iterations", iterations);
        vt_engine_set(&engine, "polish", "0");
    }
    if (window != NULL)
        vt_engine_set(&engine, "anderson", window);
    vt_engine_resample(&engine, out, report, in);
    vt_engine_close(&engine);
}

static void trace_of(struct vt_trace *trace, const struct vor_cloud *in, const char *window)
{
    struct vor_cloud out;
    struct vor_report report;

    run(&out, &report, trace, in, window, PLAIN);
    vor_cloud_free(&out);
}

static void make(struct vor_cloud *in, const char **name, int i)
{
    *name = vt_shapes[i % VT_SMOOTH].name;
    vt_shapes[i % VT_SMOOTH].make(in, (uint64_t)i / VT_SMOOTH, FROM);
}

/* Measured over eight seeds of each of three surfaces: momentum 16 to 25, the mix 26 to 35. */
VT_TEST_LOOP(momentum_reaches_fifty_plain_iterations_within_25_and_the_mix_in_fewer_than_fifty,
             VT_FEWER(VT_SOAK_LOOPS(1, SEEDS) * VT_SMOOTH))
{
    static struct vt_trace plain, momentum, mix;
    struct vor_cloud in;
    const char *name;
    double target;

    make(&in, &name, _i);
    trace_of(&plain, &in, "0");
    trace_of(&momentum, &in, NULL);
    trace_of(&mix, &in, "4");
    target = vt_trace_best(&plain, PLAIN + 1);
    ck_assert_msg(vt_trace_reaches(&momentum, target) <= SOON, "%s: momentum reaches %g in %zu",
                  name, target, vt_trace_reaches(&momentum, target));
    ck_assert_msg(vt_trace_reaches(&mix, target) < vt_trace_reaches(&plain, target),
                  "%s: the mix reaches %g in %zu", name, target, vt_trace_reaches(&mix, target));
    ck_assert(momentum.record[0].delta == plain.record[0].delta);
    vor_cloud_free(&in);
}

static double coverage(const struct vor_cloud *out, const struct vor_cloud *surface)
{
    struct vt_engine engine;
    struct vor_measure measure;

    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_measure_clouds(&measure, out, surface, 0, &engine.run, &vt_err));
    vt_engine_close(&engine);
    return measure.ref_to_out_mean;
}

/* Of a tessellation that has converged, not of the one that the polish begins with. */
VT_TEST_LOOP(the_default_halves_the_delta_of_a_converged_tessellation_and_covers_as_well,
             VT_FEWER(VT_SOAK_LOOPS(1, SEEDS) * VT_SMOOTH))
{
    struct vor_cloud in, surface, converged, polished;
    struct vor_report before, after;
    const char *name;
    double worse;

    make(&in, &name, _i);
    vt_shapes[_i % VT_SMOOTH].make(&surface, 100, DENSE);
    run(&converged, &before, NULL, &in, NULL, CONVERGED);
    run(&polished, &after, NULL, &in, NULL, 0);
    ck_assert_uint_eq(before.iterations, CONVERGED);
    ck_assert_uint_gt(after.polish_steps, 0);
    ck_assert_msg(after.delta <= before.delta / 2, "%s: delta %g, converged %g", name, after.delta,
                  before.delta);
    worse = coverage(&polished, &surface) / coverage(&converged, &surface);
    ck_assert_msg(worse < 1.03, "%s: the surface is %g times as far from the points", name, worse);
    vor_cloud_free(&polished);
    vor_cloud_free(&converged);
    vt_free_last(&surface, &in);
}
