/* The table of formats: how a format is recognised, and what becomes of bytes that are none. */
#include "core/base/quote.h"
#include "proto/codec.h"
#include "tests/support/vt.h"

#include <string.h>

#define ASCII_POINT                                                                                \
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"                \
    "property float z\nend_header\n"

static const struct vor_limits limits = VOR_LIMITS_DEFAULT;

VT_TEST(formats_have_the_index_and_the_word_of_the_parameter)
{
    const char *word;

    for (unsigned i = 0; i < 2; i++) {
        const struct vor_format *format = vor_format(i);
        size_t length = vor_parameter_choice(vor_parameter_info(VOR_PARAM_FORMAT), i, &word);

        ck_assert_uint_eq(strlen(format->name), length);
        ck_assert_mem_eq(format->name, word, length);
        ck_assert(format->read != NULL && format->write != NULL);
        ck_assert_ptr_eq(vor_format_by_media_type(format->media_type), format);
        ck_assert_ptr_eq(vor_format_by_suffix(format->suffix), format);
    }
    ck_assert_str_eq(vor_format(VOR_FORMAT_PLY)->name, "ply");
    ck_assert_str_eq(vor_format(VOR_FORMAT_PLY)->label, "PLY");
    ck_assert_str_eq(vor_format(VOR_FORMAT_PLY)->media_type, "application/ply");
    ck_assert_str_eq(vor_format(VOR_FORMAT_DRC)->name, "drc");
    ck_assert_str_eq(vor_format(VOR_FORMAT_DRC)->label, "Draco");
    ck_assert_str_eq(vor_format(VOR_FORMAT_DRC)->media_type, "application/draco");
    ck_assert_ptr_null(vor_format(2));
    ck_assert_ptr_null(vor_format(UINT32_MAX));
    ck_assert_uint_eq(vor_parameter_choice(vor_parameter_info(VOR_PARAM_FORMAT), 2, &word), 0);
}

enum { NONE = 2 };

static const struct {
    const char *bytes;
    size_t size;
    unsigned format;
} beginnings[] = {
    {"ply\n", 4, VOR_FORMAT_PLY},
    {"ply\r\n", 5, VOR_FORMAT_PLY},
    {"ply\r", 4, VOR_FORMAT_PLY},
    {"ply\nx", 5, VOR_FORMAT_PLY},
    {"ply", 3, NONE},
    {"plyx\n", 5, NONE},
    {"ply \n", 5, VOR_FORMAT_PLY},
    {"ply \t\r", 6, VOR_FORMAT_PLY},
    {"ply ", 4, NONE},
    {"\xef\xbb\xbfply\n", 7, VOR_FORMAT_PLY},
    {"\xef\xbb\xbfpl", 5, NONE},
    {"PLY\n", 4, NONE},
    {" ply\n", 5, NONE},
    {"pl", 2, NONE},
    {"", 0, NONE},
    {"DRACO", 5, VOR_FORMAT_DRC},
    {"DRACO\2\3", 7, VOR_FORMAT_DRC},
    {"DRAC", 4, NONE},
    {"draco", 5, NONE},
    {"OFF\n", 4, NONE},
    {"\x1f\x8b\x08", 3, NONE},
};

VT_TEST(a_file_is_recognised_by_its_first_bytes)
{
    for (size_t i = 0; i < sizeof beginnings / sizeof beginnings[0]; i++)
        ck_assert_ptr_eq(vor_format_sniff((const uint8_t *)beginnings[i].bytes, beginnings[i].size),
                         vor_format(beginnings[i].format));
    ck_assert_ptr_null(vor_format_sniff(NULL, 0));
}

