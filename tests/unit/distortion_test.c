/* D1 and D2: hand values and refusals. */
#include "core/metrics/distortion.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

/* A reference with normals where there are any. */
static void make(struct vor_cloud *cloud, size_t n, const float *xyz, const float *normals)
{
    struct vor_attribute *attribute;

    vt_cloud_make(cloud, n);
    memcpy(cloud->xyz, xyz, 3 * n * sizeof *xyz);
    if (normals == NULL)
        return;
    vt_assert_ok(
        vor_cloud_add_attribute(cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3, &attribute, &vt_err));
    memcpy(attribute->data, normals, 3 * n * sizeof *normals);
}

static vor_status measure(struct vor_distortion *out, const struct vor_cloud *cloud,
                          const struct vor_cloud *reference)
{
    struct vor_distortion_pair pair = {cloud->xyz, reference->xyz, cloud->n, reference->n,
                                       vor_cloud_find(reference, VOR_NORMAL)};
    struct vt_engine engine;
    vor_status status;

    vt_engine_open(&engine, 2);
    status = vor_distortion_measure(out, &pair, &engine.run, &vt_err);
    vt_engine_close(&engine);
    return status;
}

/* From the reference: 1 and 1, along the normals 1 and 0.36. From the cloud: 1, 1 and 9, along the
 * normals 1, 0.36 and 5.76. */
VT_TEST(the_larger_direction_is_the_error)
{
    static const float to[6] = {0, 0, 0, 2, 0, 0}, normals[6] = {0, 0, 1, 0, 0.6f, 0.8f};
    static const float from[9] = {0, 0, 1, 2, 1, 0, 2, 0, 3};
    struct vor_cloud cloud, reference;
    struct vor_distortion d;

    make(&cloud, 3, from, NULL);
    make(&reference, 2, to, normals);
    vt_assert_ok(measure(&d, &cloud, &reference));
    ck_assert_double_eq_tol(d.d1_mse, 11.0 / 3, 1e-12);
    ck_assert_double_eq_tol(d.d2_mse, 7.12 / 3, 1e-6);
    ck_assert_double_eq_tol(d.peak, 2, 1e-12);
    vt_free_last(&cloud, &reference);
}

/* The first reference point has both points of the cloud at 1, so both get its normal; the one on
 * the x axis is the nearest of the second reference point too, and gets the mean (0.5, 0, 0.5).
 * From the reference: (0.25 + 1) / 2 and 4.5^2. */
VT_TEST(equally_near_points_share_normals_and_errors)
{
    static const float to[6] = {0, 0, 0, 10, 0, 0}, normals[6] = {0, 0, 1, 1, 0, 0};
    static const float from[6] = {1, 0, 0, 0, 0, 1};
    struct vor_cloud cloud, reference;
    struct vor_distortion d;

    make(&cloud, 2, from, NULL);
    make(&reference, 2, to, normals);
    vt_assert_ok(measure(&d, &cloud, &reference));
    ck_assert_double_eq_tol(d.d1_mse, 41, 1e-12);
    ck_assert_double_eq_tol(d.d2_mse, 10.4375, 1e-6);
    ck_assert_double_eq_tol(d.peak, 10, 1e-12);
    vt_free_last(&cloud, &reference);
}

/* Their mean is nothing, so that the distance counts; with one side turned it would be (0, 1, 0).
 */
VT_TEST(carried_normals_that_point_against_each_other_cancel)
{
    static const float to[6] = {-1, 0, 0, 1, 0, 0}, normals[6] = {0, 1, 0, 0, -1, 0};
    static const float from[3] = {0, 0, 0};
    struct vor_cloud cloud, reference;
    struct vor_distortion d;

    make(&cloud, 1, from, NULL);
    make(&reference, 2, to, normals);
    vt_assert_ok(measure(&d, &cloud, &reference));
    ck_assert_double_eq_tol(d.d2_mse, 1, 1e-12);
    vt_free_last(&cloud, &reference);
}

VT_TEST(coincident_points_count_once_with_the_first_ones_normal)
{
    static const float to[12] = {0, 0, 0, 2, 0, 0, 2, 0, 0, 0, 0, 0};
    static const float normals[12] = {0, 0, 1, 0, 0.6f, 0.8f, 1, 0, 0, 0, 1, 0};
    static const float from[15] = {2, 0, 3, 0, 0, 1, 2, 1, 0, 0, 0, 1, 0, 0, 1};
    struct vor_cloud cloud, reference;
    struct vor_distortion d;

    make(&cloud, 5, from, NULL);
    make(&reference, 4, to, normals);
    vt_assert_ok(measure(&d, &cloud, &reference));
    ck_assert_double_eq_tol(d.d1_mse, 11.0 / 3, 1e-12);
    ck_assert_double_eq_tol(d.d2_mse, 7.12 / 3, 1e-6);
    ck_assert_double_eq_tol(d.peak, 2, 1e-12);
    vt_free_last(&cloud, &reference);
}

