/* Vectors and refusals: the bytes the PLY writer makes, and a sink that takes no more. */
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void fresh(struct vor_cloud *cloud, size_t n)
{
    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_cloud_resize(cloud, n, &vt_err));
    for (size_t i = 0; i < 3 * n; i++)
        cloud->xyz[i] = (float)(i + 1);
}

static void *attribute(struct vor_cloud *cloud, const char *name, enum vor_semantic semantic,
                       enum vor_type type, unsigned components)
{
    struct vor_attribute *out;

    vt_assert_ok(vor_cloud_add_attribute(cloud, name, semantic, type, components, &out, &vt_err));
    memset(out->data, 0, cloud->n * components * vor_type_size(type));
    return out->data;
}

static struct vt_bytes written(const struct vor_cloud *cloud)
{
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {&bytes, vt_bytes_write};

    vt_assert_ok(vor_ply_write(&sink, cloud, NULL, &vt_err));
    return bytes;
}

/* The file's header up to the line end_header, as a string. */
static char *header_of(const struct vor_cloud *cloud)
{
    struct vt_bytes bytes = written(cloud);
    char *end;

    ck_assert_int_eq(vt_bytes_write(&bytes, "", 1), 0);
    end = strstr((char *)bytes.data, "end_header\n");
    ck_assert_ptr_nonnull(end);
    *end = '\0';
    return (char *)bytes.data;
}

static void assert_bytes(struct vt_bytes bytes, const char *want, size_t size)
{
    ck_assert_uint_eq(bytes.size, size);
    ck_assert_mem_eq(bytes.data, want, size);
    free(bytes.data);
}

#define HEAD(n)                                                                                    \
    "ply\nformat binary_little_endian 1.0\ncomment written by voronoid\nelement vertex " #n "\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"

VT_TEST(a_float_cloud_has_these_bytes)
{
    static const char want[] = HEAD(2) XYZ
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty short label\n"
        "end_header\n"
        "\0\0\x80\x3f"
        "\0\0\0\x40"
        "\0\0\x40\x40"
        "\1\2\3"
        "\xfe\xff"
        "\0\0\x80\x40"
        "\0\0\xa0\x40"
        "\0\0\xc0\x40"
        "\4\5\6"
        "\xff\x7f";
    struct vor_cloud cloud;
    int16_t *label;

    fresh(&cloud, 2);
    memcpy(attribute(&cloud, "color", VOR_COLOR, VOR_UINT8, 3), "\1\2\3\4\5\6", 6);
    label = attribute(&cloud, "label", VOR_GENERIC, VOR_INT16, 1);
    label[0] = -2;
    label[1] = 32767;
    assert_bytes(written(&cloud), want, sizeof want - 1);
    vor_cloud_free(&cloud);
}

VT_TEST(a_double_cloud_has_these_bytes)
{
    static const char want[] =
        HEAD(1) "property double x\nproperty double y\nproperty double z\nend_header\n"
                "\0\0\0\0\0\0\xf8\x3f"     /* 0.5 + 1 */
                "\0\0\0\0\x80\x84\x2e\x41" /* 1e6 - 2 + 2 */
                "\0\0\0\0\0\0\x08\x40";    /* 3 */
    struct vor_cloud cloud;

    fresh(&cloud, 1);
    cloud.position_type = VOR_FLOAT64;
    cloud.origin[0] = 0.5;
    cloud.origin[1] = 1e6 - 2;
    assert_bytes(written(&cloud), want, sizeof want - 1);
    vor_cloud_free(&cloud);
}

VT_TEST(a_float_cloud_with_an_origin_is_written_in_absolute_coordinates)
{
    struct vor_cloud cloud, back;
    struct vor_limits limits = VOR_LIMITS_DEFAULT;
    struct vt_bytes bytes;

    fresh(&cloud, 1);
    cloud.origin[2] = 1000;
    bytes = written(&cloud);
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_ply_read(&back, bytes.data, bytes.size, &limits, &vt_err));
    ck_assert_float_eq(back.xyz[0], 1);
    ck_assert_float_eq(back.xyz[2], 1003);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    free(bytes.data);
}