static const struct {
    const char *text;
    unsigned format;
} suffixes[] = {{"a.ply", VOR_FORMAT_PLY},
                {"/x.drc/a.PLY", VOR_FORMAT_PLY},
                {".ply", VOR_FORMAT_PLY},
                {"a.drc", VOR_FORMAT_DRC},
                {"a.ply.Drc", VOR_FORMAT_DRC},
                {"ply", NONE},
                {"aply", NONE},
                {"a.ply.gz", NONE},
                {"a.ply/", NONE},
                {"-", NONE},
                {"", NONE}},
  media_types[] = {{"application/ply", VOR_FORMAT_PLY},
                   {"Application/PLY", VOR_FORMAT_PLY},
                   {"application/ply; charset=binary", VOR_FORMAT_PLY},
                   {"application/ply;q=0.5", VOR_FORMAT_PLY},
                   {" application/ply ", VOR_FORMAT_PLY},
                   {"model/ply", VOR_FORMAT_PLY},
                   {"application/x-ply", VOR_FORMAT_PLY},
                   {"application/draco", VOR_FORMAT_DRC},
                   {"model/draco", VOR_FORMAT_DRC},
                   {"application/vnd.draco", VOR_FORMAT_DRC},
                   {"model/vnd.draco;v=2", VOR_FORMAT_DRC},
                   {"text/plain", NONE},
                   {"application/plyx", NONE},
                   {"application/pl", NONE},
                   {"ply", NONE},
                   {"*/*", NONE},
                   {"application/octet-stream", NONE},
                   {";", NONE},
                   {"", NONE}};

VT_TEST(a_file_name_is_recognised_by_its_suffix_in_any_case)
{
    for (size_t i = 0; i < sizeof suffixes / sizeof suffixes[0]; i++)
        ck_assert_ptr_eq(vor_format_by_suffix(suffixes[i].text), vor_format(suffixes[i].format));
}

VT_TEST(a_media_type_is_recognised_without_its_parameters)
{
    for (size_t i = 0; i < sizeof media_types / sizeof media_types[0]; i++)
        ck_assert_msg(vor_format_by_media_type(media_types[i].text) ==
                          vor_format(media_types[i].format),
                      "\"%s\"", media_types[i].text);
}

#define WANT ", want \"ply\" and a line end, or \"DRACO\""
#define Z10 "\0\0\0\0\0\0\0\0\0\0"
#define Z20 Z10 Z10
#define Z26 Z20 "\0\0\0\0\0\0"
#define Z46 Z20 Z26
#define Z100 Z46 Z46 "\0\0\0\0\0\0\0\0"

#define REFUSED(file, want)                                                                        \
    {                                                                                              \
        file, sizeof(file) - 1, want                                                               \
    }

