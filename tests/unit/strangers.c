/* Regression: files as other programs write them. Each is read, and what came of it is put into
 * words; written as PLY and as lossless Draco, it is read back as the same. */
#include "core/cloud/faces.h"
#include "proto/codec.h"
#include "proto/dump.h"
#include "tests/support/vt.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ASCII "ply\nformat ascii 1.0\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define ONE "element vertex 1\n" XYZ
#define END "end_header\n"
#define COLORED ONE "property uchar red\nproperty uchar green\nproperty uchar blue\n"
#define RGB(r, g, b) "property uchar " r "\nproperty uchar " g "\nproperty uchar " b "\n"
#define A20 "aaaaaaaaaaaaaaaaaaaa"

static const struct stranger {
    const char *name, *file, *want;
} strangers[] = {
    /* Whole numbers as floats are printed: "%f", "%g" of what is large, numpy.savetxt. */
    {"a point behind integers",
     ASCII COLORED "property int l\n" END "1 2 3 0.0 20. 30.000000 -4.0\n",
     "1 2 3; color! uint8 0 20 30; l int32 -4"},
    {"integers with exponents",
     ASCII COLORED "property int l\n" END
                   "1 2 3 2.550000000000000000e+02 0.000000000000000000e+00 1.2e1 1e+06\n",
     "1 2 3; color! uint8 255 0 12; l int32 1000000"},
    {"integers of many decimals",
     ASCII ONE "property ushort a\nproperty char b\n" END
               "1 2 3 65535.000000000000000000000000 -128.00000000000000000000\n",
     "1 2 3; a uint16 65535; b int8 -128"},
    {"integers of small exponents",
     ASCII ONE "property uchar a\nproperty int b\n" END "1 2 3 25500e-2 0e99999\n",
     "1 2 3; a uint8 255; b int32 0"},
    {"a point behind the count of a list",
     ASCII ONE "property list uchar int a\nproperty uint b\n" END "1 2 3 2.0 1.0 2.0 7.0\n",
     "1 2 3; b uint32 7; dropped vertex.a 1"},
    /* What C libraries print for no number. */
    {"nan of Microsoft",
     ASCII ONE "property float a\nproperty double b\nproperty float c\n" END
               "1 2 3 -nan(ind) 1.#QNAN -1.#IND\n",
     "1 2 3; a float32 nan; b float64 nan; c float32 nan"},
    {"nan of Microsoft, rounded or filled up",
     ASCII ONE "property float a\nproperty double b\nproperty float c\nproperty float d\n" END
               "1 2 3 1.#QNAN0 -1.#J 1.#QNAN0e+000 nan(snan)\n",
     "1 2 3; a float32 nan; b float64 nan; c float32 nan; d float32 nan"},
    {"inf of Microsoft",
     ASCII ONE "property float a\nproperty double b\nproperty float c\n" END
               "1 2 3 1.#INF -1.#INF00 Infinity\n",
     "1 2 3; a float32 inf; b float64 -inf; c float32 inf"},
    /* First lines and names. */
    {"a blank behind the magic", "ply \nformat ascii 1.0 \n" ONE END "1 2 3\n", "1 2 3"},
    {"a tab behind the magic",
     "ply\t\r\nformat ascii 1.0\r\nelement vertex 1\r\nproperty float x\r\n"
     "property float y\r\nproperty float z\r\nend_header\r\n1 2 3\r\n",
     "1 2 3"},
    {"blanks behind the magic of the old Macintosh",
     "ply  \rformat ascii 1.0\relement vertex 1\r"
     "property float x\rproperty float y\rproperty float z\rend_header\r1 2 3\r",
     "1 2 3"},
    {"a byte order mark", "\xef\xbb\xbf" ASCII "comment c\n" ONE END "1 2 3\n", "1 2 3"},
    {"coordinates in capitals",
     ASCII "element Vertex 1\nproperty float X\nproperty float Y\n"
           "property float Z\n" END "1 2 3\n",
     "1 2 3"},
    {"x before X", ASCII "element vertex 1\nproperty uchar X\n" XYZ END "9 1 2 3\n",
     "1 2 3; X uint8 9"},
    {"colours in capitals", ASCII ONE RGB("Red", "Green", "Blue") END "1 2 3 4 5 6\n",
     "1 2 3; color! uint8 4 5 6"},
    {"colours by their letters",
     ASCII ONE RGB("r", "g", "b") "property uchar a\n" END "1 2 3 4 5 6 7\n",
     "1 2 3; color! uint8 4 5 6 7"},
    {"one colour of two",
     ASCII ONE RGB("R", "G", "B") RGB("red", "green", "blue") END "1 2 3 4 5 6 7 8 9\n",
     "1 2 3; R uint8 4; G uint8 5; B uint8 6; color! uint8 7 8 9"},
    {"normals by their field",
     ASCII ONE "property float normal_x\nproperty float normal_y\n"
               "property float Normal_Z\n" END "1 2 3 0 0 1\n",
     "1 2 3; normal! float32 0 0 1"},
    {"a red that is no colour",
     ASCII ONE "property float red\n" RGB("r", "g", "b") END "1 2 3 .5 4 5 6\n",
     "1 2 3; red float32 0.5; r uint8 4; g uint8 5; b uint8 6"},
    {"letters beyond ASCII",
     ASCII ONE "property uchar Intensit\xc3\xa4t\nproperty float "
               "\xe5\xbc\xba\xe5\xba\xa6\n" END "1 2 3 4 .5\n",
     "1 2 3; Intensit\xc3\xa4t uint8 4; \xe5\xbc\xba\xe5\xba\xa6 float32 0.5"},
    {"letters of Latin-1", ASCII ONE "property uchar Intensit\xe4t\n" END "1 2 3 4\n",
     "1 2 3; Intensit\xe4t uint8 4"},
    {"long names",
     ASCII ONE "property uchar " A20 A20 A20 "aaa\nproperty char " A20 A20 A20 "\n" END
               "1 2 3 4 5\n",
     "1 2 3; " A20 A20 A20 "aaa uint8 4; " A20 A20 A20 " int8 5"},
    {"a longer name", ASCII ONE "property uchar " A20 A20 A20 "aa\xc3\xa4\n" END "1 2 3 4\n",
     "1 2 3; " A20 A20 A20 "aa uint8 4; dropped name of " A20 A20 "aaaaaaaaaaaaaaa 1"},
};