/* Attributes, and their lines in the header. */
static const struct {
    struct {
        const char *name;
        enum vor_semantic semantic;
        enum vor_type type;
        unsigned components;
    } attributes[8];
    const char *lines;
} headers[] = {
    /* Components are numbered unless PLY names them. */
    {{{"uv", VOR_GENERIC, VOR_FLOAT32, 2},
      {"normal", VOR_NORMAL, VOR_INT8, 3},
      {"color", VOR_COLOR, VOR_UINT16, 4},
      {"normal", VOR_NORMAL, VOR_FLOAT32, 3}},
     "property float uv_0\nproperty float uv_1\n"
     "property char nx\nproperty char ny\nproperty char nz\n"
     "property ushort red\nproperty ushort green\nproperty ushort blue\nproperty ushort alpha\n"
     "property float normal_2_0\nproperty float normal_2_1\nproperty float normal_2_2\n"},
    {{{"color", VOR_COLOR, VOR_UINT8, 2}, {"normal", VOR_NORMAL, VOR_FLOAT32, 1}},
     "property uchar color_0\nproperty uchar color_1\nproperty float normal\n"},
    /* Names are made printable and unique. */
    {{{"x", VOR_GENERIC, VOR_UINT8, 1},
      {"a b\n", VOR_GENERIC, VOR_UINT8, 1},
      {"a_b_", VOR_GENERIC, VOR_UINT8, 1},
      {"", VOR_GENERIC, VOR_UINT8, 1},
      {"\xc3\xa9", VOR_GENERIC, VOR_UINT8, 1},
      {"p", VOR_GENERIC, VOR_UINT8, 2},
      {"p_1", VOR_GENERIC, VOR_UINT8, 1}},
     "property uchar x_2\nproperty uchar a_b_\nproperty uchar a_b__2\nproperty uchar _\n"
     "property uchar \xc3\xa9\nproperty uchar p_0\nproperty uchar p_1\nproperty uchar p_1_2\n"},
    /* Every type has its name in PLY. */
    {{{"a", VOR_GENERIC, VOR_INT8, 1},
      {"b", VOR_GENERIC, VOR_UINT8, 1},
      {"c", VOR_GENERIC, VOR_INT16, 1},
      {"d", VOR_GENERIC, VOR_UINT16, 1},
      {"e", VOR_GENERIC, VOR_INT32, 1},
      {"f", VOR_GENERIC, VOR_UINT32, 1},
      {"i", VOR_GENERIC, VOR_INT64, 1},
      {"j", VOR_GENERIC, VOR_UINT64, 1}},
     "property char a\nproperty uchar b\nproperty short c\nproperty ushort d\n"
     "property int e\nproperty uint f\nproperty double i\nproperty double j\n"},
    {{{"g", VOR_GENERIC, VOR_FLOAT32, 1}, {"h", VOR_GENERIC, VOR_FLOAT64, 1}},
     "property float g\nproperty double h\n"},
};

VT_TEST_LOOP(attributes_have_these_lines_in_the_header, (int)(sizeof headers / sizeof headers[0]))
{
    struct vor_cloud cloud;
    char *header;

    fresh(&cloud, 1);
    for (int i = 0; i < 8 && headers[_i].attributes[i].name != NULL; i++)
        attribute(&cloud, headers[_i].attributes[i].name, headers[_i].attributes[i].semantic,
                  headers[_i].attributes[i].type, headers[_i].attributes[i].components);
    header = header_of(&cloud);
    ck_assert_ptr_eq(strstr(header, HEAD(1) XYZ), header);
    ck_assert_str_eq(header + sizeof(HEAD(1) XYZ) - 1, headers[_i].lines);
    free(header);
    vor_cloud_free(&cloud);
}