/* What is no format of ours is named, with what makes PLY of it. */
static const struct {
    const char *file;
    size_t size;
    const char *want;
} foreign[] = {
    REFUSED("plyx\nformat ascii 1.0\n", "the input begins with \"plyx\\x0aformat asci\"" WANT),
    REFUSED("", "the input is empty, want a PLY or a Draco file"),
#define FOREIGN(file, name, hint) REFUSED(file, "the input is " name ", want PLY or Draco: " hint)
#define MESH(suffix) "convert it with assimp export in." suffix " out.ply -jiv"
#define PDAL(suffix) "convert it with pdal translate in." suffix " out.ply"
#define HELP "convert it as \"voronoid help formats\" says"
#define ERROR "it is probably an error page instead of the file: download it again"
    FOREIGN("LASF" Z100, "LAS", PDAL("las")),
    FOREIGN("LASF" Z100 "\x83 ", "LAZ", PDAL("laz")),
    FOREIGN("ASTM-E57\1", "E57", PDAL("e57")),
    FOREIGN("12\n34\n0 0 0\n1 0 0\n", "PTX", PDAL("ptx")),
    FOREIGN("2\r\n1 2 3 -4 5 6 7\r\n", "PTS", PDAL("pts")),
    FOREIGN("# .PCD v.7\nVERSION .7\nFIELDS x y z\n", "PCD",
            "convert it with pcl_pcd2ply in.pcd out.ply"),
    FOREIGN("# vtk DataFile Version 3.0\n", "VTK", "convert it with pcl_vtk2ply in.vtk out.ply"),
    FOREIGN("# Blender\n\nmtllib a.mtl\n", "OBJ", MESH("obj")),
    FOREIGN("v 1 2 3\nv 4 5 6\n", "OBJ", MESH("obj")),
    FOREIGN("solid a\n facet normal 0 0 1\n", "STL", MESH("stl")),
    FOREIGN("solid  " Z46 Z26 "\0"
            "\1\0\0\0\0\0\x80\x3f" Z46,
            "STL", MESH("stl")),
    FOREIGN("COFF\n8 6 0\n", "OFF", MESH("off")),
    FOREIGN("glTF\2", "glTF (GLB)", MESH("glb")),
    FOREIGN("{\n \"asset\": {\"version\": \"2.0\"}}", "glTF", MESH("gltf")),
    FOREIGN("{\"error\": \"not found\"}", "JSON",
            "it is probably an error message, or parameters instead of a cloud"),
    FOREIGN("\n<!DOCTYPE html>\n", "HTML", ERROR),
    FOREIGN("\xef\xbb\xbf<html>", "HTML", ERROR),
    FOREIGN("1.0 -2e3 3\n", "numbers in text (XYZ, CSV)", HELP),
    FOREIGN("X,Y,Z\r\n1,2,3\r\n", "numbers in text (XYZ, CSV)", HELP),
    FOREIGN("//X Y Z R\n1; 2; 3; 4", "numbers in text (XYZ, CSV)", HELP),
    FOREIGN("\x93NUMPY\1", "NPY", HELP),
    FOREIGN("PK\3\4" Z26 "points.npy\1\2\3", "NPZ", HELP),
    FOREIGN("PK\3\4" Z26 "points.ply\1\2\3", "ZIP", "unpack it with unzip"),
    FOREIGN("\x1f\x8b\x08", "gzip",
            "unpack it with gunzip, or send it over HTTP with Content-Encoding: gzip"),
    FOREIGN("\3757zXZ", "xz", "unpack it with unxz"),
    FOREIGN(Z100 Z100 Z46 Z10 "\0"
                              "ustar",
            "tar", "unpack it with tar xf"),
    FOREIGN("version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS",
            "fetch the file: git lfs pull"),
    FOREIGN("\x89PNG\r\n\x1a\n", "PNG", "it is not a point cloud"),
    FOREIGN("\xff\xfep\0l\0y\0\n\0", "UTF-16", "a PLY file has to be ASCII or UTF-8"),
    /* Nothing is taken for what it only resembles. */
    REFUSED("1 2\n3 4\n", "the input begins with \"1 2\\x0a3 4\\x0a\"" WANT),
    REFUSED("offer\n", "the input begins with \"offer\\x0a\"" WANT),
    REFUSED("\x89PNH\r\n\"\\\x1a and much more",
            "the input begins with \"\\x89PNH\\x0d\\x0a\\x22\\x5c\\x1a and mu\"" WANT),
    REFUSED("v1\n", "the input begins with \"v1\\x0a\"" WANT),
    REFUSED("solid ground", "the input begins with \"solid ground\"" WANT),
    REFUSED("{see below}", "the input begins with \"{see below}\"" WANT),
};

static vor_status read_text(struct vor_cloud *cloud, const struct vor_format **format,
                            const char *text, size_t size)
{
    vor_cloud_init(cloud, &vt_memory);
    return vor_codec_read(cloud, format, (const uint8_t *)text, size, &limits, &vt_err);
}

VT_TEST(a_ply_file_is_read)
{
    const struct vor_format *format = NULL;
    struct vor_cloud cloud;

    vt_assert_ok(read_text(&cloud, &format, ASCII_POINT "1 2 3", sizeof ASCII_POINT + 4));
    ck_assert_ptr_eq(format, vor_format(VOR_FORMAT_PLY));
    ck_assert_float_eq(cloud.xyz[2], 3);
    vor_cloud_free(&cloud);
    vt_assert_ok(read_text(&cloud, NULL, ASCII_POINT "1 2 3", sizeof ASCII_POINT + 4));
    vor_cloud_free(&cloud);
}

