/* The cloud: types, attributes, and positions relative to an origin. */
#include "tests/support/vt.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 40, N = 500 };

VT_TEST(both_spellings_of_every_type_are_read)
{
    enum vor_type type;

    for (int t = 0; t < VOR_TYPE_COUNT; t++) {
        const char *names[2] = {vor_type_name((enum vor_type)t),
                                vor_type_name_sized((enum vor_type)t)};

        for (int k = 0; k < 2; k++) {
            ck_assert(vor_type_parse(&type, names[k], strlen(names[k])));
            ck_assert_int_eq(type, t);
            ck_assert(!vor_type_parse(&type, names[k], strlen(names[k]) - 1) ||
                      type != (enum vor_type)t);
        }
    }
    ck_assert(!vor_type_parse(&type, "", 0));
    ck_assert(!vor_type_parse(&type, "Float", 5));
    ck_assert(vor_type_parse(&type, "floats", 5));
    ck_assert_int_eq(type, VOR_FLOAT32);
    ck_assert_str_eq(vor_type_name(VOR_INT64), "int64");
    ck_assert_uint_eq(vor_type_size(VOR_UINT16), 2);
    ck_assert_uint_eq(vor_type_size(VOR_FLOAT64), 8);
}

VT_TEST(a_cloud_has_1_to_the_greatest_number_of_points)
{
    struct vor_memory memory;
    struct vor_cloud cloud;

    vor_memory_init(&memory, 1 << 20);
    vor_cloud_init(&cloud, &memory);
    vt_assert_fails(VOR_E_EMPTY, vor_cloud_resize(&cloud, 0, &vt_err));
    vt_assert_fails(VOR_E_LIMIT, vor_cloud_resize(&cloud, VOR_POINTS_MAX + 1, &vt_err));
    ck_assert_uint_eq(vt_err.limit, VOR_POINTS_MAX);
    ck_assert_uint_eq(vt_err.got, VOR_POINTS_MAX + 1);
    vt_assert_fails(VOR_E_LIMIT, vor_cloud_resize(&cloud, SIZE_MAX, &vt_err));
    vt_assert_fails(VOR_E_NOMEM, vor_cloud_resize(&cloud, VOR_POINTS_MAX, &vt_err));
    ck_assert_uint_eq(cloud.n, 0);
    vt_assert_ok(vor_cloud_resize(&cloud, 1, &vt_err));
    vor_cloud_free(&cloud);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
}

VT_TEST(names_that_are_taken_get_a_suffix)
{
    struct vor_cloud cloud;
    char name[64];

    vt_cloud_cube(&cloud, 1, 2);
    for (int i = 1; i <= 12; i++) {
        struct vor_attribute *out;

        vt_assert_ok(
            vor_cloud_add_attribute(&cloud, "a", VOR_GENERIC, VOR_UINT8, 1, &out, &vt_err));
        (void)snprintf(name, sizeof name, i == 1 ? "a" : "a_%d", i);
        ck_assert_str_eq(out->name, name);
        ck_assert_ptr_eq(vor_cloud_find_name(&cloud, name), out);
    }
    vt_assert_ok(vor_cloud_add_attribute(&cloud, "b_2", VOR_GENERIC, VOR_UINT8, 1, NULL, &vt_err));
    vt_assert_ok(vor_cloud_add_attribute(&cloud, "b", VOR_GENERIC, VOR_UINT8, 1, NULL, &vt_err));
    vt_assert_ok(vor_cloud_add_attribute(&cloud, "b", VOR_GENERIC, VOR_UINT8, 1, NULL, &vt_err));
    ck_assert_str_eq(cloud.attributes[14].name, "b_3");
    vor_cloud_free(&cloud);
}

VT_TEST(long_names_are_cut_and_stay_unique)
{
    struct vor_cloud cloud;
    char name[200];

    memset(name, 'n', sizeof name);
    name[sizeof name - 1] = '\0';
    vt_cloud_cube(&cloud, 1, 2);
    for (int i = 0; i < VOR_ATTRIBUTES_MAX; i++)
        vt_assert_ok(
            vor_cloud_add_attribute(&cloud, name, VOR_GENERIC, VOR_UINT8, 1, NULL, &vt_err));
    for (size_t i = 0; i < VOR_ATTRIBUTES_MAX; i++)
        ck_assert_ptr_eq(vor_cloud_find_name(&cloud, cloud.attributes[i].name),
                         &cloud.attributes[i]);
    vt_assert_fails(VOR_E_LIMIT, vor_cloud_add_attribute(&cloud, "one more", VOR_GENERIC, VOR_UINT8,
                                                         1, NULL, &vt_err));
    ck_assert_uint_eq(cloud.attribute_count, VOR_ATTRIBUTES_MAX);
    vor_cloud_free(&cloud);
}

