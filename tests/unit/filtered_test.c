/* Results that filters alone make: points keep their order and their attributes. */
#include "core/metrics/measure.h"
#include "tests/support/vt_filter.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 2, N = 3000, SMALL = 300 };

VT_TEST_FIGURES(every_point_keeps_its_place_in_the_order_and_its_attributes,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    vt_noise_radial(&in, (uint64_t)_i, 0.02, 1);
    vt_number(&in);
    vt_filter(&out, &report, &in, "mls", "drop");
    ck_assert_uint_eq(out.n, N);
    ck_assert_uint_eq(out.attribute_count, 1);
    for (size_t i = 0; i < N; i++) {
        double moved = 0;

        ck_assert_uint_eq(vt_number_of(&out, i), i);
        for (size_t c = 0; c < 3; c++)
            moved = fmax(moved, fabs((double)out.xyz[3 * i + c] - (double)in.xyz[3 * i + c]));
        ck_assert_double_lt(moved, 0.12);
    }
    vt_free_last(&out, &in);
}

/* Every fifth point once more, and a stray twice: twins go together. */
VT_TEST_FIGURES(points_that_share_a_place_stay_together, VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    struct vor_cloud in, out;
    struct vor_report report;
    size_t pairs = 0;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    vt_noise_radial(&in, (uint64_t)_i, 0.02, 1);
    for (size_t c = 0; c < 3; c++)
        in.xyz[c] *= 1.8f;
    for (size_t i = 4; i < N; i += 5)
        memcpy(&in.xyz[3 * i], &in.xyz[3 * (i - 4)], 3 * sizeof *in.xyz);
    vt_number(&in);
    vt_filter(&out, &report, &in, "mls,outliers", "drop");
    ck_assert_uint_eq(report.outliers, N - out.n);
    ck_assert(report.min_over_mean == 0);
    for (size_t i = 0; i + 1 < out.n; i++) {
        size_t was = vt_number_of(&out, i), next = i + 1;

        ck_assert_uint_ne(was, 0);
        ck_assert_uint_ne(was, 4);
        if (was % 5 != 0)
            continue;
        while (next < out.n && vt_number_of(&out, next) < was + 4)
            next++;
        ck_assert_uint_lt(next, out.n);
        ck_assert_uint_eq(vt_number_of(&out, next), was + 4);
        ck_assert_mem_eq(&out.xyz[3 * i], &out.xyz[3 * next], 3 * sizeof *out.xyz);
        pairs++;
    }
    ck_assert_uint_gt(pairs, N / 6);
    vt_free_last(&out, &in);
}