VT_TEST(the_format_is_known_even_where_the_file_is_refused)
{
    const struct vor_format *format = NULL;
    struct vor_cloud cloud;

    vt_assert_fails(VOR_E_FORMAT, read_text(&cloud, &format, "ply\nx\n", 6));
    ck_assert_ptr_eq(format, vor_format(VOR_FORMAT_PLY));
    format = NULL;
    vt_assert_fails(VOR_E_FORMAT, read_text(&cloud, &format, "DRACO", 5));
    ck_assert_ptr_eq(format, vor_format(VOR_FORMAT_DRC));
    ck_assert_ptr_null(cloud.xyz);
}

VT_TEST_LOOP(what_is_no_format_of_ours_is_named, sizeof foreign / sizeof *foreign)
{
    struct vor_cloud cloud;

    vt_assert_fails(VOR_E_UNSUPPORTED, read_text(&cloud, NULL, foreign[_i].file, foreign[_i].size));
    ck_assert_str_eq(vt_err.message, foreign[_i].want);
    ck_assert_int_eq(vt_err.byte_offset, 0);
    ck_assert_int_eq(VOR_E_UNSUPPORTED,
                     vor_codec_read(&cloud, NULL, (const uint8_t *)"x", 1, &limits, NULL));
}

VT_TEST(options_come_from_the_request)
{
    const struct vor_format *drc = vor_format(VOR_FORMAT_DRC);
    struct vor_result_facts facts = {.input = {.n = 10, .high = {1, 1, 1}, .area = 1},
                                     .spacing = 0.25};
    struct vor_write_options options;
    struct vor_spec spec;

    vor_spec_init(&spec);
    vt_assert_ok(vor_write_options_from(&options, drc, &spec, &facts, &vt_err));
    ck_assert_int_eq(options.quantization_bits, -1);
    ck_assert_int_eq(options.compression, 7);
    ck_assert_int_eq(options.keep_order, 0);
    ck_assert_double_eq(options.spacing, 0.25);
    vt_assert_ok(vor_spec_set(&spec, "order", "progressive", &vt_err));
    vt_assert_ok(vor_write_options_from(&options, drc, &spec, &facts, &vt_err));
    ck_assert_int_eq(options.keep_order, 1);
    vt_assert_ok(vor_spec_set(&spec, "quantization", "0", &vt_err));
    vt_assert_ok(vor_spec_set(&spec, "compression", "10", &vt_err));
    vt_assert_ok(vor_write_options_from(&options, drc, &spec, &facts, &vt_err));
    ck_assert_int_eq(options.quantization_bits, 0);
    ck_assert_int_eq(options.compression, 10);
    vt_assert_ok(vor_spec_set(&spec, "quantization", "30", &vt_err));
    vt_assert_ok(vor_write_options_from(&options, drc, &spec, &facts, &vt_err));
    ck_assert_int_eq(options.quantization_bits, 30);
    vt_assert_ok(vor_spec_set(&spec, "quantization", "auto", &vt_err));
    vt_assert_ok(vor_write_options_from(&options, drc, &spec, &facts, &vt_err));
    ck_assert_int_eq(options.quantization_bits, -1);
}

VT_TEST(quoted_bytes_are_printable_and_end_in_time)
{
    uint8_t bytes[64];
    char out[64];

    for (int i = 0; i < 64; i++)
        bytes[i] = (uint8_t)(i * 37 + 11);
    for (size_t size = 8; size <= sizeof out; size++)
        for (size_t length = 0; length <= sizeof bytes; length++) {
            memset(out, 1, sizeof out);
            ck_assert_ptr_eq(vor_quote(out, size, bytes, length), out);
            ck_assert_uint_lt(strlen(out), size);
            for (const char *c = out; *c != '\0'; c++)
                ck_assert(*c >= 0x20 && *c < 0x7f && *c != '"');
        }
    ck_assert_str_eq(vor_quote(out, 8, "1234567", 7), "1234567");
    ck_assert_str_eq(vor_quote(out, 8, "12345678", 8), "1234...");
    ck_assert_str_eq(vor_quote(out, 8, "123\n", 4), "123\\x0a");
    ck_assert_str_eq(vor_quote(out, 8, "1234\n", 5), "1234...");
    ck_assert_str_eq(vor_quote(out, 8, "", 0), "");
}