enum { WORDS = 1024 };

static void add(char words[WORDS], const char *text)
{
    ck_assert_uint_lt(strlen(words) + strlen(text), WORDS);
    strcat(words, text);
}

/* "x y z" of each point, then every attribute with its values, its name with a mark where it has a
 * meaning, and what was dropped. */
static void say(char words[WORDS], const struct vor_cloud *cloud)
{
    static const char *const implied[] = {"generic", "normal", "color", "tex_coord"};
    char text[128];

    words[0] = '\0';
    for (size_t i = 0; i < cloud->n; i++) {
        double at[3];

        vor_cloud_position(cloud, i, at);
        (void)snprintf(text, sizeof text, "%s%.17g %.17g %.17g", i > 0 ? ", " : "", at[0], at[1],
                       at[2]);
        add(words, text);
    }
    for (size_t a = 0; a < cloud->attribute_count; a++) {
        const struct vor_attribute *attribute = &cloud->attributes[a];

        ck_assert(attribute->semantic == VOR_GENERIC ||
                  strcmp(attribute->name, implied[attribute->semantic]) == 0);
        (void)snprintf(text, sizeof text, "; %s%s %s", attribute->name,
                       attribute->semantic != VOR_GENERIC ? "!" : "",
                       vor_type_name_sized(attribute->type));
        add(words, text);
        for (size_t k = 0; k < cloud->n * attribute->components; k++) {
            double value = vor_attribute_scalar(attribute, k);

            if (value != value) /* its sign is the machine's */
                (void)snprintf(text, sizeof text, " nan");
            else
                (void)snprintf(text, sizeof text, " %.9g", value);
            add(words, text);
        }
    }
    for (unsigned i = 0; i < cloud->notes.dropped_count; i++) {
        (void)snprintf(text, sizeof text, "; dropped %s %" PRIu64, cloud->notes.dropped[i].what,
                       cloud->notes.dropped[i].count);
        add(words, text);
    }
}

static void read_bytes(struct vor_cloud *out, const void *bytes, size_t size)
{
    static const struct vor_limits limits = VOR_LIMITS_DEFAULT;

    vor_cloud_init(out, &vt_memory);
    vt_assert_ok(vor_codec_read(out, NULL, bytes, size, &limits, &vt_err));
}

