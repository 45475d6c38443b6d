/* Refusals: what a PLY file may lie about, one row a lie, with the exact status and the place that
 * the error points at. */
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

#include <stdlib.h>
#include <string.h>

#define ASCII "ply\nformat ascii 1.0\n"
#define LITTLE "ply\nformat binary_little_endian 1.0\n"
#define BIG "ply\nformat binary_big_endian 1.0\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define ONE "element vertex 1\n" XYZ
#define TWO "element vertex 2\n" XYZ
#define END "end_header\n"
#define ZERO4 "\0\0\0\0"
#define POINT ZERO4 ZERO4 ZERO4
#define FILE_OF(text) text, sizeof(text) - 1

/* Where the error points: at the first place of a text in the file, behind its last byte, nowhere.
 */
#define AT(text) text, sizeof(text) - 1
#define AT_END NULL, 0
#define NOWHERE NULL, 1

static const struct row {
    const char *name;
    vor_status status;
    const char *at;
    size_t at_size;
    const char *file;
    size_t size;
} rows[] = {
    /* The first lines. */
    {"empty", VOR_E_FORMAT, AT(""), FILE_OF("")},
    {"one_byte", VOR_E_FORMAT, AT(""), FILE_OF("p")},
    {"only_magic", VOR_E_FORMAT, AT_END, FILE_OF("ply")},
    {"only_magic_line", VOR_E_FORMAT, AT_END, FILE_OF("ply\n")},
    {"only_magic_cr", VOR_E_FORMAT, AT_END, FILE_OF("ply\r")},
    {"only_magic_crlf", VOR_E_FORMAT, AT_END, FILE_OF("ply\r\n")},
    {"capital_magic", VOR_E_FORMAT, AT(""), FILE_OF("PLY\nformat ascii 1.0\n" ONE END "0 0 0\n")},
    {"magic_with_tail", VOR_E_FORMAT, AT(""),
     FILE_OF("plyx\nformat ascii 1.0\n" ONE END "0 0 0\n")},
    {"magic_with_word", VOR_E_FORMAT, AT(""),
     FILE_OF("ply x\nformat ascii 1.0\n" ONE END "0 0 0\n")},
    {"other_format", VOR_E_FORMAT, AT(""), FILE_OF("solid cube\n")},
    {"byte_order_mark_cut", VOR_E_FORMAT, AT(""), FILE_OF("\xef\xbb" ASCII ONE END "0 0 0\n")},
    {"no_format", VOR_E_FORMAT, AT("element"), FILE_OF("ply\n" ONE END "0 0 0\n")},
    {"no_format_no_element", VOR_E_FORMAT, AT("end_header"), FILE_OF("ply\n" END)},
    {"format_after_element", VOR_E_FORMAT, AT("element"),
     FILE_OF("ply\nelement vertex 1\nformat ascii 1.0\n" XYZ END "0 0 0\n")},
    {"two_formats", VOR_E_FORMAT, AT("format binary"),
     FILE_OF(ASCII "format binary_little_endian 1.0\n" ONE END "0 0 0\n")},
    {"middle_endian", VOR_E_FORMAT, AT("format"),
     FILE_OF("ply\nformat binary_middle_endian 1.0\n" ONE END POINT)},
    {"endian_without_binary", VOR_E_FORMAT, AT("format"),
     FILE_OF("ply\nformat little_endian 1.0\n" ONE END POINT)},
    {"capital_format", VOR_E_FORMAT, AT("format"),
     FILE_OF("ply\nformat ASCII 1.0\n" ONE END "0 0 0\n")},
    {"version_2", VOR_E_FORMAT, AT("format"), FILE_OF("ply\nformat ascii 2.0\n" ONE END "0 0 0\n")},
    {"no_version", VOR_E_FORMAT, AT("format"), FILE_OF("ply\nformat ascii\n" ONE END "0 0 0\n")},
    {"format_alone", VOR_E_FORMAT, AT("format"), FILE_OF("ply\nformat\n" ONE END "0 0 0\n")},
    {"format_with_tail", VOR_E_FORMAT, AT("format"),
     FILE_OF("ply\nformat ascii 1.0 x\n" ONE END "0 0 0\n")},
    /* Lines of the header. */
    {"unknown_keyword", VOR_E_FORMAT, AT("elements"),
     FILE_OF(ASCII "elements vertex 1\n" XYZ END "0 0 0\n")},
    {"capital_keyword", VOR_E_FORMAT, AT("Element"),
     FILE_OF(ASCII "Element vertex 1\n" XYZ END "0 0 0\n")},
    {"no_end_header", VOR_E_FORMAT, AT_END, FILE_OF(ASCII ONE)},
    {"end_header_unfinished", VOR_E_FORMAT, AT_END, FILE_OF(ASCII ONE "end_header")},
    {"end_header_misspelt", VOR_E_FORMAT, AT("end_heade\n"),
     FILE_OF(ASCII ONE "end_heade\n0 0 0\n")},
    {"end_header_with_tail", VOR_E_FORMAT, AT("end_header x"),
     FILE_OF(ASCII ONE "end_header x\n0 0 0\n")},
    {"cut_inside_a_property", VOR_E_FORMAT, AT_END, FILE_OF(ASCII "element vertex 1\nproperty fl")},
    {"nul_in_keyword", VOR_E_FORMAT, AT("elem\0ent"),
     FILE_OF(ASCII "elem\0ent vertex 1\n" XYZ END "0 0 0")},
    {"nul_in_name", VOR_E_FORMAT, AT("property float x\0"),
     FILE_OF(ASCII "element vertex 1\nproperty float x\0\n" END "0 0 0")},
    {"escape_in_name", VOR_E_FORMAT, AT("property float \033"),
     FILE_OF(ASCII "element vertex 1\nproperty float \033[31mx\n" XYZ END "0 0 0 0")},
    {"delete_in_name", VOR_E_FORMAT, AT("property float \x7f"),
     FILE_OF(ASCII ONE "property float \x7f\n" END "0 0 0 0")},
    {"seven_words", VOR_E_FORMAT, AT("element vertex 1 2 3 4 5"),
     FILE_OF(ASCII "element vertex 1 2 3 4 5\n" XYZ END "0 0 0")},
    {"commentary", VOR_E_FORMAT, AT("commentary"), FILE_OF(ASCII "commentary a\n" ONE END "0 0 0")},
    {"cr_inside_a_line", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element\rvertex 1\n" XYZ END "0 0 0")},
    {"body_instead_of_header", VOR_E_FORMAT, AT("0 0 0"), FILE_OF(ASCII "0 0 0\n1 1 1\n")},
    /* Elements. */
    {"no_element", VOR_E_FORMAT, AT_END, FILE_OF(ASCII END)},
    {"no_vertex", VOR_E_FORMAT, AT("0 0 0"), FILE_OF(ASCII "element point 1\n" XYZ END "0 0 0\n")},
    {"two_vertices", VOR_E_FORMAT, AT("element vertex 2"),
     FILE_OF(ASCII ONE "element vertex 2\n" XYZ END "0 0 0\n0 0 0\n0 0 0\n")},
    {"two_faces", VOR_E_FORMAT, AT("element face 2"),
     FILE_OF(ASCII ONE "element face 1\nelement face 2\n" END "0 0 0\n")},
    {"element_alone", VOR_E_FORMAT, AT("element\n"), FILE_OF(ASCII "element\n" XYZ END "0 0 0\n")},
    {"element_without_count", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex\n" XYZ END "0 0 0\n")},
    {"element_with_tail", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex 1 1\n" XYZ END "0 0 0\n")},
    {"count_not_a_number", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex many\n" XYZ END "0 0 0\n")},
    {"count_negative", VOR_E_FORMAT, AT("element"),
     FILE_OF(LITTLE "element vertex -1\n" XYZ END POINT)},
    {"count_minus_2_to_31", VOR_E_FORMAT, AT("element"),
     FILE_OF(LITTLE "element vertex -2147483648\n" XYZ END POINT)},
    {"count_with_plus", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex +1\n" XYZ END "0 0 0\n")},
    {"count_real", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex 1.0\n" XYZ END "0 0 0\n")},
    {"count_exponent", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex 1e0\n" XYZ END "0 0 0\n")},
    {"count_hexadecimal", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex 0x1\n" XYZ END "0 0 0\n")},
    {"count_zero", VOR_E_EMPTY, AT("element"), FILE_OF(ASCII "element vertex 0\n" XYZ END)},
    {"count_zero_binary", VOR_E_EMPTY, AT("element"),
     FILE_OF(LITTLE "element vertex 000\n" XYZ END POINT)},
    {"count_over_the_limit", VOR_E_LIMIT, AT("element"),
     FILE_OF(ASCII "element vertex 1001\n" XYZ END "0 0 0\n")},
    {"count_2_to_31", VOR_E_LIMIT, AT("element"),
     FILE_OF(LITTLE "element vertex 2147483648\n" XYZ END POINT)},
    {"count_2_to_32_less_1", VOR_E_LIMIT, AT("element"),
     FILE_OF(LITTLE "element vertex 4294967295\n" XYZ END POINT)},
    {"count_2_to_63", VOR_E_LIMIT, AT("element"),
     FILE_OF(LITTLE "element vertex 9223372036854775808\n" XYZ END POINT)},
    {"count_2_to_64_less_1", VOR_E_LIMIT, AT("element"),
     FILE_OF(LITTLE "element vertex 18446744073709551615\n" XYZ END POINT)},
    {"count_2_to_64", VOR_E_LIMIT, AT("element"),
     FILE_OF(LITTLE "element vertex 18446744073709551616\n" XYZ END POINT)},
    {"count_wraps_to_1", VOR_E_LIMIT, AT("element"),
     FILE_OF(LITTLE "element vertex 18446744073709551617\n" XYZ END POINT)},
    {"count_of_40_digits", VOR_E_LIMIT, AT("element"),
     FILE_OF(LITTLE "element vertex 1000000000000000000000000000000000000000\n" XYZ END POINT)},
    /* Properties. */
    {"property_before_element", VOR_E_FORMAT, AT("property"), FILE_OF(ASCII XYZ ONE END "0 0 0\n")},
    {"property_alone", VOR_E_FORMAT, AT("property\n"),
     FILE_OF(ASCII ONE "property\n" END "0 0 0\n")},
    {"property_without_name", VOR_E_FORMAT, AT("property float\n"),
     FILE_OF(ASCII ONE "property float\n" END "0 0 0\n")},
    {"property_with_tail", VOR_E_FORMAT, AT("property float a b"),
     FILE_OF(ASCII ONE "property float a b\n" END "0 0 0 0\n")},
    {"property_of_unknown_type", VOR_E_FORMAT, AT("property half"),
     FILE_OF(ASCII ONE "property half a\n" END "0 0 0 0\n")},
    {"property_of_capital_type", VOR_E_FORMAT, AT("property Float"),
     FILE_OF(ASCII ONE "property Float a\n" END "0 0 0 0\n")},
    {"property_of_prefix_type", VOR_E_FORMAT, AT("property floa a"),
     FILE_OF(ASCII ONE "property floa a\n" END "0 0 0 0\n")},
    {"property_twice", VOR_E_FORMAT, AT("property double x"),
     FILE_OF(ASCII ONE "property double x\n" END "0 0 0 0\n")},
    {"property_twice_as_list", VOR_E_FORMAT, AT("property list"),
     FILE_OF(ASCII ONE "property list uchar int y\n" END "0 0 0 0\n")},
    {"property_twice_in_face", VOR_E_FORMAT, AT("property int b"),
     FILE_OF(ASCII ONE "element face 0\nproperty int a\nproperty char b\nproperty int b\n" END
                       "0 0 0\n")},
    {"list_without_name", VOR_E_FORMAT, AT("property list"),
     FILE_OF(ASCII ONE "property list uchar int\n" END "0 0 0 0\n")},
    {"list_without_types", VOR_E_FORMAT, AT("property list"),
     FILE_OF(ASCII ONE "property list a\n" END "0 0 0 0\n")},
    {"list_of_lists", VOR_E_FORMAT, AT("property list"),
     FILE_OF(ASCII ONE "property list uchar list a\n" END "0 0 0 0\n")},
    {"list_with_bad_count_type", VOR_E_FORMAT, AT("property list"),
     FILE_OF(ASCII ONE "property list bool int a\n" END "0 0 0 0\n")},
    {"list_with_bad_type", VOR_E_FORMAT, AT("property list"),
     FILE_OF(ASCII ONE "property list int bool a\n" END "0 0 0 0\n")},
    {"no_properties", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex 1\n" END "0 0 0\n")},
    {"no_x", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex 1\nproperty float y\nproperty float z\n" END "0 0\n")},
    {"no_y", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex 1\nproperty float x\nproperty float z\n" END "0 0\n")},
    {"no_z", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII "element vertex 1\nproperty float x\nproperty float y\n" END "0 0\n")},
    {"x_in_another_element", VOR_E_FORMAT, AT("element vertex"),
     FILE_OF(ASCII
             "element vertex 1\nproperty float y\nproperty float z\nelement a 1\nproperty float "
             "x\n" END "0 0\n0\n")},
    {"x_a_list", VOR_E_FORMAT, AT("element"),
     FILE_OF(ASCII
             "element vertex 1\nproperty list uchar float x\nproperty float y\nproperty float "
             "z\n" END "1 0 0 0\n")},
    /* Ascii data. */
    {"ascii_nothing", VOR_E_FORMAT, AT_END, FILE_OF(ASCII ONE END)},
    {"ascii_blanks_only", VOR_E_FORMAT, AT_END, FILE_OF(ASCII ONE END "      \n\n\n")},
    {"ascii_too_short_for_its_count", VOR_E_FORMAT, AT_END,
     FILE_OF(ASCII "element vertex 1000\n" XYZ END "0 0 0\n0 0 0\n")},
    {"ascii_one_line_missing", VOR_E_FORMAT, AT_END, FILE_OF(ASCII TWO END "0.25 0.25 0.25\n")},
    {"ascii_two_of_three", VOR_E_FORMAT, AT_END, FILE_OF(ASCII ONE END "0.25 0.25")},
    {"ascii_row_too_short", VOR_E_FORMAT, AT("\n1 1 1"), FILE_OF(ASCII TWO END "0 0\n1 1 10\n")},
    {"ascii_row_too_long", VOR_E_FORMAT, AT("7\n"), FILE_OF(ASCII TWO END "0 0 0 7\n1 1 1\n")},
    {"ascii_wrapped_row", VOR_E_FORMAT, AT("\n0\n1"), FILE_OF(ASCII TWO END "0 0\n0\n1 1 1\n")},
    {"ascii_junk", VOR_E_FORMAT, AT("junk"), FILE_OF(ASCII ONE END "0 junk 0\n")},
    {"ascii_comma", VOR_E_FORMAT, AT("1,5"), FILE_OF(ASCII ONE END "0 1,5 0\n")},
    {"ascii_commas_between", VOR_E_FORMAT, AT("1,2"), FILE_OF(ASCII ONE END "1,2,3\n      ")},
    {"ascii_hexadecimal", VOR_E_FORMAT, AT("0x10"), FILE_OF(ASCII ONE END "0 0x10 0\n")},
    {"ascii_two_points", VOR_E_FORMAT, AT("1.2.3"), FILE_OF(ASCII ONE END "0 1.2.3 0\n")},
    {"ascii_two_signs", VOR_E_FORMAT, AT("--1"), FILE_OF(ASCII ONE END "0 --1 0\n")},
    {"ascii_sign_alone", VOR_E_FORMAT, AT("- "), FILE_OF(ASCII ONE END "0 - 0\n")},
    {"ascii_point_alone", VOR_E_FORMAT, AT(". "), FILE_OF(ASCII ONE END "0 . 0\n")},
    {"ascii_exponent_alone", VOR_E_FORMAT, AT("e5"), FILE_OF(ASCII ONE END "0 e5 0\n")},
    {"ascii_exponent_empty", VOR_E_FORMAT, AT("1e "), FILE_OF(ASCII ONE END "0 1e 0\n")},
    {"ascii_exponent_sign_alone", VOR_E_FORMAT, AT("1e+"), FILE_OF(ASCII ONE END "0 1e+ 0\n")},
    {"ascii_exponent_real", VOR_E_FORMAT, AT("1e1.5"), FILE_OF(ASCII ONE END "0 1e1.5 0\n")},
    {"ascii_fortran_exponent", VOR_E_FORMAT, AT("1d5"), FILE_OF(ASCII ONE END "0 1d5 0\n")},
    {"ascii_suffix", VOR_E_FORMAT, AT("1.5f"), FILE_OF(ASCII ONE END "0 1.5f 0\n")},
    {"ascii_digit_group", VOR_E_FORMAT, AT("1_000"), FILE_OF(ASCII ONE END "0 1_000 0\n")},
    {"ascii_nul", VOR_E_FORMAT, AT("0\0"), FILE_OF(ASCII ONE END "0\0 0 0\n")},
    {"ascii_wide_digit", VOR_E_FORMAT, AT("\xef\xbc\x91"),
     FILE_OF(ASCII ONE END "0 \xef\xbc\x91 0\n")},
    {"ascii_binary_inside", VOR_E_FORMAT, AT("\x80\xff"),
     FILE_OF(ASCII ONE END "\x80\xff\x01\x02 0 0\n")},
    {"ascii_nan", VOR_E_NONFINITE, AT("nan"), FILE_OF(ASCII ONE END "0 nan 0\n")},
    {"ascii_capital_nan", VOR_E_NONFINITE, AT("NaN"), FILE_OF(ASCII ONE END "0 0 NaN\n")},
    {"ascii_signed_nan", VOR_E_NONFINITE, AT("-nan"), FILE_OF(ASCII ONE END "-nan 0 0\n")},
    {"ascii_inf", VOR_E_NONFINITE, AT("inf"), FILE_OF(ASCII ONE END "inf 0 0\n")},
    {"ascii_minus_infinity", VOR_E_NONFINITE, AT("-Infinity"),
     FILE_OF(ASCII ONE END "0 -Infinity 0\n")},
    {"ascii_nan_with_open_payload", VOR_E_FORMAT, AT("nan(1"),
     FILE_OF(ASCII ONE END "0 nan(1 0\n")},
    {"ascii_nan_with_tail", VOR_E_FORMAT, AT("nano"), FILE_OF(ASCII ONE END "0 nano 0\n")},
    {"ascii_1e400", VOR_E_FORMAT, AT("1e400"), FILE_OF(ASCII ONE END "0 1e400 0\n")},
    {"ascii_1e39_as_float", VOR_E_FORMAT, AT("-1e39"), FILE_OF(ASCII ONE END "0 -1e39 0\n")},
    {"ascii_1e99999999999", VOR_E_FORMAT, AT("1e99999"),
     FILE_OF(ASCII ONE END "0 1e99999999999 0\n")},
    {"ascii_1e309_as_double", VOR_E_FORMAT, AT("1e309"),
     FILE_OF(ASCII "element vertex 1\nproperty double x\nproperty double y\nproperty double z\n" END
                   "0 1e309 0\n")},
    {"ascii_uchar_256", VOR_E_FORMAT, AT("256"),
     FILE_OF(ASCII ONE "property uchar a\n" END "0 0 0 256\n")},
    {"ascii_uchar_negative", VOR_E_FORMAT, AT("-1"),
     FILE_OF(ASCII ONE "property uchar a\n" END "0 0 0 -1\n")},
    {"ascii_char_128", VOR_E_FORMAT, AT("128"),
     FILE_OF(ASCII ONE "property char a\n" END "0 0 0 128\n")},
    {"ascii_char_minus_129", VOR_E_FORMAT, AT("-129"),
     FILE_OF(ASCII ONE "property char a\n" END "0 0 0 -129\n")},
    {"ascii_short_32768", VOR_E_FORMAT, AT("32768"),
     FILE_OF(ASCII ONE "property short a\n" END "0 0 0 32768\n")},
    {"ascii_ushort_65536", VOR_E_FORMAT, AT("65536"),
     FILE_OF(ASCII ONE "property ushort a\n" END "0 0 0 65536\n")},
    {"ascii_int_2_to_31", VOR_E_FORMAT, AT("2147483648"),
     FILE_OF(ASCII ONE "property int a\n" END "0 0 0 2147483648\n")},
    {"ascii_int_below_minus_2_to_31", VOR_E_FORMAT, AT("-2147483649"),
     FILE_OF(ASCII ONE "property int a\n" END "0 0 0 -2147483649\n")},
    {"ascii_uint_2_to_32", VOR_E_FORMAT, AT("4294967296"),
     FILE_OF(ASCII ONE "property uint a\n" END "0 0 0 4294967296\n")},
    {"ascii_uint_wraps_64_bits", VOR_E_FORMAT, AT("18446744073709551617"),
     FILE_OF(ASCII ONE "property uint a\n" END "0 0 0 18446744073709551617\n")},
    {"ascii_int_real", VOR_E_FORMAT, AT("2.5"),
     FILE_OF(ASCII ONE "property int a\n" END "0 0 0 2.5\n")},
    {"ascii_int_exponent", VOR_E_FORMAT, AT("1e-2"),
     FILE_OF(ASCII ONE "property int a\n" END "0 0 0 1e-2\n")},
    {"ascii_letter_alone", VOR_E_FORMAT, AT("n "), FILE_OF(ASCII ONE END "0 n 0 \n")},
    {"ascii_int_nan", VOR_E_FORMAT, AT("nan"),
     FILE_OF(ASCII ONE "property int a\n" END "0 0 0 nan\n")},
    {"ascii_int_sign_alone", VOR_E_FORMAT, AT("+\n"),
     FILE_OF(ASCII ONE "property int a\n" END "0 0 0 +\n")},
    {"ascii_attribute_junk", VOR_E_FORMAT, AT("junk"),
     FILE_OF(ASCII ONE "property float a\n" END "0 0 0 junk\n")},
    {"ascii_attribute_1e400", VOR_E_FORMAT, AT("1e400"),
     FILE_OF(ASCII ONE "property double a\n" END "0 0 0 1e400\n")},
    /* Lists in ascii. */
    {"ascii_list_longer_than_its_line", VOR_E_FORMAT, AT("\n0 0 0 0"),
     FILE_OF(ASCII TWO "property list uchar int a\n" END "0 0 0 3 1 2\n0 0 0 0\n")},
    {"ascii_list_shorter_than_its_line", VOR_E_FORMAT, AT("3\n"),
     FILE_OF(ASCII TWO "property list uchar int a\n" END "0 0 0 2 1 2 3\n0 0 0 0\n")},
    {"ascii_list_of_2_to_32_less_1", VOR_E_FORMAT, AT("\n0 0 0 0"),
     FILE_OF(ASCII TWO "property list uint int a\n" END "0 0 0 4294967295 1\n0 0 0 0\n")},
    {"ascii_list_of_minus_1", VOR_E_FORMAT, AT("-1"),
     FILE_OF(ASCII ONE "property list char int a\n" END "0 0 0 -1 1\n")},
    {"ascii_list_of_256_in_uchar", VOR_E_FORMAT, AT("256"),
     FILE_OF(ASCII ONE "property list uchar int a\n" END "0 0 0 256 1\n")},
    {"ascii_list_of_junk", VOR_E_FORMAT, AT("q\n"),
     FILE_OF(ASCII ONE "property list uchar int a\n" END "0 0 0 q\n")},
    {"ascii_list_of_a_half", VOR_E_FORMAT, AT("0.5"),
     FILE_OF(ASCII ONE "property list float int a\n" END "0 0 0 0.5 1\n")},
    {"ascii_list_of_inf", VOR_E_FORMAT, AT("inf"),
     FILE_OF(ASCII ONE "property list float int a\n" END "0 0 0 inf 1\n")},
    {"ascii_list_missing", VOR_E_FORMAT, AT("\n0 0 0 0"),
     FILE_OF(ASCII TWO "property list uchar int a\n" END "0 0 0\n0 0 0 0\n0 0")},
    /* Elements before the vertices. */
    {"ascii_faces_before_missing", VOR_E_FORMAT, AT_END,
     FILE_OF(ASCII "element face 3\nproperty list uchar int a\n" ONE END "3 0 0 0\n0 0 0\n")},
    {"ascii_2_to_64_faces_before", VOR_E_FORMAT, AT_END,
     FILE_OF(ASCII "element face 18446744073709551615\nproperty list uchar int a\n" ONE END
                   "0\n0 0 0\n")},
    {"binary_2_to_64_faces_before", VOR_E_FORMAT, AT_END,
     FILE_OF(LITTLE
             "element face 18446744073709551615\nproperty list uchar int a\n" ONE END POINT)},
    {"binary_rows_before_overflow_64_bits", VOR_E_FORMAT, AT_END,
     FILE_OF(LITTLE "element a 2305843009213693952\nproperty double a\n" ONE END POINT)},
    {"binary_rows_before_missing", VOR_E_FORMAT, AT_END,
     FILE_OF(LITTLE "element a 2\nproperty double a\n" ONE END POINT)},
    {"binary_list_before_of_minus_1", VOR_E_FORMAT, AT("\xff\xff\xff\xff"),
     FILE_OF(LITTLE "element face 1\nproperty list int int a\n" ONE END "\xff\xff\xff\xff" POINT)},
    {"binary_list_before_of_2_to_32_less_1", VOR_E_FORMAT, AT("\xff\xff\xff\xff"),
     FILE_OF(LITTLE "element face 1\nproperty list uint char a\n" ONE END
                    "\xff\xff\xff\xff" POINT)},
    {"binary_list_before_one_too_long", VOR_E_FORMAT, AT("\x0d"),
     FILE_OF(LITTLE "element face 1\nproperty list uchar char a\n" ONE END "\x0d" POINT)},
    {"binary_list_before_leaves_too_little", VOR_E_FORMAT, AT_END,
     FILE_OF(LITTLE "element face 1\nproperty list uchar char a\n" ONE END "\x01" POINT)},
    {"binary_list_before_cut_in_its_count", VOR_E_FORMAT, AT_END,
     FILE_OF(LITTLE "element face 1\nproperty list uchar char b\nproperty list int char a\n" ONE END
                    "\x02\x01\x01\x01\x01")},
    {"binary_scalar_before_cut", VOR_E_FORMAT, AT_END,
     FILE_OF(LITTLE "element face 1\nproperty list uchar char b\nproperty int a\n" ONE END
                    "\x03\x01\x01\x01\x01")},
    {"binary_list_before_of_a_half", VOR_E_FORMAT, AT("\0\0\0\x3f"),
     FILE_OF(LITTLE "element face 1\nproperty list float char a\n" ONE END "\0\0\0\x3f" POINT)},
    {"binary_list_before_of_nan", VOR_E_FORMAT, AT("\0\0\xc0\x7f"),
     FILE_OF(LITTLE "element face 1\nproperty list float char a\n" ONE END "\0\0\xc0\x7f" POINT)},
    {"binary_list_before_of_1e300", VOR_E_FORMAT, AT("\x9c\x75\x00"),
     FILE_OF(LITTLE "element face 1\nproperty list double char a\n" ONE END
                    "\x9c\x75\x00\x88\x3c\xe4\x37\x7e" POINT)},
    /* Binary data. */
    {"little_nothing", VOR_E_FORMAT, AT_END, FILE_OF(LITTLE ONE END)},
    {"little_one_byte_missing", VOR_E_FORMAT, AT_END, FILE_OF(LITTLE ONE END ZERO4 ZERO4 "\0\0\0")},
    {"big_one_byte_missing", VOR_E_FORMAT, AT_END, FILE_OF(BIG ONE END ZERO4 ZERO4 "\0\0\0")},
    {"little_one_point_missing", VOR_E_FORMAT, AT_END, FILE_OF(LITTLE TWO END POINT)},
    {"little_crlf_one_byte_missing", VOR_E_FORMAT, AT_END,
     FILE_OF("ply\r\nformat binary_little_endian 1.0\r\nelement vertex 1\r\nproperty float "
             "x\r\nproperty float y\r\nproperty float z\r\nend_header\r\n" ZERO4 ZERO4 "\0\0\0")},
    {"little_nan", VOR_E_NONFINITE, AT("\0\0\xc0\x7f"),
     FILE_OF(LITTLE ONE END "\1\1\1\1"
                            "\0\0\xc0\x7f"
                            "\1\1\1\1")},
    {"little_signalling_nan", VOR_E_NONFINITE, AT("\1\0\x80\x7f"),
     FILE_OF(LITTLE ONE END "\1\1\1\1"
                            "\1\1\1\1"
                            "\1\0\x80\x7f")},
    {"little_inf", VOR_E_NONFINITE, AT("\0\0\x80\x7f"),
     FILE_OF(LITTLE TWO END "\1\1\1\1\1\1\1\1\1\1\1\1"
                            "\1\1\1\1"
                            "\1\1\1\1"
                            "\0\0\x80\x7f")},
    {"little_minus_inf_first", VOR_E_NONFINITE, AT("\0\0\x80\xff"),
     FILE_OF(LITTLE ONE END "\0\0\x80\xff"
                            "\1\1\1\1"
                            "\0\0\x80\x7f")},
    {"big_nan", VOR_E_NONFINITE, AT("\x7f\xc0"),
     FILE_OF(BIG ONE END "\1\1\1\1"
                         "\x7f\xc0\0\0"
                         "\1\1\1\1")},
    {"little_double_nan", VOR_E_NONFINITE, AT("\0\0\0\0\0\0\xf8\x7f"),
     FILE_OF(LITTLE
             "element vertex 1\nproperty double x\nproperty double y\nproperty double z\n" END
             "\1\1\1\1\1\1\1\1"
             "\0\0\0\0\0\0\xf8\x7f"
             "\1\1\1\1\1\1\1\1")},
    {"big_double_inf_behind_a_scalar", VOR_E_NONFINITE, AT("\x7f\xf0"),
     FILE_OF(BIG "element vertex 1\nproperty char a\nproperty double x\nproperty float y\nproperty "
                 "double z\n" END "a"
                 "\1\1\1\1\1\1\1\1"
                 "\1\1\1\1"
                 "\x7f\xf0\0\0\0\0\0\0")},
    {"little_double_beyond_float32", VOR_E_NONFINITE, NOWHERE,
     FILE_OF(LITTLE "element vertex 2\nproperty double x\nproperty char y\nproperty char z\n" END
                    "\x9c\x75\x00\x88\x3c\xe4\x37\x7e"
                    "\1\1"
                    "\0\0\0\0\0\0\0\0"
                    "\1\1")},
    {"list_in_vertex_too_long", VOR_E_FORMAT, AT("\x10"),
     FILE_OF(LITTLE ONE "property list uchar uchar a\n" END POINT "\x10"
                        "123456789")},
    {"list_in_vertex_of_2_to_32_less_1", VOR_E_FORMAT, AT("\xff\xff\xff\xff"),
     FILE_OF(LITTLE ONE "property list uint double a\n" END POINT "\xff\xff\xff\xff"
                        "123456789")},
    {"list_in_vertex_eats_the_next_row", VOR_E_FORMAT, AT_END,
     FILE_OF(LITTLE TWO "property list uchar uchar a\n" END POINT "\x0c" POINT "\0")},
    {"list_in_vertex_before_nan", VOR_E_NONFINITE, AT("\0\0\xc0\x7f"),
     FILE_OF(LITTLE "element vertex 1\nproperty list uchar uchar a\n" XYZ END "\2"
                    "\1\1"
                    "\1\1\1\1"
                    "\1\1\1\1"
                    "\0\0\xc0\x7f")},
    {"empty_list_in_vertex_too_little_left", VOR_E_FORMAT, AT_END,
     FILE_OF(LITTLE ONE "property list int uchar a\n" END POINT "\0\0\0")},
};

enum { ROWS = sizeof rows / sizeof rows[0] };
_Static_assert(ROWS >= 120, "the table of hostile PLY files has at least 120 rows");

static const struct vor_limits limits = {.points = 1000, .header_bytes = 65536};

static int64_t expected_offset(const struct row *row)
{
    size_t at = 0;

    if (row->at == NULL)
        return row->at_size == 0 ? (int64_t)row->size : -1;
    while (at + row->at_size <= row->size && memcmp(row->file + at, row->at, row->at_size) != 0)
        at++;
    ck_assert_msg(at + row->at_size <= row->size, "%s: the text is not in the file", row->name);
    return (int64_t)at;
}

/* A block of exactly the file's size, so that a sanitizer sees a read behind it. */
static uint8_t *exact_copy(const char *file, size_t size)
{
    uint8_t *copy = malloc(size > 0 ? size : 1);

    ck_assert_ptr_nonnull(copy);
    memcpy(copy, file, size);
    return copy;
}

static void assert_untouched(const struct vor_cloud *cloud)
{
    ck_assert_uint_eq(cloud->n, 0);
    ck_assert_uint_eq(cloud->attribute_count, 0);
    ck_assert_ptr_null(cloud->xyz);
    vt_assert_no_leak();
}

/* Refusal, RELIABILITY T4 and G9. */
START_TEST(a_lie_gets_its_status_and_place)
{
    const struct row *row = &rows[_i];
    uint8_t *file = exact_copy(row->file, row->size);
    struct vor_cloud cloud;
    vor_status status;

    vor_cloud_init(&cloud, &vt_memory);
    status = vor_ply_read(&cloud, file, row->size, &limits, &vt_err);
    ck_assert_msg(status == row->status, "%s: got %s (%s), want %s", row->name,
                  vor_status_slug(status), vt_err.message, vor_status_slug(row->status));
    ck_assert_msg(vt_err.byte_offset == expected_offset(row), "%s: points at %lld, want %lld (%s)",
                  row->name, (long long)vt_err.byte_offset, (long long)expected_offset(row),
                  vt_err.message);
    ck_assert_msg(strlen(vt_err.message) > 8, "%s: says nothing", row->name);
    for (const char *c = vt_err.message; *c != '\0'; c++)
        ck_assert_msg(*c >= 0x20 && *c < 0x7f, "%s: raw byte in the message", row->name);
    ck_assert_int_eq(vt_err.status, status);
    assert_untouched(&cloud);
    free(file);
}
END_TEST

/* Refusal: without anywhere to write the message to. */
START_TEST(a_lie_is_refused_without_an_error_to_fill)
{
    struct vor_cloud cloud;

    for (unsigned i = 0; i < ROWS; i++) {
        vor_cloud_init(&cloud, &vt_memory);
        ck_assert_int_eq(rows[i].status, vor_ply_read(&cloud, (const uint8_t *)rows[i].file,
                                                      rows[i].size, &limits, NULL));
        assert_untouched(&cloud);
    }
}
END_TEST

START_TEST(too_many_points_says_the_limit_and_the_number)
{
    static const char file[] = LITTLE "element vertex 4294967295\n" XYZ END;
    const struct vor_limits none = {.points = SIZE_MAX, .header_bytes = SIZE_MAX};
    struct vor_cloud cloud;

    vor_cloud_init(&cloud, &vt_memory);
    vt_assert_fails(VOR_E_LIMIT,
                    vor_ply_read(&cloud, (const uint8_t *)file, sizeof file - 1, &limits, &vt_err));
    ck_assert_uint_eq(vt_err.limit, 1000);
    ck_assert_uint_eq(vt_err.got, 4294967295u);
    vt_assert_fails(VOR_E_LIMIT,
                    vor_ply_read(&cloud, (const uint8_t *)file, sizeof file - 1, &none, &vt_err));
    ck_assert_uint_eq(vt_err.limit, VOR_POINTS_MAX);
}
END_TEST

/* Refusal: a header of 80 bytes that promises 50,000,000 points must not cost their memory. */
START_TEST(nothing_is_allocated_for_points_that_are_not_there)
{
    static const char *const files[] = {
        LITTLE "element vertex 50000000\n" XYZ END,
        ASCII "element vertex 50000000\n" XYZ END "0 0 0",
        LITTLE "element face 1\nproperty list uchar int a\nelement vertex 50000000\n" XYZ END "\4"};
    const struct vor_limits generous = VOR_LIMITS_DEFAULT;

    for (int i = 0; i < 3; i++) {
        struct vor_memory memory;
        struct vor_cloud cloud;

        vor_memory_init(&memory, SIZE_MAX);
        vor_cloud_init(&cloud, &memory);
        vt_assert_fails(VOR_E_FORMAT, vor_ply_read(&cloud, (const uint8_t *)files[i],
                                                   strlen(files[i]), &generous, &vt_err));
        ck_assert_uint_le(atomic_load(&memory.peak), 128 * 1024);
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("ply_hostile");

    vt_add_loop(suite, a_lie_gets_its_status_and_place, ROWS);
    vt_add(suite, a_lie_is_refused_without_an_error_to_fill);
    vt_add(suite, too_many_points_says_the_limit_and_the_number);
    vt_add(suite, nothing_is_allocated_for_points_that_are_not_there);
    return vt_run(suite);
}
