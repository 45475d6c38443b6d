/* The writer: what it writes is JSON whatever comes in, and numbers come back as they went. */
#include "proto/json/json.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

static struct vor_text text;

static void start(void)
{
    vor_text_init(&text, 0);
}

static void expect(const char *wanted)
{
    vt_assert_ok(vor_text_status(&text, &vt_err));
    ck_assert_str_eq(text.data, wanted);
    vor_text_free(&text);
}

VT_TEST(commas_stand_between_values_and_nowhere_else)
{
    start();
    vor_json_begin_object(&text);
    vor_json_put_string(&text, "a", "b");
    vor_json_key(&text, "c");
    vor_json_begin_array(&text);
    vor_json_u64(&text, UINT64_MAX);
    vor_json_i64(&text, INT64_MIN);
    vor_json_begin_array(&text);
    vor_json_end_array(&text);
    vor_json_begin_object(&text);
    vor_json_end_object(&text);
    vor_json_raw(&text, "{\"x\":1}", 7);
    vor_json_end_array(&text);
    vor_json_put_bool(&text, "d", 1);
    vor_json_put_bool(&text, "e", 0);
    vor_json_key(&text, "f");
    vor_json_null(&text);
    vor_json_put_string(&text, "g", NULL);
    vor_json_end_object(&text);
    expect("{\"a\":\"b\",\"c\":[18446744073709551615,-9223372036854775808,[],{},{\"x\":1}],"
           "\"d\":true,\"e\":false,\"f\":null,\"g\":null}");
}

VT_TEST(a_document_after_other_text_begins_without_a_comma)
{
    start();
    vor_json_begin_object(&text);
    vor_json_end_object(&text);
    vor_text_puts(&text, "\n");
    vor_json_begin_object(&text);
    vor_json_end_object(&text);
    vor_text_printf(&text, " %d", 7);
    expect("{}\n{} 7");
}

VT_TEST(strings_are_escaped_as_the_rfc_wants)
{
    static const char bytes[] = "\"\\/\b\f\n\r\t\x01\x1f\x7f\0z";

    start();
    vor_json_bytes(&text, bytes, sizeof bytes - 1);
    expect("\"\\\"\\\\/\\b\\f\\n\\r\\t\\u0001\\u001f\\u007f\\u0000z\"");
}

VT_TEST(utf8_passes_and_what_is_not_becomes_the_replacement_character)
{
    start();
    vor_json_string(&text, "\xc3\xbc\xe2\x82\xac\xf0\x9f\x90\x84");
    expect("\"\xc3\xbc\xe2\x82\xac\xf0\x9f\x90\x84\"");
    start();
    vor_json_string(&text, "a\xff\xc0\xaf\xed\xa0\x80\xf5z\xe2\x82");
    expect("\"a\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd"
           "z\xef\xbf\xbd\xef\xbf\xbd\"");
}

VT_TEST(doubles_are_as_short_as_they_can_be)
{
    static const double values[] = {0,    -0.0,      1,      0.1,    1.0 / 3, 100000, 1e15,
                                    1e16, 123456.75, 5e-324, 1e-300, 2.5e300, -1.5};

    start();
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
        vor_json_double(&text, values[i]);
    expect("0,-0,1,0.1,0.3333333333333333,100000,1e+15,1e+16,123456.75,4.94065645841247e-324,"
           "1e-300,2.5e+300,-1.5");
}

VT_TEST(what_is_no_number_is_null)
{
    start();
    vor_json_double(&text, NAN);
    vor_json_double(&text, INFINITY);
    vor_json_double(&text, -INFINITY);
    expect("null,null,null");
}

VT_TEST_LOOP(every_double_comes_back_bit_for_bit, 20)
{
    for (uint64_t i = 0; i < 500; i++) {
        uint64_t bits = vor_rng_bits((uint64_t)_i, 3, i);
        struct vor_json *json = NULL;
        double value, back = 0;

        if (i % 2 == 1) /* and the kind of number we write: a fraction of moderate size */
            value = (vt_unit((uint64_t)_i, i) - 0.5) * pow(10, (double)(i % 30) - 15);
        else
            memcpy(&value, &bits, sizeof value);
        if (!isfinite(value))
            continue;
        start();
        vor_json_double(&text, value);
        vt_assert_ok(vor_json_parse(&json, text.data, text.size, &vt_err));
        ck_assert(vor_json_get_number(json, &back));
        ck_assert_msg(memcmp(&value, &back, sizeof value) == 0, "%s is not %.17g", text.data,
                      value);
        vor_json_free(json);
        vor_text_free(&text);
    }
}

VT_TEST_LOOP(any_bytes_make_a_valid_string, 20)
{
    for (uint64_t i = 0; i < 300; i++) {
        char bytes[48];
        size_t size = (size_t)(vt_unit((uint64_t)_i, 10000 + i) * sizeof bytes);
        struct vor_json *json = NULL;
        int ascii = i % 3 == 0;

        for (size_t j = 0; j < size; j++) {
            uint64_t random = vor_rng_below((uint64_t)_i, i, j, ascii ? 127 : 256);
            bytes[j] = (char)(ascii ? random + 1 : random);
        }
        start();
        vor_json_begin_array(&text);
        vor_json_bytes(&text, bytes, size);
        vor_json_end_array(&text);
        if (memchr(bytes, 0, size) != NULL) {
            vt_assert_fails(VOR_E_REQUEST, vor_json_scan(text.data, text.size, &vt_err));
            ck_assert_ptr_nonnull(strstr(vt_err.message, "\\u0000"));
        } else {
            vt_assert_ok(vor_json_parse(&json, text.data, text.size, &vt_err));
            if (ascii) {
                const char *back = vor_json_get_string(vor_json_first(json));

                ck_assert_uint_eq(strlen(back), size);
                ck_assert_mem_eq(back, bytes, size);
            }
        }
        vor_json_free(json);
        vor_text_free(&text);
    }
}

VT_TEST(a_text_stops_at_its_cap_and_says_so)
{
    vor_text_init(&text, 10);
    vor_text_puts(&text, "0123456789");
    vt_assert_ok(vor_text_status(&text, &vt_err));
    vor_text_puts(&text, "x");
    vor_text_puts(&text, "");
    vt_assert_fails(VOR_E_NOMEM, vor_text_status(&text, &vt_err));
    ck_assert_str_eq(text.data, "0123456789");
    vor_text_clear(&text);
    vt_assert_ok(vor_text_status(&text, &vt_err));
    vor_json_string(&text, "longer than ten");
    vt_assert_fails(VOR_E_NOMEM, vor_text_status(&text, &vt_err));
    vor_text_free(&text);
}