/* Writes a cloud without loss and reads it again. */
static void through(struct vor_cloud *out, const struct vor_cloud *cloud, unsigned format)
{
    const struct vor_write_options options = {.compression = 7, .keep_order = 1};
    struct vt_bytes bytes = {0};
    const struct vor_sink sink = {&bytes, vt_bytes_write};

    vt_assert_ok(vor_format(format)->write(&sink, cloud, &options, &vt_err));
    read_bytes(out, bytes.data, bytes.size);
    free(bytes.data);
}

/* Asserts what a cloud holds, and what it holds back from each format. */
static void check_words(const char *name, const struct vor_cloud *cloud, const char *want,
                        const char *const back[2])
{
    struct vor_cloud again;
    char got[WORDS];

    say(got, cloud);
    ck_assert_msg(strcmp(got, want) == 0, "%s: \"%s\", want \"%s\"", name, got, want);
    for (unsigned format = 0; vor_format(format) != NULL; format++) {
        size_t size = strlen(back[format]);

        through(&again, cloud, format);
        say(got, &again);
        ck_assert_msg(strncmp(got, back[format], size) == 0 &&
                          (got[size] == '\0' || strncmp(got + size, "; dropped", 9) == 0),
                      "%s: back from %s \"%s\", want \"%s\"", name, vor_format(format)->name, got,
                      back[format]);
        vor_cloud_free(&again);
    }
}

VT_TEST_LOOP(files_of_strangers_are_read_and_come_back, sizeof strangers / sizeof *strangers)
{
    const struct stranger *stranger = &strangers[_i];
    const char *dropped = strstr(stranger->want, "; dropped");
    char back[WORDS];
    const char *const both[] = {back, back};
    struct vor_cloud cloud;

    (void)snprintf(back, sizeof back, "%.*s",
                   dropped != NULL ? (int)(dropped - stranger->want) : WORDS, stranger->want);
    read_bytes(&cloud, stranger->file, strlen(stranger->file));
    check_words(stranger->name, &cloud, stranger->want, both);
    vor_cloud_free(&cloud);
}

static void read_path(struct vor_cloud *out, const char *path)
{
    size_t size;
    uint8_t *bytes = vt_slurp(path, &size);

    ck_assert_ptr_nonnull(bytes);
    read_bytes(out, bytes, size);
    free(bytes);
}

/* Vector, written by Draco's own encoder: metadata of a file, of a part of it and of an attribute,
 * a colour of two numbers, places in a texture of three, a name with a blank. */
VT_TEST(what_draco_has_beside_points_is_kept_or_named)
{
#define POINTS "1 2 3, 4 5 6; "
#define PLACES "tex_coord! float32 0.5 0.25 0.75 1 0 0.5; "
#define HEIGHT "H\xc3\xb6he uint8 13 14"
    static const char *const back[] = {
        POINTS "color_0 uint8 7 9; color_1 uint8 8 10; " PLACES "GPS_time uint16 11 12; " HEIGHT,
        POINTS "color uint8 7 8 9 10; " PLACES "GPS time uint16 11 12; " HEIGHT};
    struct vor_report report = {.points_in = 0};
    struct vor_cloud cloud;

    read_path(&cloud, "tests/data/metadata.drc");
    check_words("metadata.drc", &cloud,
                POINTS "color uint8 7 8 9 10; " PLACES "GPS time uint16 11 12; " HEIGHT
                       "; dropped meaning of color 1; dropped metadata 4",
                back);
    vor_codec_report_dropped(&report, &cloud, NULL, vor_format(VOR_FORMAT_DRC));
    ck_assert_uint_eq(report.dropped_count, 0);
    vor_codec_report_dropped(&report, &cloud, NULL, vor_format(VOR_FORMAT_PLY));
    ck_assert_uint_eq(report.dropped_count, 1);
    ck_assert_str_eq(report.dropped[0].what, "name of GPS time");
    vor_cloud_free(&cloud);
}

