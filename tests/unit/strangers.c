/* Regression: files as other programs write them. Each is read, and what came of it is put into
 * words; written as PLY and as lossless Draco, it is read back as the same. */
#include "proto/codec.h"
#include "tests/support/vt.h"

#include <inttypes.h>
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
     "1 2 3; color uint8 0 20 30; l int32 -4"},
    {"integers with exponents",
     ASCII COLORED "property int l\n" END
                   "1 2 3 2.550000000000000000e+02 0.000000000000000000e+00 1.2e1 1e+06\n",
     "1 2 3; color uint8 255 0 12; l int32 1000000"},
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
     "1 2 3; color uint8 4 5 6"},
    {"colours by their letters",
     ASCII ONE RGB("r", "g", "b") "property uchar a\n" END "1 2 3 4 5 6 7\n",
     "1 2 3; color uint8 4 5 6 7"},
    {"one colour of two",
     ASCII ONE RGB("R", "G", "B") RGB("red", "green", "blue") END "1 2 3 4 5 6 7 8 9\n",
     "1 2 3; R uint8 4; G uint8 5; B uint8 6; color uint8 7 8 9"},
    {"normals by their field",
     ASCII ONE "property float normal_x\nproperty float normal_y\n"
               "property float Normal_Z\n" END "1 2 3 0 0 1\n",
     "1 2 3; normal float32 0 0 1"},
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

/* "x y z" of each point, then every attribute with its values, and what was dropped. */
static void say(char words[WORDS], const struct vor_cloud *cloud)
{
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

        (void)snprintf(text, sizeof text, "; %s %s", attribute->name,
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

START_TEST(files_of_strangers_are_read_and_come_back)
{
    const struct stranger *stranger = &strangers[_i];
    char want[WORDS] = "", got[WORDS];
    struct vor_cloud cloud, back;

    read_bytes(&cloud, stranger->file, strlen(stranger->file));
    say(got, &cloud);
    ck_assert_msg(strcmp(got, stranger->want) == 0, "%s: \"%s\", want \"%s\"", stranger->name, got,
                  stranger->want);
    strncat(want, got, strcspn(got, "\n"));
    if (strstr(want, "; dropped") != NULL)
        *strstr(want, "; dropped") = '\0';
    for (unsigned format = 0; vor_format(format) != NULL; format++) {
        through(&back, &cloud, format);
        say(got, &back);
        ck_assert_msg(strcmp(got, want) == 0, "%s: back from %s \"%s\", want \"%s\"",
                      stranger->name, vor_format(format)->name, got, want);
        vor_cloud_free(&back);
    }
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

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
    REFUSED(ASCII ONE END "1 -nan(ind) 3\n",
            "1 of 1 points are not finite, the first is point 0, whose y is nan; invalid=drop "
            "leaves them out"),
    REFUSED("plyx\nformat ascii 1.0\n",
            "the input begins with \"plyx\\x0aformat asci\", want \"ply\" and a line end, or "
            "\"DRACO\""),
    REFUSED("\xff\xfep\0l\0y\0\n\0",
            "the input begins with the byte order mark of UTF-16, want a PLY file in ASCII or "
            "UTF-8, or a Draco file"),
};

START_TEST(what_is_refused_is_named)
{
    static const struct vor_limits limits = VOR_LIMITS_DEFAULT;
    struct vor_cloud cloud;

    vor_cloud_init(&cloud, &vt_memory);
    ck_assert_int_ne(vor_codec_read(&cloud, NULL, (const uint8_t *)refused[_i].file,
                                    refused[_i].size, &limits, &vt_err),
                     VOR_OK);
    ck_assert_str_eq(vt_err.message, refused[_i].want);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("strangers");

    vt_add_loop(suite, files_of_strangers_are_read_and_come_back,
                sizeof strangers / sizeof *strangers);
    vt_add_loop(suite, what_is_refused_is_named, sizeof refused / sizeof *refused);
    return vt_run(suite);
}
