/* Fields of wanted spacing: what they are made of, how they are limited, what is refused. */
#include "core/input/density.h"
#include "tests/support/vt_made.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { N = 3000, TO = 500 };

/* A cloud's scalar "weight", of which value i is weight(x of point i). */
static void carry(struct vor_cloud *cloud, float (*weight)(const float *x))
{
    struct vor_attribute *attribute;
    float *value;

    vt_assert_ok(
        vor_cloud_add_attribute(cloud, "weight", VOR_GENERIC, VOR_FLOAT32, 1, &attribute, &vt_err));
    value = attribute->data;
    for (size_t i = 0; i < cloud->n; i++)
        value[i] = weight(&cloud->xyz[3 * i]);
}

static float even(const float *x)
{
    (void)x;
    return 7;
}

static float step(const float *x)
{
    return x[0] < 0.5F ? 0 : 1e30F;
}

static float ramp(const float *x)
{
    float h = 1 + 2 * x[0];

    return 1 / (h * h * h * h);
}

static void open_square(struct vt_made *made, size_t n, float (*weight)(const float *x))
{
    memset(made, 0, sizeof *made);
    vt_engine_open(&made->engine, 2);
    vt_cloud_square(&made->cloud, 1, n);
    carry(&made->cloud, weight);
    vt_engine_set(&made->engine, "density", "attribute:weight");
    vt_engine_count(&made->engine, "points", TO);
}

START_TEST(an_even_spread_has_no_field)
{
    struct vt_made made;

    open_square(&made, N, even);
    vt_engine_set(&made.engine, "density", "uniform");
    vt_assert_ok(vt_made_make(&made, TO));
    ck_assert(!vor_field_is(&made.domain.field));
    vt_made_close(&made);
}
END_TEST

START_TEST(a_constant_attribute_wants_an_even_spread)
{
    struct vt_made made;

    open_square(&made, N, even);
    vt_assert_ok(vt_made_make(&made, TO));
    for (size_t i = 0; i < made.domain.field.n; i++)
        ck_assert(made.domain.field.value[i] == 1);
    ck_assert_double_eq_tol(made.domain.field.even / sqrt(2 / sqrt(3) / TO), 1, 0.05);
    ck_assert(made.domain.field.span == 1);
    vt_made_close(&made);
}
END_TEST

/* Value i over the most that value j allows it at that distance. */
static double over(const struct vor_field *field, size_t i, size_t j, double grading)
{
    double apart = sqrt(vor_distance2f(&field->xyz[3 * i], &field->xyz[3 * j]));

    return (double)field->value[i] / ((double)field->value[j] + grading * apart / field->even);
}

START_TEST(no_neighbors_differ_by_more_than_contrast_and_grading_allow)
{
    enum { NEAREST = 13 };
    const char *gradings[] = {"0.1", "0.5"};
    double grading = _i ? 0.5 : 0.1, most = 0, least = INFINITY;
    struct vor_field *field;
    struct vt_made made;

    open_square(&made, N, step);
    vt_engine_set(&made.engine, "contrast", "3");
    vt_engine_set(&made.engine, "grading", gradings[_i]);
    vt_assert_ok(vt_made_make(&made, TO));
    field = &made.domain.field;
    for (size_t i = 0; i < field->n; i++) {
        uint32_t index[NEAREST];
        float distance2[NEAREST];

        most = fmax(most, (double)field->value[i]);
        least = fmin(least, (double)field->value[i]);
        vor_knn_search(field->knn, &field->xyz[3 * i], 1, NEAREST, index, distance2);
        for (size_t j = 0; j < NEAREST; j++)
            ck_assert_double_le(over(field, i, index[j], grading), 1 + 1e-6);
    }
    ck_assert(field->most == most && field->least == least);
    ck_assert_msg(most / least <= 3 * (1 + 1e-6) && most / least > (_i ? 2.9 : 2), "%g",
                  most / least);
    vt_made_close(&made);
}
END_TEST

START_TEST(the_values_ask_for_as_many_points_as_there_are)
{
    double sum = 0;
    struct vt_made made;

    open_square(&made, N, ramp);
    vt_assert_ok(vt_made_make(&made, TO));
    for (size_t i = 0; i < made.domain.field.n; i++)
        sum += pow((double)made.domain.field.value[i], -2);
    ck_assert_double_eq_tol(sum / (double)made.domain.field.n, 1, 0.05);
    vt_made_close(&made);
}
END_TEST

