/* Distances between clouds: hand values and refusals. */
#include "core/metrics/distance.h"
#include "tests/support/vt_engine.h"

#include <math.h>

/* Seven points one apart on a line, and three points beside it. */
VT_TEST(a_line_of_seven_has_its_hand_computed_distances)
{
    float reference[21] = {0};
    const float xyz[9] = {0, 0.5f, 0, 3, 1, 0, 8, 0, 0};
    struct vt_engine engine;
    struct vor_distances d;
    double knn6 = (6 + 5 + 4 + 3 + 4 + 5 + 6) / 7.0;

    for (int i = 0; i < 7; i++)
        reference[3 * i] = (float)i;
    vt_engine_open(&engine, 1);
    vt_assert_ok(vor_distances_measure(&d, xyz, 3, reference, 7, &engine.run, &vt_err));
    ck_assert_double_eq_tol(d.out_to_ref_mean, 3.5 / 3, 1e-7);
    ck_assert_double_eq_tol(d.out_to_ref_rms, sqrt((0.25 + 1 + 4) / 3), 1e-7);
    ck_assert_double_eq_tol(d.out_to_ref_max, 2.0, 1e-7);
    /* 0.5, sqrt 1.25, sqrt 2, 1, sqrt 2, sqrt 5, 2 */
    ck_assert_double_eq_tol(d.ref_to_out_mean,
                            (0.5 + sqrt(1.25) + 2 * sqrt(2) + 1 + sqrt(5) + 2) / 7, 1e-7);
    ck_assert_double_eq_tol(d.ref_to_out_rms, sqrt((0.25 + 1.25 + 2 + 1 + 2 + 5 + 4) / 7), 1e-7);
    ck_assert_double_eq_tol(d.ref_to_out_max, sqrt(5), 1e-7);
    ck_assert_double_eq_tol(d.hausdorff, sqrt(5), 1e-7);
    ck_assert_double_eq_tol(d.hausdorff_relative, sqrt(5) / 6, 1e-7);
    ck_assert_double_eq_tol(d.chamfer, d.out_to_ref_mean + d.ref_to_out_mean, 1e-12);
    ck_assert_double_eq_tol(d.far_over_knn6_mean, 2 / knn6, 1e-7);
    ck_assert_double_eq_tol(d.far_over_knn6_p999, 2.0 / 6, 1e-7);
    vt_engine_close(&engine);
}

VT_TEST(a_cloud_is_at_no_distance_from_itself)
{
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_distances d;

    vt_engine_open(&engine, 2);
    vt_cloud_sphere(&cloud, 1, 1000);
    vt_assert_ok(vor_distances_measure(&d, cloud.xyz, 1000, cloud.xyz, 1000, &engine.run, &vt_err));
    ck_assert(d.out_to_ref_mean == 0 && d.out_to_ref_max == 0);
    ck_assert(d.ref_to_out_mean == 0 && d.ref_to_out_max == 0);
    ck_assert(d.out_to_ref_rms == 0 && d.ref_to_out_rms == 0);
    ck_assert(d.hausdorff == 0 && d.chamfer == 0);
    ck_assert(d.far_over_knn6_mean == 0 && d.far_over_knn6_p999 == 0);
    vor_cloud_free(&cloud);
    vt_engine_close(&engine);
}

VT_TEST(a_reference_of_fewer_than_seven_points_or_no_extent_is_refused)
{
    float same[60];
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_distances d = {.out_to_ref_max = -1};

    vt_engine_open(&engine, 1);
    vt_cloud_sphere(&cloud, 1, 20);
    for (int i = 0; i < 60; i++)
        same[i] = 1;
    for (size_t m = 0; m < 7; m++)
        vt_assert_fails(VOR_E_DEGENERATE, vor_distances_measure(&d, cloud.xyz, 20, cloud.xyz, m,
                                                                &engine.run, &vt_err));
    vt_assert_fails(VOR_E_DEGENERATE,
                    vor_distances_measure(&d, cloud.xyz, 20, same, 20, &engine.run, &vt_err));
    ck_assert(d.out_to_ref_max == -1);
    vt_assert_ok(vor_distances_measure(&d, cloud.xyz, 20, cloud.xyz, 7, &engine.run, &vt_err));
    vor_cloud_free(&cloud);
    vt_engine_close(&engine);
}
