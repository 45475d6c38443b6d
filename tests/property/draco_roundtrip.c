/* What the Draco writer promises, on many random clouds and attribute sets. */
#include "proto/draco/draco_quantize.h"
#include "tests/unit/draco_files.h"

#include <float.h>
#include <stdio.h>

/* Any bytes but those of a float that is not a number or not finite. */
static void fill(struct vor_attribute *attribute, uint64_t seed, size_t n)
{
    size_t count = n * attribute->components, size = vor_type_size(attribute->type);
    uint8_t *bytes = attribute->data;
    float *reals = attribute->data;

    for (size_t i = 0; i < count * size; i++)
        bytes[i] = (uint8_t)(256 * vt_unit(seed, i));
    for (size_t i = 0; attribute->type == VOR_FLOAT32 && i < count; i++)
        if (!isfinite(reals[i]))
            reals[i] = -0.0f;
}

/* Up to six attributes of any meaning, type and number of components. */
static void add_attributes(struct vor_cloud *cloud, uint64_t seed)
{
    size_t count = (size_t)(7 * vt_unit(seed, 0));

    for (size_t i = 0; i < count; i++) {
        enum vor_type type = (enum vor_type)(VOR_TYPE_COUNT * vt_unit(seed, 3 * i + 1));
        enum vor_semantic semantic = (enum vor_semantic)(3 * vt_unit(seed, 3 * i + 2));
        unsigned components = semantic != VOR_GENERIC
                                  ? 3
                                  : 1 + (unsigned)(i == 0 ? 16 * vt_unit(seed, 3 * i + 3)
                                                          : 3 * vt_unit(seed, 3 * i + 3));
        char name[32];

        (void)snprintf(name, sizeof name, "a%zu", i);
        (void)draco_add(cloud, name, semantic, type, components);
        fill(&cloud->attributes[cloud->attribute_count - 1], seed + 1 + i, cloud->n);
    }
}

/* Coordinates of any magnitude, some of them denormal or -0. */
static void wild_positions(struct vor_cloud *cloud, uint64_t seed)
{
    for (size_t i = 0; i < 3 * cloud->n; i++) {
        float mantissa = (float)(2 * vt_unit(seed, 2 * i) - 1);

        cloud->xyz[i] = ldexpf(mantissa, (int)(250 * vt_unit(seed, 2 * i + 1)) - 140);
    }
    cloud->xyz[0] = -0.0f;
    cloud->xyz[3 * cloud->n - 1] = FLT_TRUE_MIN;
}

/* Property: quantization 0 keeps every bit and the order, whatever keep_order says. */
VT_TEST_LOOP(lossless_is_bit_exact, 60)
{
    uint64_t seed = 100 + (uint64_t)_i;
    struct vor_cloud cloud, back;

    vt_cloud_cube(&cloud, seed, 1 + (size_t)(300 * vt_unit(seed, 1)));
    if (_i % 2 == 1)
        wild_positions(&cloud, seed);
    if (_i % 3 == 0) {
        cloud.origin[0] = 637123.4567890123;
        cloud.origin[1] = -4.25e6;
        cloud.origin[2] = 1e-300;
        cloud.position_type = _i % 2 == 0 ? VOR_FLOAT64 : VOR_FLOAT32;
    }
    add_attributes(&cloud, seed);
    draco_trip(&back, &cloud, 0, _i & 2);
    ck_assert_mem_eq(back.origin, cloud.origin, sizeof cloud.origin);
    ck_assert_int_eq(back.position_type, cloud.position_type);
    ck_assert_mem_eq(back.xyz, cloud.xyz, 3 * cloud.n * sizeof *cloud.xyz);
    ck_assert_uint_eq(back.attribute_count, cloud.attribute_count);
    for (size_t i = 0; i < cloud.attribute_count; i++)
        draco_assert_same(&back, &cloud, cloud.attributes[i].name, NULL);
    vt_free_last(&back, &cloud);
}

