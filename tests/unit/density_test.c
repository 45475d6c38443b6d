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

static void open_square(struct vt_made *made, size_t n, float (*weight)(const float *x))
{
    memset(made, 0, sizeof *made);
    vt_engine_open(&made->engine, 2);
    vt_cloud_square(&made->cloud, 1, n);
    carry(&made->cloud, weight);
    vt_engine_set(&made->engine, "density", "attribute:weight");
    vt_engine_count(&made->engine, "points", TO);
}

/* Value i over the most that value j allows it at that distance. */
static double over(const struct vor_field *field, size_t i, size_t j, double grading)
{
    double apart = sqrt(vor_distance2f(&field->xyz[3 * i], &field->xyz[3 * j]));

    return (double)field->value[i] / ((double)field->value[j] + grading * apart / field->even);
}

VT_TEST_LOOP(no_neighbors_differ_by_more_than_contrast_and_grading_allow, 2)
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

static float along(const float *x)
{
    return x[0];
}

/* Lv 2022, Sec. 4.2: groups of equal area, and of spacings in the paper's ratios. */
VT_TEST_LOOP(groups_have_equal_areas_and_the_ratios_of_the_paper, 2)
{
    static const double ratio[2][5] = {{1.5, 1, 0.6}, {2, 1.5, 1, 0.8, 0.6}};
    size_t groups = _i ? 5 : 3, count[5] = {0};
    struct vt_made made;

    open_square(&made, N, along);
    vt_engine_set(&made.engine, "groups", _i ? "5" : "3");
    vt_engine_set(&made.engine, "grading", "1");
    vt_assert_ok(vt_made_make(&made, TO));
    for (size_t i = 0; i < made.domain.field.n; i++)
        for (size_t q = 0; q < groups; q++)
            count[q] += fabs((double)made.domain.field.value[i] / made.domain.field.least -
                             ratio[_i][q] / 0.6) < 0.01;
    for (size_t q = 0; q < groups; q++) {
        double share = (double)(groups * count[q]) / (double)made.domain.field.n;

        ck_assert_msg(share > 0.7 && share < 1.2, "group %zu: %g", q, share);
    }
    vt_made_close(&made);
}

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

VT_TEST(what_is_no_density_is_refused_with_the_names_there_or_the_first_point)
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
        "attribute weight is 0 at all 100 points, want a value above 0 at one or more points");
    vt_assert_fails(VOR_E_DENSITY, with_value(1, 1, "attribute:height"));
    ck_assert_str_eq(vt_err.message, "the input has no attribute height; its scalars are weight");
    vt_assert_fails(VOR_E_DENSITY, with_value(1, 1, "attribute:normal"));
    ck_assert_str_eq(
        vt_err.message,
        "attribute normal has 3 values per point, want 1; the input's scalars are weight");
    vt_assert_ok(with_value(1, 0, weight));
    vt_assert_ok(with_value(1e38F, 1e-38F, weight));
}
