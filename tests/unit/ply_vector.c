/* Vectors: small PLY files written by hand, and what they mean. */
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

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

/* The cloud of every encoding and line end below: (1 2 3), (3 2 1), float32, no attribute. */
static void assert_pair(struct vor_cloud *cloud)
{
    ck_assert_uint_eq(cloud->n, 2);
    ck_assert_uint_eq(cloud->attribute_count, 0);
    ck_assert_int_eq(cloud->position_type, VOR_FLOAT32);
    for (int c = 0; c < 3; c++)
        ck_assert_double_eq(cloud->origin[c], 0);
    assert_xyz(cloud, 0, 1, 2, 3);
    assert_xyz(cloud, 1, 3, 2, 1);
    vor_cloud_free(cloud);
    vt_assert_no_leak();
}

#define CRLF(format)                                                                               \
    "ply\r\nformat " format " 1.0\r\ncomment c\r\nelement vertex 2\r\nproperty float x\r\n"        \
    "property float y\r\nproperty float z\r\nend_header\r\n"
#define CR(format)                                                                                 \
    "ply\rformat " format " 1.0\rcomment c\relement vertex 2\rproperty float x\r"                  \
    "property float y\rproperty float z\rend_header\r"
#define PAIR_LITTLE F1 F2 F3 F3 F2 F1
#define PAIR_BIG B1 B2 B3 B3 B2 B1
#define FACES "element face 2\nproperty list uchar int vertex_indices\n"
#define CAMERA "element camera 1\nproperty float view_px\nproperty double fx\n"
#define EIGHT "\1\2\3\4\5\6\7\10"

