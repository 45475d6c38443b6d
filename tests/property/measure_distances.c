/* Properties of the distances and errors of a measure: what swapping, scaling and a peak
 * change and what they do not. */
#include "core/metrics/measure.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 6 };

/* A cloud and a reference of other sizes, some way from each other. */
struct two {
    struct vor_cloud cloud, reference;
};

static void open_two(struct two *two, uint64_t seed)
{
    vt_cloud_sphere(&two->cloud, 2 * seed, 1500);
    vt_cloud_dome(&two->reference, 2 * seed + 1, 1100);
    two->reference.origin[1] = 0.25;
}

static void close_two(struct two *two)
{
    vor_cloud_free(&two->cloud);
    vor_cloud_free(&two->reference);
    vt_assert_no_leak();
}

static struct vor_measure measure(const struct vor_cloud *cloud, const struct vor_cloud *reference,
                                  double peak, unsigned threads)
{
    struct vt_engine engine;
    struct vor_measure m;

    memset(&m, 0, sizeof m);
    vt_engine_open(&engine, threads);
    vt_assert_ok(vor_measure_clouds(&m, cloud, reference, peak, &engine.run, &vt_err));
    vt_engine_close(&engine);
    return m;
}

static double diagonal(const struct vor_cloud *cloud)
{
    double sum = 0;

    for (size_t c = 0; c < 3; c++) {
        double low = INFINITY, high = -INFINITY;

        for (size_t i = 0; i < cloud->n; i++) { /* fmax in this loop crashes gcc 12 for arm64 */
            double x = (double)cloud->xyz[3 * i + c];

            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        sum += (high - low) * (high - low);
    }
    return sqrt(sum);
}

static void assert_near(double got, double wanted)
{
    ck_assert_double_eq_tol(got, wanted, 1e-6 * fabs(wanted));
}

START_TEST(hausdorff_chamfer_and_d1_are_the_same_from_either_side)
{
    struct two two;
    struct vor_measure forth, back;

    open_two(&two, (uint64_t)_i);
    forth = measure(&two.cloud, &two.reference, 1, 2);
    back = measure(&two.reference, &two.cloud, 1, 2);
    assert_near(forth.hausdorff, back.hausdorff);
    assert_near(forth.chamfer, back.chamfer);
    assert_near(forth.out_to_ref_rms, back.ref_to_out_rms);
    assert_near(forth.d1_mse, back.d1_mse);
    assert_near(forth.d1_psnr, back.d1_psnr);
    close_two(&two);
}
END_TEST

START_TEST(the_distances_fit_together)
{
    struct two two;
    struct vor_measure m;

    open_two(&two, (uint64_t)_i);
    m = measure(&two.cloud, &two.reference, 0, 2);
    ck_assert(m.out_to_ref_mean < m.out_to_ref_rms && m.out_to_ref_rms < m.out_to_ref_max);
    ck_assert(m.ref_to_out_mean < m.ref_to_out_rms && m.ref_to_out_rms < m.ref_to_out_max);
    ck_assert(m.hausdorff == fmax(m.out_to_ref_max, m.ref_to_out_max));
    assert_near(m.hausdorff_relative, m.hausdorff / diagonal(&two.reference));
    ck_assert(m.chamfer == m.out_to_ref_mean + m.ref_to_out_mean);
    /* No points coincide, so D1 is the square of the larger rms. */
    assert_near(m.d1_mse, pow(fmax(m.out_to_ref_rms, m.ref_to_out_rms), 2));
    ck_assert(m.d2_mse > 0 && m.d2_mse < m.d1_mse);
    ck_assert(m.d2_psnr > m.d1_psnr);
    assert_near(m.d1_psnr, 10 * log10(3 * m.peak * m.peak / m.d1_mse));
    close_two(&two);
}
END_TEST

START_TEST(scale_changes_lengths_by_itself_and_errors_by_its_square_and_no_psnr)
{
    const double scale = 3.28084;
    struct two two;
    struct vor_measure m, k;

    open_two(&two, (uint64_t)_i);
    m = measure(&two.cloud, &two.reference, 0, 2);
    for (size_t i = 0; i < 3 * two.cloud.n; i++)
        two.cloud.xyz[i] *= (float)scale;
    for (size_t i = 0; i < 3 * two.reference.n; i++)
        two.reference.xyz[i] *= (float)scale;
    two.reference.origin[1] *= scale;
    k = measure(&two.cloud, &two.reference, 0, 2);
    ck_assert_double_eq_tol(k.d1_mse / m.d1_mse, scale * scale, 1e-4);
    ck_assert_double_eq_tol(k.d2_mse / m.d2_mse, scale * scale, 1e-2);
    ck_assert_double_eq_tol(k.peak / m.peak, scale, 1e-5);
    ck_assert_double_eq_tol(k.d1_psnr, m.d1_psnr, 1e-4);
    ck_assert_double_eq_tol(k.d2_psnr, m.d2_psnr, 1e-2);
    ck_assert_double_eq_tol(k.hausdorff / m.hausdorff, scale, 1e-5);
    ck_assert_double_eq_tol(k.hausdorff_relative, m.hausdorff_relative, 1e-6);
    ck_assert_double_eq_tol(k.chamfer / m.chamfer, scale, 1e-5);
    close_two(&two);
}
END_TEST

START_TEST(a_peak_of_either_end_of_the_range_is_finite)
{
    struct two two;

    open_two(&two, 1);
    for (int k = 0; k < 2; k++) {
        struct vor_measure m = measure(&two.cloud, &two.reference, k == 0 ? 1e-30 : 1e30, 2);

        ck_assert(isfinite(m.d1_psnr) && isfinite(m.d2_psnr));
    }
    close_two(&two);
}
END_TEST

/* On a sphere the radii are the normals: fitted and carried ones give about the same. */
START_TEST(fitted_normals_stand_for_carried_ones)
{
    struct vor_cloud cloud, reference;
    struct vor_attribute *normal;
    struct vor_measure fitted, carried;

    vt_cloud_sphere(&cloud, 2 * (uint64_t)_i, 3000);
    vt_cloud_sphere(&reference, 2 * (uint64_t)_i + 1, 3000);
    for (size_t i = 0; i < 3 * cloud.n; i++)
        cloud.xyz[i] *= 1.02f;
    fitted = measure(&cloud, &reference, 0, 2);
    vt_assert_ok(vor_cloud_add_attribute(&reference, "normal", VOR_NORMAL, VOR_FLOAT32, 3, &normal,
                                         &vt_err));
    memcpy(normal->data, reference.xyz, 3 * reference.n * sizeof *reference.xyz);
    carried = measure(&cloud, &reference, 0, 2);
    ck_assert(fitted.d1_mse == carried.d1_mse);
    ck_assert_double_eq_tol(fitted.d2_mse / carried.d2_mse, 1, 0.02);
    ck_assert_double_eq_tol(carried.d2_mse, 0.0004, 0.0001);
    vor_cloud_free(&cloud);
    vor_cloud_free(&reference);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("measure_distances");

    vt_add_loop(suite, hausdorff_chamfer_and_d1_are_the_same_from_either_side, VT_ONCE(SEEDS));
    vt_add_loop(suite, the_distances_fit_together, VT_ONCE(SEEDS));
    vt_add_loop(suite, scale_changes_lengths_by_itself_and_errors_by_its_square_and_no_psnr,
                VT_ONCE(SEEDS));
    vt_add(suite, a_peak_of_either_end_of_the_range_is_finite);
    vt_add_loop(suite, fitted_normals_stand_for_carried_ones, VT_ONCE(SEEDS));
    return vt_run(suite);
}