VT_TEST(the_first_attribute_of_a_meaning_is_found)
{
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 2);
    ck_assert_ptr_null(vor_cloud_find(&cloud, VOR_NORMAL));
    ck_assert_ptr_null(vor_cloud_find_name(&cloud, "normal"));
    vt_assert_ok(vor_cloud_add_attribute(&cloud, "q", VOR_GENERIC, VOR_FLOAT32, 1, NULL, &vt_err));
    vt_assert_ok(vor_cloud_add_attribute(&cloud, "n", VOR_NORMAL, VOR_FLOAT32, 3, NULL, &vt_err));
    vt_assert_ok(vor_cloud_add_attribute(&cloud, "m", VOR_NORMAL, VOR_FLOAT32, 3, NULL, &vt_err));
    ck_assert_ptr_eq(vor_cloud_find(&cloud, VOR_NORMAL), &cloud.attributes[1]);
    ck_assert_ptr_null(vor_cloud_find(&cloud, VOR_COLOR));
    vor_cloud_free(&cloud);
}

VT_TEST(an_attribute_that_does_not_fit_leaves_the_cloud_as_it_was)
{
    struct vor_memory memory;
    struct vor_cloud cloud;

    vor_memory_init(&memory, 4096);
    vor_cloud_init(&cloud, &memory);
    vt_assert_ok(vor_cloud_resize(&cloud, 100, &vt_err));
    vt_assert_fails(VOR_E_NOMEM, vor_cloud_add_attribute(&cloud, "a", VOR_GENERIC, VOR_FLOAT64, 16,
                                                         NULL, &vt_err));
    ck_assert_uint_eq(cloud.attribute_count, 0);
    vor_cloud_free(&cloud);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    ck_assert_ptr_null(cloud.xyz);
}

static void from_doubles(struct vor_cloud *cloud, const double *xyz, size_t n)
{
    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_cloud_resize(cloud, n, &vt_err));
    vt_assert_ok(vor_cloud_set_double(cloud, xyz, &vt_err));
}

/* Coordinates that a shift by the steps below leaves exact: multiples of 2^-16 below 2^10. */
static double *grid_points(uint64_t seed)
{
    double *xyz = malloc(3 * N * sizeof *xyz);
    double scale = ldexp(1, -(int)(seed % 8));

    ck_assert_ptr_nonnull(xyz);
    for (size_t i = 0; i < 3 * N; i++)
        xyz[i] = floor(vt_unit(seed, i) * 0x1p26) * 0x1p-16 * scale;
    return xyz;
}

/* Property: what cloud.h promises of a shift. */
VT_TEST_LOOP(a_shifted_cloud_has_the_same_relative_bits, SEEDS)
{
    static const double steps[] = {0.25, 1e6 + 0.25, -1e6 - 0.25, 6.1e6 + 0.5, 0x1p24};
    double *xyz = grid_points((uint64_t)_i);
    struct vor_cloud still, shifted;

    from_doubles(&still, xyz, N);
    for (size_t s = 0; s < sizeof steps / sizeof steps[0]; s++) {
        double *moved = malloc(3 * N * sizeof *moved);

        ck_assert_ptr_nonnull(moved);
        for (size_t i = 0; i < 3 * N; i++)
            moved[i] = xyz[i] + steps[s] * (double)(1 + i % 3);
        from_doubles(&shifted, moved, N);
        ck_assert_mem_eq(still.xyz, shifted.xyz, 12 * N);
        for (int c = 0; c < 3; c++)
            ck_assert_double_eq(shifted.origin[c] - still.origin[c], steps[s] * (1 + c));
        vor_cloud_free(&shifted);
        free(moved);
    }
    vor_cloud_free(&still);
    free(xyz);
}

/* Property: the positions move by at most extent / 2^25, and are exact multiples of a power of two
 * from the lower corner. */
VT_TEST_LOOP(positions_move_by_at_most_half_a_cell, SEEDS)
{
    double *xyz = malloc(3 * N * sizeof *xyz);
    double scale = ldexp(1, (int)(_i * 11) - 200), extent = 0;
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    struct vor_cloud cloud;

    ck_assert_ptr_nonnull(xyz);
    for (size_t i = 0; i < 3 * N; i++) {
        xyz[i] = scale * (vt_unit((uint64_t)_i, i) - (_i % 2 == 0 ? 0.5 : 100));
        low[i % 3] = fmin(low[i % 3], xyz[i]);
        high[i % 3] = fmax(high[i % 3], xyz[i]);
    }
    for (int c = 0; c < 3; c++)
        extent = fmax(extent, high[c] - low[c]);
    if (extent < 0x1p-100)
        extent = 0x1p-100; /* below it the grid no longer shrinks, to keep clear of denormals */
    if (extent > FLT_MAX / 4)
        goto done;
    from_doubles(&cloud, xyz, N);
    ck_assert_int_eq(cloud.position_type, VOR_FLOAT64);
    for (size_t i = 0; i < N; i++) {
        double at[3];

        vor_cloud_position(&cloud, i, at);
        for (int c = 0; c < 3; c++) {
            /* one rounding of the sum of origin and position */
            double bound = ldexp(extent, -25) + fabs(at[c]) * 0x1p-52;

            ck_assert_double_le(fabs(at[c] - xyz[3 * i + (size_t)c]), bound);
            ck_assert(fpclassify(cloud.xyz[3 * i + (size_t)c]) != FP_SUBNORMAL);
        }
    }
    vor_cloud_free(&cloud);
done:
    free(xyz);
}