static const struct pair {
    const char *name, *file;
    size_t size;
} pairs[] = {
#define PAIR(name, file) {name, file, sizeof(file) - 1},
    PAIR("ascii", ASCII TWO END "1 2 3\n3 2 1\n") PAIR("little", LITTLE TWO END PAIR_LITTLE)
        PAIR("big", BIG TWO END PAIR_BIG) PAIR(
            "sized types",
            ASCII "element vertex 2\nproperty float32 x\nproperty float32 y\nproperty "
                  "float32 z\n" END
                  "1 2 3\n3 2 1\n") PAIR("ascii crlf", CRLF("ascii") "1 2 3\r\n3 2 1\r\n")
            PAIR("little crlf", CRLF("binary_little_endian") PAIR_LITTLE) PAIR(
                "big crlf", CRLF("binary_big_endian") PAIR_BIG) PAIR("ascii cr",
                                                                     CR("ascii") "1 2 3\r3 2 1\r")
                PAIR("little cr", CR("binary_little_endian") PAIR_LITTLE) PAIR(
                    "ascii crlf behind an lf header", ASCII TWO END
                    "1 2 3\r\n3 2 1\r\n") PAIR("no line end at the end", ASCII TWO END
                                               "1 2 3\n3 2 1") PAIR("blank lines", ASCII TWO END
                                                                    "\n \n1 2 3\n\n\t\n3 2 1\n\n")
                    PAIR("tabs and blanks", ASCII TWO END "\t1  2\t \t3 \n 3 2 1\t\n") PAIR(
                        "every way to write a number", ASCII TWO END
                        "+1 2.e0 0.3E+1\n300e-2 .2e1 1.00000000000000000000000000000000\n")
                        PAIR("blanks in the header",
                             "ply\nformat  ascii\t1.0 \n\nelement  vertex 2\n property float x\n"
                             "property float y\nproperty float z\n" END "1 2 3\n3 2 1\n")
                            PAIR("comments everywhere",
                                 "ply\ncomment before\nformat ascii 1.0\ncomment "
                                 "\xe9t\xe9 \xff\ncomment\nobj_info a 1\n"
                                 "obj_info\n" TWO
                                 "comment element vertex 5\nobj_info property float "
                                 "w\n" END "1 2 3\n3 2 1\n") PAIR("more behind the last "
                                                                  "element",
                                                                  LITTLE TWO END PAIR_LITTLE
                                                                  "trailing bytes")
                                PAIR("more lines behind the last element", ASCII TWO END
                                     "1 2 3\n3 2 "
                                     "1\nnan junk\n") PAIR("faces behind", ASCII TWO FACES END
                                                           "1 2 3\n3 2 1\n3 0 1 2\n4 0 1 "
                                                           "2 3\n")
                                    PAIR("binary faces behind, cut",
                                         LITTLE TWO FACES END PAIR_LITTLE
                                         "\3\0") PAIR("tristrips behind", LITTLE TWO
                                                      "element tristrips 1\nproperty list int int "
                                                      "vertex_indices\n" END PAIR_LITTLE
                                                      "\3\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0")
                                        PAIR("ascii faces before", ASCII FACES TWO END
                                             "3 0 1 2\n\n4 0 "
                                             "1 2 3\n1 2 "
                                             "3\n3 2 1\n") PAIR("little faces before",
                                                                LITTLE FACES TWO END
                                                                "\1\1\0\0\0\2\1\0\0\0\2\0\0"
                                                                "\0" PAIR_LITTLE)
                                            PAIR("big faces before", BIG FACES TWO END
                                                 "\1\0\0\0\1\2\0"
                                                 "\0\0\1\0\0\0"
                                                 "\2" PAIR_BIG) PAIR("empty lists before",
                                                                     LITTLE FACES TWO END
                                                                     "\0"
                                                                     "\0" PAIR_LITTLE)
                                                PAIR(
                                                    "no faces before", LITTLE
                                                    "element face "
                                                    "0\nproperty list uchar "
                                                    "int a\n" TWO END
                                                        PAIR_LITTLE) PAIR("lists with a short "
                                                                          "count",
                                                                          BIG
                                                                          "element a 1\nproperty "
                                                                          "list short short b\n" TWO
                                                                              END "\0\2"
                                                                          "\0\1\0\2" PAIR_BIG)
                                                    PAIR("lists with an int count of doubles",
                                                         LITTLE
                                                         "element a 1\nproperty list int double "
                                                         "b\n" TWO END "\1\0\0\0" EIGHT PAIR_LITTLE)
                                                        PAIR("lists with a float count", LITTLE
                                                             "element a 1\nproperty list float "
                                                             "uchar "
                                                             "b\n" TWO END F2
                                                             "ab" PAIR_LITTLE) PAIR("lists with a "
                                                                                    "double count",
                                                                                    BIG
                                                                                    "element a "
                                                                                    "1\nproperty "
                                                                                    "list "
                                                                                    "double uchar "
                                                                                    "b\n" TWO END
                                                                                    "\x40\x08\0\0\0"
                                                                                    "\0\0"
                                                                                    "\0"
                                                                                    "abc" PAIR_BIG)
                                                            PAIR("lists and scalars in turn", LITTLE
                                                                 "element a 2\nproperty char "
                                                                 "b\nproperty list char ushort "
                                                                 "c\nproperty double d\n"
                                                                 "property list uchar char e\n" TWO
                                                                     END "x\1ab" EIGHT "\2xy"
                                                                 "x\0" EIGHT "\0" PAIR_LITTLE)
                                                                PAIR(
                                                                    "a camera before",
                                                                    LITTLE CAMERA TWO END
                                                                    "1234" EIGHT
                                                                        PAIR_LITTLE) PAIR("an "
                                                                                          "ascii "
                                                                                          "camera "
                                                                                          "before",
                                                                                          ASCII CAMERA
                                                                                              TWO END
                                                                                          "0 "
                                                                                          "nan\n1 "
                                                                                          "2 3\n3 "
                                                                                          "2 1\n")
                                                                    PAIR(
                                                                        "an "
                                                                        "ele"
                                                                        "men"
                                                                        "t "
                                                                        "wit"
                                                                        "hou"
                                                                        "t "
                                                                        "pro"
                                                                        "per"
                                                                        "tie"
                                                                        "s "
                                                                        "bef"
                                                                        "or"
                                                                        "e",
                                                                        LITTLE
                                                                        "ele"
                                                                        "men"
                                                                        "t "
                                                                        "not"
                                                                        "hin"
                                                                        "g "
                                                                        "184"
                                                                        "467"
                                                                        "440"
                                                                        "737"
                                                                        "095"
                                                                        "516"
                                                                        "15"
                                                                        "\n" TWO END
                                                                            PAIR_LITTLE) PAIR("an "
                                                                                              "asci"
                                                                                              "i "
                                                                                              "elem"
                                                                                              "ent "
                                                                                              "with"
                                                                                              "out "
                                                                                              "prop"
                                                                                              "erti"
                                                                                              "es "
                                                                                              "befo"
                                                                                              "re",
                                                                                              ASCII
                                                                                              "elem"
                                                                                              "ent "
                                                                                              "noth"
                                                                                              "ing "
                                                                                              "3"
                                                                                              "\n" TWO
                                                                                                  END
                                                                                              "\n\n"
                                                                                              "\n1 "
                                                                                              "2 "
                                                                                              "3\n3"
                                                                                              " "
                                                                                              "2 "
                                                                                              "1\n")
                                                                        PAIR("huge"
                                                                             " cou"
                                                                             "nts "
                                                                             "behi"
                                                                             "nd "
                                                                             "are "
                                                                             "nobo"
                                                                             "dy'"
                                                                             "s "
                                                                             "busi"
                                                                             "nes"
                                                                             "s",
                                                                             LITTLE
                                                                                 TWO
                                                                             "elem"
                                                                             "ent "
                                                                             "face"
                                                                             " "
                                                                             "1844"
                                                                             "6744"
                                                                             "0737"
                                                                             "0955"
                                                                             "1616"
                                                                             "\npr"
                                                                             "oper"
                                                                             "ty "
                                                                             "list"
                                                                             " "
                                                                             "ucha"
                                                                             "r "
                                                                             "int "
                                                                             "a"
                                                                             "\n" END PAIR_LITTLE)
                                                                            PAIR(
                                                                                "a list in ascii "
                                                                                "vertices",
                                                                                ASCII
                                                                                "element vertex "
                                                                                "2\nproperty float "
                                                                                "x\nproperty list "
                                                                                "uchar int "
                                                                                "a\nproperty float "
                                                                                "y\nproperty float "
                                                                                "z\n" END
                                                                                "1 2 7 7 2 3\n3 0 "
                                                                                "2 1\n") PAIR("a "
                                                                                              "list"
                                                                                              " in "
                                                                                              "litt"
                                                                                              "le "
                                                                                              "vert"
                                                                                              "ice"
                                                                                              "s",
                                                                                              LITTLE
                                                                                              "elem"
                                                                                              "ent "
                                                                                              "vert"
                                                                                              "ex "
                                                                                              "2\np"
                                                                                              "rope"
                                                                                              "rty "
                                                                                              "floa"
                                                                                              "t "
                                                                                              "x\np"
                                                                                              "rope"
                                                                                              "rty "
                                                                                              "list"
                                                                                              " uch"
                                                                                              "ar "
                                                                                              "shor"
                                                                                              "t "
                                                                                              "a\np"
                                                                                              "rope"
                                                                                              "rty "
                                                                                              "floa"
                                                                                              "t "
                                                                                              "y\n"
                                                                                              "prop"
                                                                                              "erty"
                                                                                              " flo"
                                                                                              "at "
                                                                                              "z"
                                                                                              "\n" END
                                                                                                  F1
                                                                                              "\2"
                                                                                              "abc"
                                                                                              "d" F2 F3
                                                                                                  F3
                                                                                              "\0" F2
                                                                                                  F1)
                                                                                PAIR(
                                                                                    "a list in big "
                                                                                    "vertices",
                                                                                    BIG
                                                                                    "element "
                                                                                    "vertex "
                                                                                    "2\nproperty "
                                                                                    "list short "
                                                                                    "short "
                                                                                    "a\nproperty "
                                                                                    "float "
                                                                                    "x\nproperty "
                                                                                    "float y\n"
                                                                                    "property "
                                                                                    "float z\n" END
                                                                                    "\0\1ab" B1 B2
                                                                                        B3
                                                                                    "\0\0" B3 B2
                                                                                        B1)
                                                                                    PAIR("coordinat"
                                                                                         "es of "
                                                                                         "char",
                                                                                         LITTLE
                                                                                         "element "
                                                                                         "vertex "
                                                                                         "2\nproper"
                                                                                         "ty char "
                                                                                         "x\nproper"
                                                                                         "ty char "
                                                                                         "y\nproper"
                                                                                         "ty "
                                                                                         "char "
                                                                                         "z\n" END
                                                                                         "\1\2\3\3"
                                                                                         "\2\1")
                                                                                        PAIR(
                                                                                            "coord"
                                                                                            "inate"
                                                                                            "s of "
                                                                                            "mixed"
                                                                                            " smal"
                                                                                            "l "
                                                                                            "type"
                                                                                            "s",
                                                                                            BIG
                                                                                            "eleme"
                                                                                            "nt "
                                                                                            "verte"
                                                                                            "x "
                                                                                            "2\npr"
                                                                                            "opert"
                                                                                            "y "
                                                                                            "uint8"
                                                                                            " z\np"
                                                                                            "roper"
                                                                                            "ty "
                                                                                            "int16"
                                                                                            " y\np"
                                                                                            "roper"
                                                                                            "ty "
                                                                                            "float"
                                                                                            " x"
                                                                                            "\n" END
                                                                                            "\3"
                                                                                            "\0"
                                                                                            "\2" B1
                                                                                            "\1"
                                                                                            "\0"
                                                                                            "\2" B3)
                                                                                            PAIR(
                                                                                                "as"
                                                                                                "ci"
                                                                                                "i "
                                                                                                "co"
                                                                                                "or"
                                                                                                "di"
                                                                                                "na"
                                                                                                "te"
                                                                                                "s "
                                                                                                "of"
                                                                                                " u"
                                                                                                "sh"
                                                                                                "or"
                                                                                                "t",
                                                                                                ASCII
                                                                                                "el"
                                                                                                "em"
                                                                                                "en"
                                                                                                "t "
                                                                                                "ve"
                                                                                                "rt"
                                                                                                "ex"
                                                                                                " 2"
                                                                                                "\n"
                                                                                                "pr"
                                                                                                "op"
                                                                                                "er"
                                                                                                "ty"
                                                                                                " u"
                                                                                                "sh"
                                                                                                "or"
                                                                                                "t "
                                                                                                "x"
                                                                                                "\n"
                                                                                                "pr"
                                                                                                "op"
                                                                                                "er"
                                                                                                "ty"
                                                                                                " u"
                                                                                                "ch"
                                                                                                "ar"
                                                                                                " "
                                                                                                "y"
                                                                                                "\n"
                                                                                                "pr"
                                                                                                "op"
                                                                                                "er"
                                                                                                "ty"
                                                                                                " s"
                                                                                                "ho"
                                                                                                "rt"
                                                                                                " z"
                                                                                                "\n" END
                                                                                                "1 "
                                                                                                "2 "
                                                                                                "3"
                                                                                                "\n"
                                                                                                "3 "
                                                                                                "2 "
                                                                                                "1"
                                                                                                "\n")
#undef PAIR
};

