/* Chen 2018, Sec. 4 and 5.2: points follow a density, that of an attribute or of curvature. Spacing
 * goes with it to the power -1/4, and delta of distances over that spacing is low. */
#include "core/base/stat.h"
#include "core/input/density.h"
#include "core/input/input.h"
#include "core/metrics/uniformity.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>

enum { IN = 24000, OUT = 2400, BINS = 20 };

/* A point of the result: logarithms of density and distance to the nearest other one. */
struct followed {
    float rho, apart;
};

static void run(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
                const char *density, unsigned threads)
{
    struct vt_engine engine;

    vt_engine_open(&engine, threads);
    vt_engine_count(&engine, "points", in->n / 10);
    vt_engine_set(&engine, "density", density);
    vt_engine_resample(&engine, out, report, in);
    vt_engine_close(&engine);
}

/* Half axes 3, 1 and 1: curvatures sum to 1.1 at the waist and to 6 at the tips. */
static void make_ellipsoid(struct vor_cloud *cloud, size_t n)
{
    vt_cloud_ellipsoid(cloud, 3, n, 3);
}

/* Slope of a line through the means of `bins` bins with as many points each, by density. */
static double slope_of(const struct followed *point, size_t n)
{
    double x = 0, y = 0, xx = 0, xy = 0;
    float *sorted = vor_malloc(&vt_memory, n, sizeof *sorted);

    ck_assert_ptr_nonnull(sorted);
    for (size_t i = 0; i < n; i++)
        sorted[i] = point[i].rho;
    vor_sort_floats(sorted, n);
    for (size_t bin = 0; bin < BINS; bin++) {
        float low = sorted[bin * n / BINS], high = sorted[(bin + 1) * n / BINS - 1];
        double rho = 0, apart = 0, count = 0;

        for (size_t i = 0; i < n; i++)
            if (point[i].rho >= low && point[i].rho <= high) {
                rho += (double)point[i].rho;
                apart += (double)point[i].apart;
                count++;
            }
        x += rho / count / BINS;
        y += apart / count / BINS;
        xx += rho / count * rho / count / BINS;
        xy += rho / count * apart / count / BINS;
    }
    vor_free(&vt_memory, sorted);
    return (xy - x * y) / (xx - x * x);
}

static void distances(float *apart, const struct vor_cloud *cloud, const struct vor_run *run)
{
    struct vor_knn *knn;

    vt_assert_ok(vor_knn_build(&knn, cloud->xyz, cloud->n, &vt_memory, &vt_err));
    vt_assert_ok(vor_nearest_distances(apart, cloud->xyz, cloud->n, knn, run, &vt_err));
    vor_knn_free(knn);
}

/* What the field of that request, made again, says at the points of the result. */
static void follow(struct followed *point, const struct vor_cloud *out, const struct vor_cloud *in)
{
    struct vt_engine engine;
    struct vor_domain domain;
    static float apart[OUT];

    vt_engine_open(&engine, 2);
    vt_engine_count(&engine, "points", out->n);
    vt_engine_set(&engine, "density", "curvature");
    vt_assert_ok(vor_input_prepare(&domain, in, &engine.spec, &engine.run, &vt_err));
    vt_assert_ok(vor_density_make(&domain, in, out->n, &engine.spec, &engine.run, &vt_err));
    distances(apart, out, &engine.run);
    for (size_t i = 0; i < out->n; i++) {
        struct vor_field_near near;
        float x[3];

        vor_domain_normalise(&domain, &out->xyz[3 * i], x);
        vor_field_find(&near, &domain.field, x);
        point[i].rho = (float)(-4 * log((double)near.value));
        point[i].apart = (float)log((double)apart[i]);
    }
    vor_domain_free(&domain);
    vt_engine_close(&engine);
}

/* Measured: slope -0.25, delta 0.02. */
VT_TEST(spacing_follows_curvature_to_the_power_of_a_quarter)
{
    static struct followed point[OUT];
    struct vor_cloud in, out;
    struct vor_report report;
    double slope;

    make_ellipsoid(&in, IN);
    run(&out, &report, &in, "curvature", 2);
    ck_assert_uint_eq(out.n, OUT);
    ck_assert(report.has_density);
    ck_assert_msg(report.density_span > 2, "the density spans %g", report.density_span);
    follow(point, &out, &in);
    slope = slope_of(point, OUT);
    ck_assert_msg(fabs(slope + 0.25) <= 0.02, "slope %g", slope);
    ck_assert_msg(report.delta <= 0.03, "delta %g", report.delta);
    vt_free_last(&out, &in);
}

/* Gives a cloud the scalar "weight", with a spacing that goes as 1 + 2 x, or even. */
static void carry(struct vor_cloud *cloud, int is_even)
{
    struct vor_attribute *attribute;

    vt_assert_ok(
        vor_cloud_add_attribute(cloud, "weight", VOR_GENERIC, VOR_FLOAT64, 1, &attribute, &vt_err));
    for (size_t i = 0; i < cloud->n; i++)
        ((double *)attribute->data)[i] =
            is_even ? 0.25 : pow(1 + 2 * (double)cloud->xyz[3 * i], -4);
}

/* Where the result is: more than a twentieth of the square from its border. */
static int is_inside(const float *x)
{
    return x[0] > 0.05F && x[0] < 0.95F && x[1] > 0.05F && x[1] < 0.95F;
}

VT_TEST(a_planted_attribute_decides_about_the_spacing)
{
    double sum[5] = {0}, count[5] = {0}, all = 0, points = 0;
    struct vor_cloud in, out;
    struct vor_report report;
    struct vt_engine engine;
    static float apart[OUT];

    vt_cloud_square(&in, 1, IN);
    carry(&in, 0);
    run(&out, &report, &in, "attribute:weight", 2);
    vt_engine_open(&engine, 2);
    distances(apart, &out, &engine.run);
    vt_engine_close(&engine);
    for (size_t i = 0; i < out.n; i++) {
        const float *x = &out.xyz[3 * i];
        double ratio = (double)apart[i] / (1 + 2 * (double)x[0]);

        if (!is_inside(x))
            continue;
        sum[(int)(5 * x[0])] += ratio;
        count[(int)(5 * x[0])]++;
        all += ratio;
        points++;
    }
    for (int bin = 0; bin < 5; bin++)
        ck_assert_msg(fabs(sum[bin] / count[bin] / (all / points) - 1) < 0.04,
                      "from %g on the spacing is %g of what is asked for", bin / 5.0,
                      sum[bin] / count[bin] / (all / points));
    ck_assert_double_eq_tol(report.density_most / report.density_least, 3, 0.05);
    ck_assert_double_lt(report.delta, 0.06);
    vt_free_last(&out, &in);
}
