/* Vectors: types and meanings of a vertex's properties. */
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ASCII "ply\nformat ascii 1.0\n"
#define LITTLE "ply\nformat binary_little_endian 1.0\n"
#define BIG "ply\nformat binary_big_endian 1.0\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define TWO "element vertex 2\n" XYZ
#define END "end_header\n"
#define F1 "\x00\x00\x80\x3f" /* 1, 2 and 3 as little-endian floats */
#define F2 "\x00\x00\x00\x40"
#define F3 "\x00\x00\x40\x40"
#define B1 "\x3f\x80\x00\x00" /* and as big-endian ones */
#define B2 "\x40\x00\x00\x00"
#define B3 "\x40\x40\x00\x00"

static const struct vor_limits limits = VOR_LIMITS_DEFAULT;

/* Reads a literal from a block of exactly its size. */
#define READ(cloud, text) read_exactly(cloud, text, sizeof(text) - 1)

static void read_exactly(struct vor_cloud *cloud, const char *text, size_t size)
{
    uint8_t *copy = malloc(size);

    ck_assert_ptr_nonnull(copy);
    memcpy(copy, text, size);
    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_ply_read(cloud, copy, size, &limits, &vt_err));
    free(copy);
}

static void assert_xyz(const struct vor_cloud *cloud, size_t i, double x, double y, double z)
{
    double at[3];

    vor_cloud_position(cloud, i, at);
    ck_assert_double_eq(at[0], x);
    ck_assert_double_eq(at[1], y);
    ck_assert_double_eq(at[2], z);
}

static double value(const struct vor_attribute *attribute, size_t k)
{
    switch (attribute->type) {
#define CASE(name, ctype, ply, sized)                                                              \
    case VOR_##name:                                                                               \
        return (double)((const ctype *)attribute->data)[k];
        VOR_TYPE_TABLE(CASE)
#undef CASE
    default:
        return NAN;
    }
}

static void assert_attribute(const struct vor_cloud *cloud, size_t index, const char *name,
                             enum vor_semantic semantic, enum vor_type type, unsigned components)
{
    const struct vor_attribute *attribute = &cloud->attributes[index];

    ck_assert_uint_lt(index, cloud->attribute_count);
    ck_assert_str_eq(attribute->name, name);
    ck_assert_int_eq(attribute->semantic, semantic);
    ck_assert_int_eq(attribute->type, type);
    ck_assert_uint_eq(attribute->components, components);
}