enum { PAIRS = sizeof pairs / sizeof pairs[0] };

/* Vector. */
START_TEST(every_spelling_means_the_same_two_points)
{
    struct vor_cloud cloud;

    read_exactly(&cloud, pairs[_i].file, pairs[_i].size);
    assert_pair(&cloud);
}
END_TEST

/* Property: a file that ends early is refused; nothing past the end is read. Ascii may lose its
 * last line end, and what lies behind the vertices. */
START_TEST(every_prefix_is_refused_or_means_the_same)
{
    const struct pair *pair = &pairs[_i];

    for (size_t size = 0; size < pair->size; size++) {
        uint8_t *copy = malloc(size > 0 ? size : 1);
        struct vor_cloud cloud;
        vor_status status;

        ck_assert_ptr_nonnull(copy);
        memcpy(copy, pair->file, size);
        vor_cloud_init(&cloud, &vt_memory);
        status = vor_ply_read(&cloud, copy, size, &limits, &vt_err);
        free(copy);
        if (status == VOR_OK) {
            ck_assert_uint_eq(cloud.n, 2);
            ck_assert_float_eq(cloud.xyz[0], 1);
            ck_assert_float_eq(cloud.xyz[4], 2);
            vor_cloud_free(&cloud);
        } else {
            ck_assert_msg(status == VOR_E_FORMAT, "%zu bytes: %s", size, vor_status_slug(status));
            ck_assert_int_le(vt_err.byte_offset, (int64_t)size);
        }
        vt_assert_no_leak();
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("ply_vector");

    vt_add_loop(suite, every_spelling_means_the_same_two_points, PAIRS);
    vt_add_loop(suite, every_prefix_is_refused_or_means_the_same, PAIRS);
    return vt_run(suite);
}