/* Vector, written by Draco's own encoder: 200 points with places in a texture. */
VT_TEST(places_in_a_texture_stay_what_they_are)
{
    struct vor_cloud cloud, back;

    read_path(&cloud, "tests/data/texcoord-cloud.drc");
    for (unsigned format = 0; vor_format(format) != NULL; format++) {
        const struct vor_attribute *is = vor_cloud_find(&cloud, VOR_TEX_COORD), *again;

        through(&back, &cloud, format);
        again = vor_cloud_find(&back, VOR_TEX_COORD);
        ck_assert(is != NULL && again != NULL);
        ck_assert(again->type == VOR_FLOAT32 && again->components == 2);
        ck_assert_mem_eq(again->data, is->data, 200 * 2 * sizeof(float));
        vor_cloud_free(&back);
    }
    vor_cloud_free(&cloud);
}

/* Vector, written by Draco's own encoder, edgebreaker: a cube from 0 to 1, whose corners are three
 * points each, one for every side, with the normal and the place in the texture of that side. */
VT_TEST(each_side_of_a_corner_is_a_point)
{
    struct vor_cloud cloud;
    const float *normal, *place;
    unsigned seen[6] = {0};

    read_path(&cloud, "tests/data/cube-24-corners.drc");
    ck_assert_uint_eq(cloud.n, 24);
    ck_assert(vor_cloud_find(&cloud, VOR_NORMAL) && vor_cloud_find(&cloud, VOR_TEX_COORD));
    normal = vor_cloud_find(&cloud, VOR_NORMAL)->data;
    place = vor_cloud_find(&cloud, VOR_TEX_COORD)->data;
    for (size_t i = 0; i < 24; i++) {
        unsigned axis = 0, corner;

        while (axis < 2 && fabsf(normal[3 * i + axis]) < 0.5F)
            axis++;
        ck_assert_float_eq_tol(fabsf(normal[3 * i + axis]), 1, 1e-3F);
        ck_assert_float_eq_tol(cloud.xyz[3 * i + axis], normal[3 * i + axis] > 0, 1e-3F);
        corner = (place[2 * i] > 0.5F) + 2U * (place[2 * i + 1] > 0.5F);
        seen[2 * axis + (normal[3 * i + axis] > 0)] |= 1U << corner;
    }
    for (unsigned side = 0; side < 6; side++)
        ck_assert_uint_eq(seen[side], 15);
    vor_cloud_free(&cloud);
}

/* Colours as the Point Cloud Library packs them into a float, without alpha and with, which makes
 * some of them no numbers; and labels whose bits were taken for floats. */
static void add_bits(struct vor_cloud *cloud, const char *name, unsigned components, uint32_t step,
                     uint32_t base)
{
    struct vor_attribute *attribute;
    uint32_t bits;

    vt_assert_ok(vor_cloud_add_attribute(cloud, name, VOR_GENERIC, VOR_FLOAT32, components,
                                         &attribute, &vt_err));
    for (size_t k = 0; k < cloud->n * components; k++) {
        bits = base | (uint32_t)k * step % 0xffffffU;
        memcpy((float *)attribute->data + k, &bits, sizeof bits);
    }
}

/* Property: the quantised encodings, with the order of points and without. */
VT_TEST_LOOP(bits_in_floats_survive_quantization, 4)
{
    const struct vor_write_options options = {
        .quantization_bits = 11, .compression = 7, .keep_order = _i & 1};
    struct vt_bytes bytes = {0};
    const struct vor_sink sink = {&bytes, vt_bytes_write};
    struct vor_cloud cloud, back;
    struct vor_attribute *id;
    const uint32_t *at;

    vt_cloud_cube(&cloud, 1, 300);
    vt_assert_ok(vor_cloud_add_attribute(&cloud, "id", VOR_GENERIC, VOR_UINT32, 1, &id, &vt_err));
    for (uint32_t i = 0; i < 300; i++)
        ((uint32_t *)id->data)[i] = i;
    add_bits(&cloud, "rgb", 1, 55831, _i < 2 ? 0 : 0xff000000U);
    add_bits(&cloud, "RGBA", 1, 55831, 0x7f000000U);
    add_bits(&cloud, "label", 2, 1, 0);
    vt_assert_ok(vor_format(VOR_FORMAT_DRC)->write(&sink, &cloud, &options, &vt_err));
    read_bytes(&back, bytes.data, bytes.size);
    ck_assert_uint_eq(back.n, 300);
    at = vor_cloud_find_name(&back, "id")->data;
    for (size_t a = 1; a < 4; a++) {
        const struct vor_attribute *is = &back.attributes[a], *was = &cloud.attributes[a];
        size_t size = was->components * sizeof(float);

        ck_assert_str_eq(is->name, was->name);
        ck_assert(is->type == VOR_FLOAT32 && is->components == was->components);
        for (size_t i = 0; i < 300; i++)
            ck_assert_mem_eq((const char *)is->data + i * size,
                             (const char *)was->data + at[i] * size, size);
    }
    free(bytes.data);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
}

