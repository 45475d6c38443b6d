/* The measure of edges that tests of edge-aware resampling judge by: on clouds that are right, and
 * on clouds that are wrong in one way each. */
#include "tests/support/vt_wedge.h"

#include <math.h>
#include <string.h>

static const struct vt_wedge right_angle = {90, 0.01, 2000};

/* Noise that the measure is told of, on a cloud that has none. */
static void make_clean(struct vor_cloud *cloud, struct vor_attribute **normals)
{
    struct vt_wedge clean = right_angle;

    clean.noise = 0;
    vt_wedge_make(cloud, &clean, 1);
    vt_assert_ok(
        vor_cloud_add_attribute(cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3, normals, &vt_err));
}

/* Gives each point its square's normal, or with part > 0 one between both squares'. */
static void set_normals(struct vor_cloud *cloud, struct vor_attribute *normals, double part)
{
    float *out = normals->data;

    for (size_t i = 0; i < cloud->n; i++) {
        double x[3], own[3], other[3];
        int square;

        vor_cloud_position(cloud, i, x);
        square = vt_wedge_off(&right_angle, 1, x) < vt_wedge_off(&right_angle, 0, x);
        vt_wedge_normal(&right_angle, square, own);
        vt_wedge_normal(&right_angle, !square, other);
        for (size_t c = 0; c < 3; c++)
            out[3 * i + c] = (float)((1 - part) * own[c] + part * other[c]);
    }
}

START_TEST(a_wedge_that_is_right_has_no_error)
{
    struct vt_wedge_seen seen = {0};
    struct vor_attribute *normals;
    struct vor_cloud cloud;

    make_clean(&cloud, &normals);
    set_normals(&cloud, normals, 0);
    vt_wedge_see(&seen, &right_angle, &cloud);
    ck_assert_uint_gt(seen.n, 50);
    ck_assert_double_lt(vt_quantile(seen.angle, seen.n, 0.99), 0.01);
    ck_assert_double_lt(vt_quantile(seen.off, seen.n, 0.99), 1e-6);
    ck_assert_uint_eq(seen.smeared, 0);
    ck_assert_double_lt(seen.reach_sum / (double)seen.reach_count, vt_wedge_spacing(cloud.n));
    vt_wedge_seen_free(&seen);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

START_TEST(normals_between_both_faces_are_smeared)
{
    struct vt_wedge_seen seen = {0};
    struct vor_attribute *normals;
    struct vor_cloud cloud;

    make_clean(&cloud, &normals);
    set_normals(&cloud, normals, 0.5);
    vt_wedge_see(&seen, &right_angle, &cloud);
    ck_assert_double_eq_tol(vt_quantile(seen.angle, seen.n, 0.5), 45, 0.01);
    ck_assert_uint_eq(seen.smeared, seen.n);
    vt_wedge_seen_free(&seen);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

START_TEST(points_off_both_faces_are_smeared)
{
    struct vt_wedge_seen seen = {0};
    struct vor_attribute *normals;
    struct vor_cloud cloud;
    double by = 3 * right_angle.noise;

    make_clean(&cloud, &normals);
    set_normals(&cloud, normals, 0);
    for (size_t i = 0; i < cloud.n; i++) /* into the wedge, off both squares */
        for (size_t c = 0; c < 3; c += 2)
            cloud.xyz[3 * i + c] += (float)by;
    vt_wedge_see(&seen, &right_angle, &cloud);
    ck_assert_double_eq_tol(vt_quantile(seen.off, seen.n, 0.5), by, 1e-6);
    ck_assert_uint_eq(seen.smeared, seen.n);
    vt_wedge_seen_free(&seen);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

START_TEST(noise_is_as_large_as_asked_for)
{
    struct vor_cloud cloud;
    double sum = 0;

    vt_wedge_make(&cloud, &right_angle, 3);
    for (size_t i = 0; i < cloud.n; i++) {
        double x[3], off[2];

        vor_cloud_position(&cloud, i, x);
        for (int square = 0; square < 2; square++)
            off[square] = vt_wedge_off(&right_angle, square, x);
        sum += fmin(off[0], off[1]) * fmin(off[0], off[1]);
    }
    ck_assert_double_eq_tol(sqrt(sum / (double)cloud.n), right_angle.noise,
                            0.05 * right_angle.noise);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("wedge");

    vt_add(suite, a_wedge_that_is_right_has_no_error);
    vt_add(suite, normals_between_both_faces_are_smeared);
    vt_add(suite, points_off_both_faces_are_smeared);
    vt_add(suite, noise_is_as_large_as_asked_for);
    return vt_run(suite);
}