/* Half a cell of the bits asked for, and what float32 rounds off on the way there and back. */
static double tolerance(const struct vor_cloud *cloud, int bits)
{
    double extent = draco_extent(cloud), largest = 0;

    for (size_t i = 0; i < 3 * cloud->n; i++) { /* fmax in this loop crashes gcc 12 for arm64 */
        double x = fabs((double)cloud->xyz[i]);

        largest = x > largest ? x : largest;
    }
    return extent / (ldexp(1, bits) - 1) / 2 + 2 * FLT_EPSILON * (largest + extent);
}

/* Property: both encodings move points by at most half a cell, the kd-tree gives a permutation, the
 * origin comes back to the bit, and integers and doubles are exact. */
VT_TEST_LOOP(quantised_points_move_by_at_most_half_a_cell, 90)
{
    uint64_t seed = 200 + (uint64_t)_i;
    int bits = 1 + _i % 30;
    struct vor_cloud cloud, back;
    uint32_t *numbers;
    double bound;

    vt_cloud_cube(&cloud, seed, 1 + (size_t)(2000 * vt_unit(seed, 1)));
    for (size_t i = 0; i < 3 * cloud.n; i++)
        cloud.xyz[i] = (cloud.xyz[i] - 0.5f) * ldexpf(1, (int)(40 * vt_unit(seed, 2)) - 20);
    if (_i % 3 == 0) {
        cloud.origin[0] = 637000.123456789 + _i;
        cloud.origin[1] = 5849000.987654321;
        cloud.origin[2] = 1e-300;
        cloud.position_type = _i % 2 == 0 ? VOR_FLOAT64 : VOR_FLOAT32;
    }
    draco_number(&cloud);
    add_attributes(&cloud, seed);
    draco_trip(&back, &cloud, bits, _i & 1);
    numbers = draco_numbers(&back);
    bound = tolerance(&cloud, bits);
    ck_assert_mem_eq(back.origin, cloud.origin, sizeof cloud.origin);
    ck_assert_int_eq(back.position_type, cloud.position_type);
    for (size_t i = 0; i < back.n; i++) {
        ck_assert_msg(!(_i & 1) || numbers[i] == i, "point %zu is not in its place", i);
        for (size_t c = 0; c < 3; c++)
            must_be_near(back.xyz[3 * i + c], cloud.xyz[3 * numbers[i] + c], bound);
    }
    for (size_t i = 0; i < cloud.attribute_count; i++)
        if (cloud.attributes[i].type != VOR_FLOAT32)
            draco_assert_same(&back, &cloud, cloud.attributes[i].name, numbers);
    free(numbers);
    vt_free_last(&back, &cloud);
}

/* Property: float attributes are off by half a step of their range, 16 bits of it; where they are
 * whole numbers (or any multiples of a power of two) they are exact. */
VT_TEST_LOOP(float_attributes_are_exact_on_a_grid_and_close_off_it, 20)
{
    uint64_t seed = 300 + (uint64_t)_i;
    struct vor_cloud cloud, back;
    const float *off, *was;
    uint32_t *numbers;
    float *on, *of, range = 0;

    vt_cloud_cube(&cloud, seed, 500);
    draco_number(&cloud);
    on = draco_add(&cloud, "on", VOR_GENERIC, VOR_FLOAT32, 2);
    for (size_t i = 0; i < 1000; i++)
        on[i] = ldexpf(floorf((float)(3000000 * vt_unit(seed, 10 + i))) - 1000000, _i * 6 - 60);
    of = draco_add(&cloud, "off", VOR_GENERIC, VOR_FLOAT32, 1);
    for (size_t i = 0; i < 500; i++) {
        of[i] = (float)(100 * vt_unit(seed, 2000 + i));
        range = fmaxf(range, of[i]);
    }
    draco_trip(&back, &cloud, 12, _i & 1);
    numbers = draco_numbers(&back);
    draco_assert_same(&back, &cloud, "on", numbers);
    off = vor_cloud_find_name(&back, "off")->data;
    was = vor_cloud_find_name(&cloud, "off")->data;
    for (size_t i = 0; i < 500; i++)
        must_be_near(off[i], was[numbers[i]], (double)range / 65535 / 2 + 2e-5);
    free(numbers);
    vt_free_last(&back, &cloud);
}