/* Property: a point drawn from a face gets the packed colour of a corner, not the mean of three. */
VT_TEST(packed_colours_are_not_averaged)
{
    static const uint32_t packed[3] = {0x00ff0000U, 0x0000ff00U, 0x000000ffU};
    struct vor_cloud cloud, drawn;
    unsigned seen = 0;
    uint32_t got;

    vor_cloud_init(&cloud, &vt_memory);
    read_bytes(&cloud,
               ASCII "element vertex 3\n" XYZ "property float rgb\n" END
                     "0 0 0 0\n1 0 0 0\n0 1 0 0\n",
               strlen(ASCII "element vertex 3\n" XYZ "property float rgb\n" END
                            "0 0 0 0\n1 0 0 0\n0 1 0 0\n"));
    memcpy(cloud.attributes[0].data, packed, sizeof packed);
    cloud.triangles = vor_calloc(&vt_memory, 3, sizeof *cloud.triangles);
    ck_assert_ptr_nonnull(cloud.triangles);
    cloud.triangles[1] = 1;
    cloud.triangles[2] = 2;
    cloud.triangle_count = 1;
    vor_cloud_init(&drawn, &vt_memory);
    vt_assert_ok(vor_faces_sample(&drawn, &cloud, 64, 1, &vt_err));
    for (size_t i = 0; i < 64; i++) {
        memcpy(&got, (float *)drawn.attributes[0].data + i, sizeof got);
        for (unsigned k = 0; k < 3; k++)
            seen |= (got == packed[k]) << k;
        ck_assert(got == packed[0] || got == packed[1] || got == packed[2]);
    }
    ck_assert_uint_eq(seen, 7);
    vor_cloud_free(&drawn);
    vor_cloud_free(&cloud);
}

/* Doubles that no origin and float32 hold: -0, and 17 digits of metres far from zero. */
static const double doubles[6] = {500000.1, 4649776.2, -0.0,
                                  500100.3, 4649876.4, 12.345678901234567};

#define DOUBLES(format)                                                                            \
    "ply\nformat " format " 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"         \
    "property double z\nend_header\n"

/* The doubles as a file of each kind. */
static void put_doubles(struct vt_bytes *bytes, int kind)
{
    static const char *const heads[] = {DOUBLES("ascii"), DOUBLES("binary_little_endian"),
                                        DOUBLES("binary_big_endian")};
    char text[32];

    ck_assert_int_eq(vt_bytes_write(bytes, heads[kind], strlen(heads[kind])), 0);
    for (int i = 0; i < 6; i++) {
        uint64_t bits;
        uint8_t big[8];

        memcpy(&bits, &doubles[i], sizeof bits);
        for (int k = 0; k < 8; k++)
            big[k] = (uint8_t)(bits >> (kind == 1 ? 8 * k : 56 - 8 * k));
        (void)snprintf(text, sizeof text, "%.17g%c", doubles[i], i % 3 == 2 ? '\n' : ' ');
        ck_assert_int_eq(vt_bytes_write(bytes, kind == 0 ? text : (const char *)big,
                                        kind == 0 ? strlen(text) : sizeof big),
                         0);
    }
}

/* Reads a file with its doubles or without. */
static void read_keeping(struct vor_cloud *out, const struct vt_bytes *bytes, int keep_doubles)
{
    struct vor_limits limits = VOR_LIMITS_DEFAULT;

    limits.keep_doubles = keep_doubles;
    vor_cloud_init(out, &vt_memory);
    vt_assert_ok(vor_codec_read(out, NULL, bytes->data, bytes->size, &limits, &vt_err));
}

static void check_doubles(const struct vor_cloud *cloud)
{
    struct vt_bytes bytes = {0};
    const struct vor_sink sink = {&bytes, vt_bytes_write};

    vt_assert_ok(vor_format(VOR_FORMAT_PLY)->write(&sink, cloud, NULL, &vt_err));
    ck_assert_uint_gt(bytes.size, sizeof doubles);
    ck_assert_mem_eq(bytes.data + bytes.size - sizeof doubles, doubles, sizeof doubles);
    free(bytes.data);
}