START_TEST(every_type_keeps_its_extremes)
{
    struct vor_cloud cloud;
    static const double least[] = {-128, 0, -32768, 0, -2147483648.0, 0};
    static const double most[] = {127, 255, 32767, 65535, 2147483647.0, 4294967295.0};

    READ(&cloud, ASCII "element vertex 2\nproperty char a\nproperty uint8 b\n" XYZ
                       "property int16 c\nproperty ushort d\nproperty int32 e\nproperty uint f\n"
                       "property float g\nproperty float64 h\n" END
                       "-128 0 0 0 0 -32768 -0 -2147483648 0 nan -inf\n"
                       "127 255 0 0 0 32767 65535 +2147483647 4294967295 3.4028234663852886e38 "
                       "1.7976931348623157e308\n");
    ck_assert_uint_eq(cloud.attribute_count, 8);
    for (unsigned i = 0; i < 6; i++) {
        char name[2] = {"abcdef"[i], 0};

        assert_attribute(&cloud, i, name, VOR_GENERIC, (enum vor_type)(VOR_INT8 + i), 1);
        ck_assert_double_eq(value(&cloud.attributes[i], 0), least[i]);
        ck_assert_double_eq(value(&cloud.attributes[i], 1), most[i]);
    }
    assert_attribute(&cloud, 6, "g", VOR_GENERIC, VOR_FLOAT32, 1);
    assert_attribute(&cloud, 7, "h", VOR_GENERIC, VOR_FLOAT64, 1);
    ck_assert(isnan(value(&cloud.attributes[6], 0)));
    ck_assert(value(&cloud.attributes[7], 0) == -INFINITY);
    ck_assert_double_eq(value(&cloud.attributes[6], 1), 3.4028234663852886e38);
    ck_assert_double_eq(value(&cloud.attributes[7], 1), 1.7976931348623157e308);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(big_endian_values_of_every_size_are_turned_round)
{
    struct vor_cloud cloud;

    READ(&cloud, BIG "element vertex 1\nproperty short a\nproperty uint b\nproperty double c\n" XYZ
                     "property char d\n" END "\xff\xfe"
                     "\1\2\3\4"
                     "\x3f\xf8\0\0\0\0\0\0" B1 B2 B3 "\xfd");
    ck_assert_double_eq(value(&cloud.attributes[0], 0), -2);
    ck_assert_double_eq(value(&cloud.attributes[1], 0), 0x01020304);
    ck_assert_double_eq(value(&cloud.attributes[2], 0), 1.5);
    ck_assert_double_eq(value(&cloud.attributes[3], 0), -3);
    assert_xyz(&cloud, 0, 1, 2, 3);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(normals_and_colours_are_put_together)
{
    struct vor_cloud cloud;

    READ(&cloud,
         ASCII "element vertex 2\n" XYZ
               "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n"
               "property uchar green\nproperty uchar blue\nproperty uchar alpha\n"
               "property float quality\n" END "0 0 0 1 2 3 4 5 6 7 8\n"
               "0 0 0 11 12 13 14 15 16 17 18\n");
    ck_assert_uint_eq(cloud.attribute_count, 3);
    assert_attribute(&cloud, 0, "normal", VOR_NORMAL, VOR_FLOAT32, 3);
    assert_attribute(&cloud, 1, "color", VOR_COLOR, VOR_UINT8, 4);
    assert_attribute(&cloud, 2, "quality", VOR_GENERIC, VOR_FLOAT32, 1);
    for (unsigned k = 0; k < 6; k++)
        ck_assert_double_eq(value(&cloud.attributes[0], k), k / 3 * 10 + k % 3 + 1);
    for (unsigned k = 0; k < 8; k++)
        ck_assert_double_eq(value(&cloud.attributes[1], k), k / 4 * 10 + k % 4 + 4);
    ck_assert_double_eq(value(&cloud.attributes[2], 1), 18);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(parts_in_any_order_are_put_together)
{
    struct vor_cloud cloud;

    READ(&cloud,
         LITTLE "element vertex 1\nproperty uchar blue\nproperty float z\nproperty float nz\n"
                "property float x\nproperty uchar green\nproperty float ny\nproperty float nx\n"
                "property uchar red\nproperty float y\n" END "\3" F3 F3 F1 "\2" F2 F1 "\1" F2);
    assert_xyz(&cloud, 0, 1, 2, 3);
    ck_assert_uint_eq(cloud.attribute_count, 2);
    assert_attribute(&cloud, 0, "color", VOR_COLOR, VOR_UINT8, 3);
    assert_attribute(&cloud, 1, "normal", VOR_NORMAL, VOR_FLOAT32, 3);
    for (unsigned k = 0; k < 3; k++) {
        ck_assert_double_eq(value(&cloud.attributes[0], k), k + 1);
        ck_assert_double_eq(value(&cloud.attributes[1], k), k + 1);
    }
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(parts_of_different_types_stay_apart)
{
    struct vor_cloud cloud;

    READ(&cloud,
         ASCII "element vertex 1\n" XYZ
               "property float nx\nproperty double ny\nproperty float nz\nproperty uchar red\n"
               "property uchar green\nproperty uchar blue\nproperty float alpha\n" END
               "0 0 0 1 2 3 4 5 6 7\n");
    ck_assert_uint_eq(cloud.attribute_count, 5);
    assert_attribute(&cloud, 0, "nx", VOR_GENERIC, VOR_FLOAT32, 1);
    assert_attribute(&cloud, 1, "ny", VOR_GENERIC, VOR_FLOAT64, 1);
    assert_attribute(&cloud, 2, "nz", VOR_GENERIC, VOR_FLOAT32, 1);
    assert_attribute(&cloud, 3, "color", VOR_COLOR, VOR_UINT8, 3);
    assert_attribute(&cloud, 4, "alpha", VOR_GENERIC, VOR_FLOAT32, 1);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(incomplete_parts_stay_apart)
{
    struct vor_cloud cloud;

    READ(&cloud, ASCII
         "element vertex 1\n" XYZ "property float nx\nproperty float ny\nproperty uchar "
         "red\nproperty uchar alpha\nproperty list uchar int green\n" END "0 0 0 1 2 3 4 1 9\n");
    ck_assert_uint_eq(cloud.attribute_count, 4);
    assert_attribute(&cloud, 0, "nx", VOR_GENERIC, VOR_FLOAT32, 1);
    assert_attribute(&cloud, 3, "alpha", VOR_GENERIC, VOR_UINT8, 1);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(diffuse_colours_are_colours_unless_there_are_plain_ones)
{
#define DIFFUSE                                                                                    \
    "property uchar diffuse_red\nproperty uchar diffuse_green\nproperty uchar diffuse_blue\n"
    struct vor_cloud cloud;

    READ(&cloud, ASCII "element vertex 1\n" XYZ DIFFUSE END "0 0 0 1 2 3\n");
    ck_assert_uint_eq(cloud.attribute_count, 1);
    assert_attribute(&cloud, 0, "color", VOR_COLOR, VOR_UINT8, 3);
    vor_cloud_free(&cloud);
    READ(&cloud, ASCII "element vertex 1\n" XYZ DIFFUSE
                       "property uchar red\nproperty uchar green\nproperty uchar blue\n" END
                       "0 0 0 1 2 3 4 5 6\n");
    ck_assert_uint_eq(cloud.attribute_count, 4);
    assert_attribute(&cloud, 0, "diffuse_red", VOR_GENERIC, VOR_UINT8, 1);
    assert_attribute(&cloud, 3, "color", VOR_COLOR, VOR_UINT8, 3);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(float_coordinates_are_kept_bit_for_bit)
{
    static const char file[] = LITTLE TWO END "\0\0\0\x80"
                                              "\1\0\0\0"
                                              "\xff\xff\x7f\x7f"
                                              "\xff\xff\x7f\xff"
                                              "\1\2\3\4"
                                              "\0\0\x80\0";
    struct vor_cloud cloud;

    read_exactly(&cloud, file, sizeof file - 1);
    ck_assert_mem_eq(cloud.xyz, file + sizeof file - 1 - 24, 24);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(double_and_wide_integer_coordinates_get_an_origin)
{
    static const char *const types[] = {"double", "int", "uint", "float64"};
    char file[256];

    for (int i = 0; i < 4; i++) {
        struct vor_cloud cloud;

        (void)snprintf(file, sizeof file,
                       ASCII
                       "element vertex 2\nproperty float x\nproperty %s y\nproperty uchar z\n" END
                       "0.5 500000001 7\n1.5 500000003 9\n",
                       types[i]);
        read_exactly(&cloud, file, strlen(file));
        ck_assert_int_eq(cloud.position_type, VOR_FLOAT64);
        assert_xyz(&cloud, 0, 0.5, 500000001, 7);
        assert_xyz(&cloud, 1, 1.5, 500000003, 9);
        vor_cloud_free(&cloud);
    }
    vt_assert_no_leak();
}
END_TEST

/* PLY 1.0 has no such types; files with their names exist. */
START_TEST(integers_of_64_bits_are_read_where_they_are_named)
{
    struct vor_cloud cloud;

    READ(&cloud, ASCII "element vertex 1\nproperty int64 x\nproperty uint64 y\nproperty float z\n"
                       "property int64 t\n" END "-5 7 9 -9007199254740993\n");
    assert_xyz(&cloud, 0, -5, 7, 9);
    assert_attribute(&cloud, 0, "t", VOR_GENERIC, VOR_INT64, 1);
    ck_assert(*(const int64_t *)cloud.attributes[0].data == -INT64_C(9007199254740993));
    vor_cloud_free(&cloud);
    READ(&cloud,
         BIG "element vertex 1\nproperty int64 x\nproperty uint64 y\nproperty uint32 z\n" END
             "\xff\xff\xff\xff\xff\xff\xff\xfb"
             "\0\0\0\0\0\0\0\7"
             "\0\0\0\x9");
    assert_xyz(&cloud, 0, -5, 7, 9);
    vor_cloud_free(&cloud);
}
END_TEST

START_TEST(strange_names_are_made_fit)
{
    struct vor_cloud cloud;

    READ(&cloud,
         ASCII "element vertex 1\n" XYZ "property int h\xc3\xb6he\nproperty int h\xc3\xa4he\n"
               "property int normal\nproperty float nx\nproperty float ny\nproperty float nz\n"
               "property int "
               "a23456789012345678901234567890123456789012345678901234567890123456789\n" END
               "0 0 0 1 2 3 4 5 6 7\n");
    assert_attribute(&cloud, 0, "h\xc3\xb6he", VOR_GENERIC, VOR_INT32, 1);
    assert_attribute(&cloud, 1, "h\xc3\xa4he", VOR_GENERIC, VOR_INT32, 1);
    assert_attribute(&cloud, 2, "normal", VOR_GENERIC, VOR_INT32, 1);
    assert_attribute(&cloud, 3, "normal_2", VOR_NORMAL, VOR_FLOAT32, 3);
    ck_assert_uint_eq(strlen(cloud.attributes[4].name), 63);
    vor_cloud_free(&cloud);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("ply_attributes");

    vt_add(suite, every_type_keeps_its_extremes);
    vt_add(suite, big_endian_values_of_every_size_are_turned_round);
    vt_add(suite, normals_and_colours_are_put_together);
    vt_add(suite, parts_in_any_order_are_put_together);
    vt_add(suite, parts_of_different_types_stay_apart);
    vt_add(suite, incomplete_parts_stay_apart);
    vt_add(suite, diffuse_colours_are_colours_unless_there_are_plain_ones);
    vt_add(suite, float_coordinates_are_kept_bit_for_bit);
    vt_add(suite, double_and_wide_integer_coordinates_get_an_origin);
    vt_add(suite, integers_of_64_bits_are_read_where_they_are_named);
    vt_add(suite, strange_names_are_made_fit);
    return vt_run(suite);
}