static int by_place(const void *a, const void *b)
{
    const float *p = a, *q = b;

    for (int c = 0; c < 3; c++)
        if (p[c] != q[c])
            return p[c] < q[c] ? -1 : 1;
    return 0;
}

static size_t distinct(struct vor_cloud *cloud)
{
    size_t count = 1;

    qsort(cloud->xyz, cloud->n, 3 * sizeof *cloud->xyz, by_place);
    for (size_t i = 1; i < cloud->n; i++)
        count += by_place(cloud->xyz + 3 * i, cloud->xyz + 3 * (i - 1)) != 0;
    return count;
}

/* Property: with auto as many places come out as went in, however close some of the points are and
 * however far from 0, and cells are no larger than spacing / 200. */
VT_TEST_LOOP(auto_never_makes_points_coincide, 24)
{
    uint64_t seed = 400 + (uint64_t)_i;
    double spacing = _i % 3 == 0 ? 0 : 0.05, bound;
    struct vor_write_options options = {
        .quantization_bits = -1, .compression = 7, .keep_order = _i & 1, .spacing = spacing};
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {.ctx = &bytes, .write = vt_bytes_write};
    struct vor_cloud cloud, back;
    uint32_t *numbers;

    vt_cloud_sphere(&cloud, seed, 800);
    for (size_t i = 3 * 400; i < 3 * 800; i++) /* half of the points beside another one */
        cloud.xyz[i] = cloud.xyz[i - 3 * 400] + ldexpf(1, -_i) * (float)vt_unit(seed, i);
    for (size_t i = 0; i < 3 * 800; i++)
        cloud.xyz[i] += _i % 4 == 0 ? 1000 : 0;
    draco_number(&cloud);
    vt_assert_ok(vor_draco_write(&sink, &cloud, &options, &vt_err));
    vt_assert_ok(draco_decode(&back, &bytes));
    numbers = draco_numbers(&back);
    bound = (spacing > 0 ? spacing : draco_extent(&cloud) / sqrt(800)) / 200 / 2;
    bound += 2 * (double)FLT_EPSILON * (_i % 4 == 0 ? 1001 : 2);
    for (size_t i = 0; i < 3 * back.n; i++)
        must_be_near(back.xyz[i], cloud.xyz[3 * numbers[i / 3] + i % 3], bound);
    ck_assert_uint_eq(distinct(&back), distinct(&cloud));
    free(numbers);
    free(bytes.data);
    vt_free_last(&back, &cloud);
}

/* Property: auto takes the smallest number of bits that will do. */
VT_TEST_LOOP(auto_takes_no_bit_more_than_it_must, 20)
{
    double spacing = ldexp(1, -_i);
    struct vor_draco_column column = {
        .kind = VOR_DRACO_POSITION, .scalar = VOR_DRACO_FLOAT32, .components = 3};
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 500, 64);
    for (size_t i = 0; i < 64; i++) /* a grid of 4 x 4 x 4, 3 across: nothing can coincide */
        for (size_t c = 0; c < 3; c++)
            cloud.xyz[3 * i + c] = (float)(i >> 2 * c & 3);
    column.data = cloud.xyz;
    ck_assert(vor_draco_bound(&column, 64));
    ck_assert_float_eq(column.range, 3);
    vt_assert_ok(vor_draco_fit_positions(&column, &cloud, spacing, &vt_err));
    ck_assert_double_le(3 / (ldexp(1, column.bits) - 1), spacing / 200);
    ck_assert_double_gt(3 / (ldexp(1, column.bits - 1) - 1), spacing / 200);
    vor_cloud_free(&cloud);
}