/* Property: double in, double out, bit for bit, from every kind of file, also by way of a dump and
 * in another order; where nobody asks for it, no memory is taken. */
VT_TEST_LOOP(doubles_come_back_bit_for_bit_where_they_are_kept, 4)
{
    static const uint32_t swap[2] = {1, 0};
    struct vt_bytes bytes = {0}, dump = {0};
    const struct vor_sink sink = {&dump, vt_bytes_write};
    struct vor_report report = {.points_in = 0};
    struct vor_cloud cloud, back;

    if (_i < 3)
        put_doubles(&bytes, _i);
    else
        bytes.data = vt_slurp("tests/data/double-positions.drc", &bytes.size);
    read_keeping(&cloud, &bytes, 0);
    ck_assert_ptr_null(cloud.exact);
    vor_cloud_free(&cloud);
    read_keeping(&cloud, &bytes, 1);
    check_doubles(&cloud);
    vt_assert_ok(vor_dump_write(&sink, &cloud, &vt_err));
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_dump_read(&back, dump.data, dump.size, &vt_err));
    check_doubles(&back);
    vor_cloud_free(&back);
    vt_assert_fails(VOR_E_FORMAT, vor_dump_read(&back, dump.data, dump.size - 8, &vt_err));
    vt_assert_ok(vor_cloud_copy(&back, &cloud, &vt_err));
    vt_assert_ok(vor_cloud_reorder(&back, swap, &vt_err));
    vt_assert_ok(vor_cloud_reorder(&back, swap, &vt_err));
    check_doubles(&back);
    report.parameters.value[VOR_PARAM_QUANTIZATION] = 0;
    vor_codec_report_dropped(&report, &cloud, NULL, vor_format(VOR_FORMAT_DRC));
    ck_assert_uint_eq(report.dropped_count, 1);
    ck_assert_str_eq(report.dropped[0].what, "digits of positions");
    ck_assert_uint_eq(report.dropped[0].count, 2);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    free(dump.data);
    free(bytes.data);
}

/* Doubles that the positions hold need no second copy. */
VT_TEST(doubles_that_positions_hold_are_not_kept_twice)
{
    static const char file[] = DOUBLES("ascii") "500000.25 0 0\n500001 1 2.5\n";
    struct vor_cloud cloud;
    struct vor_limits limits = VOR_LIMITS_DEFAULT;

    limits.keep_doubles = 1;
    vor_cloud_init(&cloud, &vt_memory);
    vt_assert_ok(
        vor_codec_read(&cloud, NULL, (const uint8_t *)file, sizeof file - 1, &limits, &vt_err));
    ck_assert_int_eq(cloud.position_type, VOR_FLOAT64);
    ck_assert_ptr_null(cloud.exact);
    vor_cloud_free(&cloud);
}

/* What cannot be read is named. */
static const struct {
    const char *file;
    size_t size;
    const char *want;
} refused[] = {
#define REFUSED(file, want)                                                                        \
    {                                                                                              \
        file, sizeof(file) - 1, want                                                               \
    }
    REFUSED(ASCII COLORED END "1 2 3 0.5 0 0\n",
            "red of row 0 is \"0.5\", want a number of type uchar"),
    REFUSED(ASCII COLORED END "1 2 3 256.0 0 0\n",
            "red of row 0 is 256.0, outside the range of uchar"),
    REFUSED(ASCII COLORED END "1 2 3 1.#IND 0 0\n",
            "red of row 0 is \"1.#IND\", want a number of type uchar"),
    REFUSED(ASCII ONE END "1 -nan(ind) 3\n", "1 of 1 points have a coordinate that is not finite. "
                                             "The first is point 0: its y is nan. invalid=drop "
                                             "leaves such points out"),
};

VT_TEST_LOOP(what_is_refused_is_named, sizeof refused / sizeof *refused)
{
    static const struct vor_limits limits = VOR_LIMITS_DEFAULT;
    struct vor_cloud cloud;

    vor_cloud_init(&cloud, &vt_memory);
    ck_assert_int_ne(vor_codec_read(&cloud, NULL, (const uint8_t *)refused[_i].file,
                                    refused[_i].size, &limits, &vt_err),
                     VOR_OK);
    ck_assert_str_eq(vt_err.message, refused[_i].want);
}