START_TEST(between_its_points_a_field_is_linear)
{
    struct vt_made made;

    open_square(&made, N, ramp);
    vt_assert_ok(vt_made_make(&made, TO));
    for (uint64_t i = 0; i < 200; i++) {
        float x[3] = {0.1F + 0.8F * (float)vt_unit(9, 2 * i),
                      0.1F + 0.8F * (float)vt_unit(9, 2 * i + 1), 0};
        float y[3] = {x[0] + 0.01F, x[1], 0}, in[3];
        struct vor_field_near near;
        double value;

        vor_domain_normalise(&made.domain, x, in);
        vor_field_find(&near, &made.domain.field, in);
        value = vor_field_value(&near, in);
        ck_assert_double_eq_tol(value / (1 + 2 * (double)x[0]), made.domain.field.most / 3,
                                0.02 * value);
        vor_domain_normalise(&made.domain, y, in);
        ck_assert_double_eq_tol(vor_field_value(&near, in) / (1 + 2 * (double)y[0]),
                                made.domain.field.most / 3, 0.02 * value);
    }
    vt_made_close(&made);
}
END_TEST

/* Against the spacing that the torus itself asks for; what is left is the smoothing. */
START_TEST(curvature_wants_the_spacing_that_a_torus_asks_for)
{
    double sum = 0, off = 0, ratio[2 * N];
    const struct vor_field *field;
    struct vt_made made;

    memset(&made, 0, sizeof made);
    vt_engine_open(&made.engine, 2);
    vt_cloud_torus(&made.cloud, 1, 2 * N);
    vt_engine_set(&made.engine, "density", "curvature");
    vt_engine_count(&made.engine, "points", 2 * TO);
    vt_assert_ok(vt_made_make(&made, 2 * TO));
    field = &made.domain.field;
    ck_assert_uint_ge(field->n, 3 * TO); /* as many and a half as points */
    ck_assert_uint_le(field->n, 2 * N);
    for (size_t i = 0; i < field->n; i++) {
        double x[2], away, kappa;

        for (size_t c = 0; c < 2; c++)
            x[c] = (double)field->xyz[3 * i + c] * made.domain.unit + made.domain.shift[c] +
                   made.cloud.origin[c];
        away = hypot(x[0], x[1]);
        kappa = (fabs(away - 1) / away + 1) / VT_TORUS_TUBE;
        ratio[i] = (double)field->value[i] * pow(kappa, 0.25);
        sum += ratio[i];
    }
    for (size_t i = 0; i < field->n; i++)
        off += fabs(ratio[i] / sum * (double)field->n - 1);
    ck_assert_msg(off / (double)field->n < 0.01, "off by %g", off / (double)field->n);
    ck_assert_double_gt(made.domain.field.span, 1.3);
    vt_made_close(&made);
}
END_TEST

/* What a request comes to on a square whose scalar has one value of its own at point 5. */
static vor_status with_value(float value, float others, const char *density)
{
    struct vt_made made;
    vor_status status;

    open_square(&made, 100, even);
    for (size_t i = 0; i < made.cloud.n; i++)
        ((float *)made.cloud.attributes[0].data)[i] = i == 5 ? value : others;
    vt_assert_ok(
        vor_cloud_add_attribute(&made.cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3, NULL, &vt_err));
    memset(made.cloud.attributes[1].data, 0, 300 * sizeof(float));
    vt_engine_set(&made.engine, "density", density);
    status = vt_made_make(&made, 20);
    vt_made_close(&made);
    return status;
}

START_TEST(what_is_no_density_is_refused_with_the_names_there_or_the_first_point)
{
    const char *weight = "attribute:weight";

    vt_assert_fails(VOR_E_DENSITY, with_value(-1, 1, weight));
    ck_assert_str_eq(vt_err.message, "attribute weight is -1 at point 5, want 0 or more");
    ck_assert_str_eq(vt_err.parameter, "density");
    vt_assert_fails(VOR_E_DENSITY, with_value(NAN, 1, weight));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "nan at point 5"));
    vt_assert_fails(VOR_E_DENSITY, with_value(INFINITY, 1, weight));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "inf at point 5"));
    vt_assert_fails(VOR_E_DENSITY, with_value(0, 0, weight));
    ck_assert_str_eq(
        vt_err.message,
        "attribute weight is 0 at all 100 points, from point 0 on, want more somewhere");
    vt_assert_fails(VOR_E_DENSITY, with_value(1, 1, "attribute:height"));
    ck_assert_str_eq(vt_err.message, "the input has no attribute height; its scalars are weight");
    vt_assert_fails(VOR_E_DENSITY, with_value(1, 1, "attribute:normal"));
    ck_assert_str_eq(
        vt_err.message,
        "attribute normal has 3 values a point, want 1; the input's scalars are weight");
    vt_assert_ok(with_value(1, 0, weight));
    vt_assert_ok(with_value(1e38F, 1e-38F, weight));
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("density");

    vt_add(suite, an_even_spread_has_no_field);
    vt_add(suite, a_constant_attribute_wants_an_even_spread);
    vt_add_loop(suite, no_neighbors_differ_by_more_than_contrast_and_grading_allow, 2);
    vt_add(suite, the_values_ask_for_as_many_points_as_there_are);
    vt_add(suite, between_its_points_a_field_is_linear);
    vt_add(suite, curvature_wants_the_spacing_that_a_torus_asks_for);
    vt_add(suite, what_is_no_density_is_refused_with_the_names_there_or_the_first_point);
    return vt_run(suite);
}
