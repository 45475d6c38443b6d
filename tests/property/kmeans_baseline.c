/* The baseline k-means as a request runs it: exactly n points, and its
 * refusals. */
#include "tests/support/vt_shape.h"
#include "tests/support/vt_trace.h"

#include <string.h>

enum { N = 3000, OUT = 500, STEPS = 8 };

static void open_engine(struct vt_engine *engine, unsigned threads, size_t points)
{
    vt_engine_open(engine, threads);
    vt_engine_set(engine, "method", "kmeans");
    vt_engine_count(engine, "points", points);
}

VT_TEST(it_gives_exactly_n_points_on_the_surface)
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
}

VT_TEST(more_points_than_the_input_has_are_refused)
{
    struct vt_engine engine;
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, 1, 200);
    memcpy(&in.xyz[3], in.xyz, 3 * sizeof *in.xyz); /* in one place with another */
    open_engine(&engine, 2, 200);
    vt_assert_fails(VOR_E_TARGET, vt_engine_try(&engine, &out, &report, &in));
    ck_assert_str_eq(vt_err.message,
                     "200 points are requested, want 1 to 199: method=kmeans cannot give "
                     "more points than the input has distinct positions");
    ck_assert_uint_eq(out.n, 0);
    vt_engine_set(&engine, "points", "100");
    vt_engine_set(&engine, "density", "curvature");
    vt_assert_fails(VOR_E_DENSITY, vt_engine_try(&engine, &out, &report, &in));
    ck_assert_str_eq(vt_err.message,
                     "method=kmeans does not support a density: use density=uniform or method=cvt");
    ck_assert_uint_eq(out.n, 0);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
}