VT_TEST(coincident_doubles_stay_where_they_are)
{
    const double xyz[] = {5.5e6, -0.125, 3, 5.5e6, -0.125, 3};
    struct vor_cloud cloud;
    double at[3];

    from_doubles(&cloud, xyz, 2);
    ck_assert_mem_eq(cloud.xyz, cloud.xyz + 3, 12);
    vor_cloud_position(&cloud, 1, at);
    ck_assert_mem_eq(at, xyz, sizeof at);
    vor_cloud_free(&cloud);
}

VT_TEST(a_double_that_is_not_finite_is_named)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY};

    for (int i = 0; i < 9; i++) {
        double xyz[] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
        struct vor_cloud cloud;
        char want[48];

        xyz[i] = bad[i % 3];
        vor_cloud_init(&cloud, &vt_memory);
        vt_assert_ok(vor_cloud_resize(&cloud, 3, &vt_err));
        vt_assert_fails(VOR_E_NONFINITE, vor_cloud_set_double(&cloud, xyz, &vt_err));
        (void)snprintf(want, sizeof want, "coordinate %c of point %d", "xyz"[i % 3], i / 3);
        ck_assert_msg(strstr(vt_err.message, want) != NULL, "%s", vt_err.message);
        vor_cloud_free(&cloud);
    }
}

VT_TEST(doubles_farther_apart_than_float32_reaches_are_refused)
{
    static const double reach[] = {1e39, 1e300, DBL_MAX};

    for (int i = 0; i < 3; i++) {
        const double xyz[] = {-reach[i], 0, 0, reach[i], 0, 0};
        struct vor_cloud cloud;

        vor_cloud_init(&cloud, &vt_memory);
        vt_assert_ok(vor_cloud_resize(&cloud, 2, &vt_err));
        vt_assert_fails(VOR_E_NONFINITE, vor_cloud_set_double(&cloud, xyz, &vt_err));
        vor_cloud_free(&cloud);
    }
}

VT_TEST(a_check_finds_what_no_codec_may_hand_on)
{
    struct vor_cloud cloud;

    vor_cloud_init(&cloud, &vt_memory);
    vt_assert_fails(VOR_E_EMPTY, vor_cloud_check(&cloud, &vt_err));
    vt_cloud_cube(&cloud, 1, 10);
    vt_assert_ok(vor_cloud_check(&cloud, &vt_err));
    cloud.xyz[17] = NAN;
    vt_assert_fails(VOR_E_NONFINITE, vor_cloud_check(&cloud, &vt_err));
    ck_assert_msg(strstr(vt_err.message, "coordinate z of point 5") != NULL, "%s", vt_err.message);
    cloud.xyz[17] = FLT_MAX;
    vt_assert_ok(vor_cloud_check(&cloud, &vt_err));
    cloud.origin[1] = INFINITY;
    vt_assert_fails(VOR_E_NONFINITE, vor_cloud_check(&cloud, &vt_err));
    vor_cloud_free(&cloud);
}

VT_TEST(all_that_belongs_to_a_point_moves_with_it)
{
    static const uint32_t order[4] = {2, 0, 3, 1};
    struct vor_memory memory;
    struct vor_attribute *label;
    struct vor_cloud cloud;

    vor_memory_init(&memory, SIZE_MAX);
    vor_cloud_init(&cloud, &memory);
    vt_assert_ok(vor_cloud_resize(&cloud, 4, &vt_err));
    vt_assert_ok(
        vor_cloud_add_attribute(&cloud, "label", VOR_GENERIC, VOR_INT64, 2, &label, &vt_err));
    for (int i = 0; i < 12; i++)
        cloud.xyz[i] = (float)i;
    for (int i = 0; i < 8; i++)
        ((int64_t *)label->data)[i] = i;
    memory.cap = atomic_load(&memory.used);
    vt_assert_fails(VOR_E_NOMEM, vor_cloud_reorder(&cloud, order, &vt_err));
    ck_assert(cloud.xyz[3] == 3 && ((int64_t *)label->data)[2] == 2);
    memory.cap = SIZE_MAX;
    vt_assert_ok(vor_cloud_reorder(&cloud, order, &vt_err));
    for (int i = 0; i < 12; i++)
        ck_assert(cloud.xyz[i] == (float)(3 * (int)order[i / 3] + i % 3));
    for (int i = 0; i < 8; i++)
        ck_assert_int_eq(((int64_t *)label->data)[i], 2 * (int)order[i / 2] + i % 2);
    vor_cloud_free(&cloud);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
}