/* The report against `measure`, and all that only a method tells. */
VT_TEST_FIGURES(the_report_measures_the_result_and_tells_of_no_step,
                VT_FEWER(VT_SOAK_LOOPS(1, SEEDS)))
{
    const size_t points = N / 2;
    struct vor_cloud in, out;
    struct vor_report report;
    struct vor_measure measure;
    struct vt_engine engine;

    vt_cloud_sphere(&in, (uint64_t)_i, points);
    vt_noise_radial(&in, (uint64_t)_i, 0.02, 1);
    vt_stray(&in, (uint64_t)_i);
    vt_filter(&out, &report, &in, "outliers,mls", "drop");
    vt_engine_open(&engine, 2);
    vt_assert_ok(vor_measure_clouds(&measure, &out, &in, 0, &engine.run, &vt_err));
    ck_assert_double_eq_tol(report.delta, measure.delta, 1e-5);
    ck_assert_double_eq_tol(report.spacing_mean, measure.mean_nn, 1e-6);
    ck_assert_double_eq_tol(report.max_over_mean, measure.max_over_mean, 1e-4);
    ck_assert_uint_eq(report.points_in, points);
    ck_assert_uint_eq(report.points_out, out.n);
    ck_assert_uint_eq(report.out_to_ref.points, out.n);
    ck_assert_uint_eq(report.iterations + report.polish_steps + report.stages_count, 0);
    ck_assert_uint_eq(report.fitted_count, 0);
    ck_assert(report.area == 0 && report.six_share == 0);
    ck_assert(!vor_spec_given(&report.parameters, VOR_PARAM_POINTS));
    ck_assert_double_gt(report.out_to_ref.rms, 0);
    ck_assert_double_lt(report.out_to_ref.max, 0.2);
    vt_engine_close(&engine);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(fitted_normals_are_those_of_the_sphere_and_follow_the_carried_ones, 0)
{
    for (int inward = 0; inward < 2; inward++) {
        struct vor_attribute *carried;
        struct vor_cloud in, out;
        struct vor_report report;
        const float *normal;

        vt_cloud_sphere(&in, (uint64_t)_i, N);
        if (inward) {
            vt_assert_ok(vor_cloud_add_attribute(&in, "normal", VOR_NORMAL, VOR_FLOAT32, 3,
                                                 &carried, &vt_err));
            for (size_t i = 0; i < 3 * (size_t)N; i++)
                ((float *)carried->data)[i] = -in.xyz[i];
        }
        vt_ask(&out, &report, &(struct vt_ask){&in, "filters=mls normals=fit", 2});
        ck_assert_uint_eq(out.attribute_count, 1);
        normal = vor_cloud_find(&out, VOR_NORMAL)->data;
        for (size_t i = 0; i < N; i++) {
            const float *x = &out.xyz[3 * i], *a = &normal[3 * i];
            double along = (double)x[0] * a[0] + (double)x[1] * a[1] + (double)x[2] * a[2];

            ck_assert_double_gt(inward ? -along : along, 0.99);
        }
        vor_cloud_free(&out);
        vor_cloud_free(&in);
    }
}

VT_TEST_FIGURES(islands_are_counted_and_stay_in_their_places_of_the_order, 0)
{
    enum { ISLAND = 8 };
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, N);
    for (size_t i = 0; i < 3 * (size_t)ISLAND; i++)
        in.xyz[i] = (float)(5 + 0.02 * vt_unit((uint64_t)_i, i));
    vt_number(&in);
    vt_filter(&out, &report, &in, "mls", "keep");
    ck_assert_uint_eq(out.n, N);
    for (size_t i = 0; i < N; i++)
        ck_assert_uint_eq(vt_number_of(&out, i), i);
    ck_assert_uint_eq(report.parts, 2);
    ck_assert_uint_eq(report.islands, 1);
    ck_assert_uint_eq(report.in_islands, ISLAND);
    ck_assert_uint_eq(report.on_islands, 0);
    ck_assert_double_eq(report.delta_beside, report.delta);
    vor_cloud_free(&out);
    vt_filter(&out, &report, &in, "outliers", "drop");
    ck_assert_uint_eq(report.outliers, ISLAND);
    ck_assert_uint_eq(vt_number_of(&out, 0), ISLAND);
    vt_free_last(&out, &in);
}

VT_TEST_FIGURES(double_positions_far_from_the_origin_stay_exact, 0)
{
    double xyz[3 * SMALL];
    struct vor_cloud in, out;
    struct vor_report report;

    vt_cloud_sphere(&in, (uint64_t)_i, SMALL);
    for (size_t i = 0; i < 3 * (size_t)SMALL; i++)
        xyz[i] = 6.4e5 + (double)in.xyz[i];
    vt_assert_ok(vor_cloud_set_double(&in, xyz, &vt_err));
    vt_filter(&out, &report, &in, "outliers", "drop");
    ck_assert_uint_eq(out.n, SMALL);
    ck_assert_int_eq(out.position_type, VOR_FLOAT64);
    ck_assert(vt_cloud_hash(&out) == vt_cloud_hash(&in));
    vt_free_last(&out, &in);
}

VT_TEST(clouds_without_a_surface_are_refused_as_ever_and_few_points_pass)
{
    struct vor_cloud in, out;
    const struct vt_ask request = {&in, "filters=mls,outliers,thin", 1};
    struct vor_report report;

    vt_cloud_make(&in, 30);
    for (size_t i = 0; i < 90; i++)
        in.xyz[i] = (float)(i / 3);
    vt_assert_fails(VOR_E_DEGENERATE, vt_ask_try(&out, &report, &request));
    vor_cloud_free(&in);
    for (size_t n = 4; n < 25; n++) {
        vt_cloud_sphere(&in, n, n);
        vt_ask(&out, &report, &request);
        ck_assert_uint_ge(out.n, n < 20 ? n : 20);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
    }
}
