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

static const struct {
    size_t n, to_n, normals_n;
    float from[15], to[12], normals[12];
    double d1, d2, d2_within, peak;
} exact[] = {
    /* The larger direction is the error. From the reference: 1 and 1, along the normals 1 and
     * 0.36. From the cloud: 1, 1 and 9, along the normals 1, 0.36 and 5.76. */
    {3,
     2,
     2,
     {0, 0, 1, 2, 1, 0, 2, 0, 3},
     {0, 0, 0, 2, 0, 0},
     {0, 0, 1, 0, 0.6f, 0.8f},
     11.0 / 3,
     7.12 / 3,
     1e-6,
     2},
    /* Equally near points share normals and errors. The first reference point has both points of
     * the cloud at 1, so both get its normal; the one on the x axis is the nearest of the second
     * reference point too, and gets the mean (0.5, 0, 0.5). From the reference: (0.25 + 1) / 2 and
     * 4.5^2. */
    {2, 2, 2, {1, 0, 0, 0, 0, 1}, {0, 0, 0, 10, 0, 0}, {0, 0, 1, 1, 0, 0}, 41, 10.4375, 1e-6, 10},
    /* Carried normals that point against each other cancel: their mean is nothing, so that the
     * distance counts; with one side turned it would be (0, 1, 0). */
    {1, 2, 2, {0, 0, 0}, {-1, 0, 0, 1, 0, 0}, {0, 1, 0, 0, -1, 0}, 1, 1, 1e-12, 2},
    /* Coincident points count once, with the first one's normal: as the first case. */
    {5,
     4,
     4,
     {2, 0, 3, 0, 0, 1, 2, 1, 0, 0, 0, 1, 0, 0, 1},
     {0, 0, 0, 2, 0, 0, 2, 0, 0, 0, 0, 0},
     {0, 0, 1, 0, 0.6f, 0.8f, 1, 0, 0, 0, 1, 0},
     11.0 / 3,
     7.12 / 3,
     1e-6,
     2},
    /* Without normals all of the distance counts: on a line there is no surface. */
    {1, 3, 0, {1, 2, 0}, {0, 0, 0, 1, 0, 0, 3, 0, 0}, {0}, 17.0 / 3, 17.0 / 3, 1e-12, 2},
};

VT_TEST_LOOP(the_errors_are_those_computed_by_hand, (int)(sizeof exact / sizeof exact[0]))
{
    struct vor_cloud cloud, reference;
    struct vor_distortion d;

    make(&cloud, exact[_i].n, exact[_i].from, NULL);
    make(&reference, exact[_i].to_n, exact[_i].to,
         exact[_i].normals_n > 0 ? exact[_i].normals : NULL);
    vt_assert_ok(measure(&d, &cloud, &reference));
    ck_assert_double_eq_tol(d.d1_mse, exact[_i].d1, 1e-12);
    ck_assert_double_eq_tol(d.d2_mse, exact[_i].d2, exact[_i].d2_within);
    ck_assert_double_eq_tol(d.peak, exact[_i].peak, 1e-12);
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