VT_TEST(normals_that_a_reference_lacks_are_fitted)
{
    struct vor_cloud cloud, reference;
    struct vor_attribute *normal;
    struct vor_distortion all, some;

    vt_cloud_lattice(&reference, 12);
    vt_cloud_lattice(&cloud, 12);
    for (size_t i = 0; i < cloud.n; i++) {
        cloud.xyz[3 * i] += 0.125f;
        cloud.xyz[3 * i + 2] += 0.25f;
    }
    vt_assert_ok(measure(&all, &cloud, &reference));
    ck_assert_double_eq_tol(all.d1_mse, 0.015625 + 0.0625, 1e-12);
    ck_assert_double_eq_tol(all.d2_mse, 0.0625, 1e-6);
    ck_assert_double_eq_tol(all.peak, 1, 1e-12);
    vt_assert_ok(
        vor_cloud_add_attribute(&reference, "normal", VOR_NORMAL, VOR_INT8, 3, &normal, &vt_err));
    memset(normal->data, 0, 3 * reference.n);
    for (size_t i = 0; i < reference.n; i += 2) /* of a length that is not theirs */
        ((int8_t *)normal->data)[3 * i + 2] = 127;
    vt_assert_ok(measure(&some, &cloud, &reference));
    ck_assert(some.d1_mse == all.d1_mse);
    ck_assert_double_eq_tol(some.d2_mse, all.d2_mse, 1e-6);
    vt_free_last(&cloud, &reference);
}

VT_TEST(normals_that_are_not_finite_are_fitted)
{
    struct vor_cloud cloud, reference;
    struct vor_attribute *normal;
    struct vor_distortion d;

    vt_cloud_lattice(&reference, 8);
    vt_cloud_lattice(&cloud, 8);
    for (size_t i = 0; i < cloud.n; i++)
        cloud.xyz[3 * i + 2] += 0.25f;
    vt_assert_ok(vor_cloud_add_attribute(&reference, "normal", VOR_NORMAL, VOR_FLOAT64, 3, &normal,
                                         &vt_err));
    for (size_t i = 0; i < 3 * reference.n; i++)
        ((double *)normal->data)[i] = i % 2 ? (double)NAN : 1e300;
    vt_assert_ok(measure(&d, &cloud, &reference));
    ck_assert_double_eq_tol(d.d2_mse, 0.0625, 1e-6);
    vt_free_last(&cloud, &reference);
}

/* On a line there is no surface. */
VT_TEST(where_no_normal_is_to_be_had_all_of_the_distance_counts)
{
    static const float to[9] = {0, 0, 0, 1, 0, 0, 3, 0, 0}, from[3] = {1, 2, 0};
    struct vor_cloud cloud, reference;
    struct vor_distortion d;

    make(&cloud, 1, from, NULL);
    make(&reference, 3, to, NULL);
    vt_assert_ok(measure(&d, &cloud, &reference));
    ck_assert_double_eq_tol(d.d1_mse, (5 + 4 + 8) / 3.0, 1e-12);
    ck_assert_double_eq_tol(d.d2_mse, d.d1_mse, 1e-12);
    ck_assert_double_eq_tol(d.peak, 2, 1e-12);
    vt_free_last(&cloud, &reference);
}

VT_TEST(psnr_is_three_squared_peaks_over_the_error)
{
    ck_assert_double_eq_tol(vor_distortion_psnr(1, 1), 10 * log10(3), 1e-12);
    ck_assert_double_eq_tol(vor_distortion_psnr(0.03, 10), 40, 1e-12);
    ck_assert_double_eq_tol(vor_distortion_psnr(2, 1023), 10 * log10(3 * 1023.0 * 1023 / 2), 1e-12);
    ck_assert(isinf(vor_distortion_psnr(0, 1)) && vor_distortion_psnr(0, 1) > 0);
    ck_assert(isfinite(vor_distortion_psnr(1, 1e-30)) && isfinite(vor_distortion_psnr(1, 1e30)));
}

VT_TEST(no_points_and_a_reference_in_one_place_are_refused)
{
    static const float same[9] = {1, 2, 3, 1, 2, 3, 1, 2, 3}, two[6] = {1, 2, 3, 4, 5, 6};
    struct vor_cloud cloud, reference;
    struct vor_distortion d = {.peak = -1};

    make(&cloud, 2, two, NULL);
    make(&reference, 3, same, NULL);
    vt_assert_fails(VOR_E_DEGENERATE, measure(&d, &cloud, &reference));
    ck_assert_str_eq(vt_err.message,
                     "the reference has 3 points at the same position, want at least 2 positions");
    cloud.n = 0;
    vt_assert_fails(VOR_E_DEGENERATE, measure(&d, &cloud, &reference));
    cloud.n = 2;
    reference.n = 0;
    vt_assert_fails(VOR_E_DEGENERATE, measure(&d, &cloud, &reference));
    ck_assert(d.peak == -1);
    reference.n = 3;
    vt_assert_ok(measure(&d, &reference, &cloud));
    vt_free_last(&cloud, &reference);
}