VT_TEST(integers_of_64_bits_become_doubles)
{
    struct vor_cloud cloud;
    struct vt_bytes bytes;
    int64_t *s;
    uint64_t *u;
    double got[2];

    fresh(&cloud, 1);
    s = attribute(&cloud, "s", VOR_GENERIC, VOR_INT64, 1);
    u = attribute(&cloud, "u", VOR_GENERIC, VOR_UINT64, 1);
    s[0] = -9007199254740991;
    u[0] = UINT64_C(1) << 63;
    bytes = written(&cloud);
    memcpy(got, bytes.data + bytes.size - 16, sizeof got);
    ck_assert_double_eq(got[0], -9007199254740991.0);
    ck_assert_double_eq(got[1], 0x1p63);
    free(bytes.data);
    vor_cloud_free(&cloud);
}

/* 64 attributes of 16 components with long names: the longest row and header there can be. */
VT_TEST(the_widest_cloud_is_written_whole)
{
    struct vor_cloud cloud;
    struct vt_bytes bytes;
    char name[64];
    const uint8_t *rows;

    fresh(&cloud, 100);
    for (int i = 0; i < VOR_ATTRIBUTES_MAX; i++) {
        (void)snprintf(name, sizeof name, "%045d%d", 0, i);
        memset(attribute(&cloud, name, VOR_GENERIC, VOR_FLOAT64, 16), i, 100 * 16 * 8);
    }
    bytes = written(&cloud);
    rows = bytes.data + bytes.size - 100 * (12 + 64 * 128);
    for (size_t i = 0; i < 100; i++)
        for (size_t a = 0; a < 64; a++)
            for (size_t k = 0; k < 128; k += 127)
                ck_assert_uint_eq(rows[i * (12 + 64 * 128) + 12 + a * 128 + k], a);
    free(bytes.data);
    vor_cloud_free(&cloud);
}

struct narrow {
    size_t left, calls, largest;
};

static int narrow_write(void *ctx, const void *data, size_t size)
{
    struct narrow *narrow = ctx;

    (void)data;
    narrow->calls++;
    if (size > narrow->largest)
        narrow->largest = size;
    if (size > narrow->left)
        return -1;
    narrow->left -= size;
    return 0;
}

VT_TEST(a_sink_that_refuses_ends_the_writing)
{
    struct vor_cloud cloud;
    size_t used;

    vt_cloud_cube(&cloud, 1, 20000); /* 240,000 bytes: four chunks and the header */
    used = atomic_load(&vt_memory.used);
    for (size_t left = 0; left < 240000; left += 23456) {
        struct narrow narrow = {.left = left};
        struct vor_sink sink = {&narrow, narrow_write};

        vt_assert_fails(VOR_E_IO, vor_ply_write(&sink, &cloud, NULL, &vt_err));
        ck_assert_uint_le(narrow.calls, 6);
        ck_assert_uint_eq(atomic_load(&vt_memory.used), used);
    }
    vor_cloud_free(&cloud);
}

VT_TEST(the_file_is_never_held_as_a_whole)
{
    struct narrow narrow = {.left = SIZE_MAX};
    struct vor_sink sink = {&narrow, narrow_write};
    struct vor_memory memory;
    struct vor_cloud cloud;
    size_t used;

    vor_memory_init(&memory, SIZE_MAX);
    vor_cloud_init(&cloud, &memory);
    vt_assert_ok(vor_cloud_resize(&cloud, 300000, &vt_err));
    memset(cloud.xyz, 0, 300000 * 12);
    used = atomic_load(&memory.used);
    vt_assert_ok(vor_ply_write(&sink, &cloud, NULL, &vt_err));
    ck_assert_uint_le(narrow.largest, 65536);
    ck_assert_uint_le(atomic_load(&memory.peak) - used, 65536 + 4096);
    vor_cloud_free(&cloud);
}
