/* The reader's door: what strangers send is read to the letter of RFC 8259, or refused where it
 * goes wrong. */
#include "proto/json/json.h"
#include "tests/support/vt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Text, where it goes wrong (byte), and a word of the message. */
struct hostile {
    const char *text;
    long offset;
    const char *word;
};

static const struct hostile hostile[] = {
    {"", 0, "ends"},
    {"  ", 2, "ends"},
    {"{", 1, "ends"},
    {"[", 1, "ends"},
    {"}", 0, "'}'"},
    {"]", 0, "']'"},
    {"[}", 1, "'}'"},
    {"{]", 1, "']'"},
    {"[1", 2, "ends"},
    {"[1,", 3, "ends"},
    {"[1,]", 3, "']'"},
    {"[,1]", 1, "','"},
    {"[1 2]", 3, "'2'"},
    {"{\"a\"}", 4, "'}'"},
    {"{\"a\":}", 5, "'}'"},
    {"{\"a\":1,}", 7, "'}'"},
    {"{\"a\":1 \"b\":2}", 7, "'\"'"},
    {"{a:1}", 1, "'a'"},
    {"{'a':1}", 1, "'''"},
    {"{1:1}", 1, "'1'"},
    {"{\"a\":1}}", 7, "'}'"},
    {"{} {}", 3, "'{'"},
    {"{}x", 2, "'x'"},
    {"1 2", 2, "'2'"},
    {"// c\n1", 0, "'/'"},
    {"[1/* c */]", 2, "'/'"},
    {"\xef\xbb\xbf{}", 0, "0xef"},
    {"\xc2\xa0{}", 0, "0xc2"},
    {"\v{}", 0, "0x0b"},
    {"nul", 0, "'n'"},
    {"NULL", 0, "'N'"},
    {"True", 0, "'T'"},
    {"truefalse", 4, "'f'"},
    {"undefined", 0, "'u'"},
    {"NaN", 0, "'N'"},
    {"Infinity", 0, "'I'"},
    {"-Infinity", 1, "'I'"},
    {"01", 1, "'1'"},
    {"-01", 2, "'1'"},
    {"00", 1, "'0'"},
    {"1.", 2, "ends"},
    {"[1.]", 3, "']'"},
    {".5", 0, "'.'"},
    {"+1", 0, "'+'"},
    {"-", 1, "ends"},
    {"--1", 1, "'-'"},
    {"1e", 2, "ends"},
    {"1e+", 3, "ends"},
    {"1E-x", 3, "'x'"},
    {"0x10", 1, "'x'"},
    {"1_000", 1, "'_'"},
    {"1,5", 1, "','"},
    {"1e999", 0, "range of a double"},
    {"[-1e400]", 1, "range of a double"},
    {"1.7976931348623159e308", 0, "range of a double"},
    {"\"", 1, "ends"},
    {"\"abc", 4, "ends"},
    {"'abc'", 0, "'''"},
    {"\"a\nb\"", 2, "control"},
    {"\"a\tb\"", 2, "control"},
    {"\"\x01\"", 1, "control"},
    {"{\"a\x1f\":1}", 3, "control"},
    {"\"\\x41\"", 1, "backslash"},
    {"\"\\'\"", 1, "backslash"},
    {"\"\\", 1, "backslash"},
    {"\"\\u\"", 1, "hexadecimal"},
    {"\"\\u12\"", 1, "hexadecimal"},
    {"\"\\u12g4\"", 1, "hexadecimal"},
    {"\"\\u-123\"", 1, "hexadecimal"},
    {"\"\\u0000\"", 1, "\\u0000"},
    {"{\"ab\\u0000c\":1}", 4, "\\u0000"},
    {"\"\\ud800\"", 1, "surrogate"},
    {"\"\\ud800x\"", 1, "surrogate"},
    {"\"\\ud800\\n\"", 1, "surrogate"},
    {"\"\\ud800\\ud800\"", 1, "surrogate"},
    {"\"\\udc00\"", 1, "surrogate"},
    {"\"\\udbff\\ue000\"", 1, "surrogate"},
    {"\"\x80\"", 1, "UTF-8"},
    {"\"\xff\"", 1, "UTF-8"},
    {"\"\xc0\xaf\"", 1, "UTF-8"},
    {"\"\xc1\xbf\"", 1, "UTF-8"},
    {"\"\xe0\x80\xaf\"", 1, "UTF-8"},
    {"\"\xed\xa0\x80\"", 1, "UTF-8"},
    {"\"\xed\xbf\xbf\"", 1, "UTF-8"},
    {"\"\xf0\x80\x80\xaf\"", 1, "UTF-8"},
    {"\"\xf4\x90\x80\x80\"", 1, "UTF-8"},
    {"\"\xf5\x80\x80\x80\"", 1, "UTF-8"},
    {"\"\xe2\x82\"", 1, "UTF-8"},
    {"\"ab\xe2\x28\xa1\"", 3, "UTF-8"},
};

enum { HOSTILE = sizeof hostile / sizeof hostile[0] };

VT_TEST_LOOP(hostile_text_is_refused_where_it_goes_wrong, HOSTILE)
{
    const struct hostile *h = &hostile[_i];
    struct vor_json *json = (struct vor_json *)&vt_err;

    vt_assert_fails(VOR_E_REQUEST, vor_json_parse(&json, h->text, strlen(h->text), &vt_err));
    ck_assert_ptr_null(json);
    ck_assert_msg(vt_err.byte_offset == h->offset, "%s: byte %lld, want %ld (%s)", h->text,
                  (long long)vt_err.byte_offset, h->offset, vt_err.message);
    ck_assert_msg(strstr(vt_err.message, h->word) != NULL, "%s: %s", h->text, vt_err.message);
    ck_assert_ptr_null(strchr(vt_err.message, '\n'));
    ck_assert_int_eq(vor_json_parse(&json, h->text, strlen(h->text), NULL), VOR_E_REQUEST);
}

VT_TEST(nul_bytes_are_refused_wherever_they_stand)
{
    static const char *const texts[] = {"?", "[1?]", "{}?", "\"a?b\"", "{\"a?\":1}", "1?", "tr?e"};

    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        struct vor_json *json = NULL;
        char text[16];
        size_t size = strlen(texts[i]), at = strcspn(texts[i], "?");

        memcpy(text, texts[i], size);
        text[at] = '\0';
        vt_assert_fails(VOR_E_REQUEST, vor_json_parse(&json, text, size, &vt_err));
        ck_assert_int_eq(vt_err.byte_offset, (i == 6) ? 0 : (int64_t)at);
    }
}

/* open * count, middle, close * count. */
static char *nested(const char *open, size_t count, const char *middle, const char *close)
{
    char *text = malloc(count * (strlen(open) + strlen(close)) + strlen(middle) + 1), *at = text;

    for (size_t i = 0; i < count; i++)
        at += strlen(strcpy(at, open));
    at += strlen(strcpy(at, middle));
    for (size_t i = 0; i < count; i++)
        at += strlen(strcpy(at, close));
    return text;
}

static void expect_exceeded(char *text, uint64_t limit, uint64_t got, const char *word)
{
    struct vor_json *json = NULL;

    vt_assert_fails(VOR_E_REQUEST, vor_json_parse(&json, text, strlen(text), &vt_err));
    ck_assert_uint_eq(vt_err.limit, limit);
    ck_assert_uint_eq(vt_err.got, got);
    ck_assert_msg(strstr(vt_err.message, word) != NULL, "%s", vt_err.message);
    free(text);
}

static void expect_read(char *text)
{
    vor_json_free(vt_json(text));
    free(text);
}

VT_TEST(depth_ends_at_its_limit)
{
    expect_read(nested("[", 32, "", "]"));
    expect_exceeded(nested("[", 33, "", "]"), 32, 33, "nested");
    expect_exceeded(nested("[", 500000, "", "]"), 32, 33, "nested");
    expect_read(nested("{\"a\":", 32, "1", "}"));
    expect_exceeded(nested("{\"a\":", 33, "1", "}"), 32, 33, "nested");
    expect_exceeded(nested("[{\"a\":", 17, "1", "}]"), 32, 33, "nested");
}

VT_TEST(the_number_of_tokens_ends_at_its_limit)
{
    for (size_t extra = 0; extra < 2; extra++) {
        size_t count = VOR_JSON_TOKENS_MAX - 2 + extra; /* and the array, and the last element */
        char *text = malloc(2 * count + 8), *at = text;

        *at++ = '[';
        for (size_t i = 0; i < count; i++) {
            *at++ = '0';
            *at++ = ',';
        }
        strcpy(at, "0]");
        if (extra == 0)
            expect_read(text);
        else
            expect_exceeded(text, VOR_JSON_TOKENS_MAX, VOR_JSON_TOKENS_MAX + 1, "tokens");
    }
}

VT_TEST(the_size_ends_at_its_limit)
{
    char *text = malloc(VOR_JSON_SIZE_MAX + 2);

    memset(text, ' ', VOR_JSON_SIZE_MAX + 1);
    text[0] = '1';
    text[VOR_JSON_SIZE_MAX] = '\0';
    vor_json_free(vt_json(text));
    text[VOR_JSON_SIZE_MAX] = ' ';
    text[VOR_JSON_SIZE_MAX + 1] = '\0';
    expect_exceeded(text, VOR_JSON_SIZE_MAX, VOR_JSON_SIZE_MAX + 1, "bytes");
}

VT_TEST(a_long_number_ends_at_its_limit)
{
    char text[80];
    double value = 0;
    struct vor_json *json;

    memset(text, '3', sizeof text);
    text[1] = '.';
    text[63] = '\0';
    json = vt_json(text);
    ck_assert(vor_json_get_number(json, &value));
    ck_assert_double_eq_tol(value, 10.0 / 3, 1e-15);
    vor_json_free(json);
    text[63] = '3';
    text[64] = '\0';
    expect_exceeded(strdup(text), 63, 64, "number");
}

VT_TEST(every_kind_is_read)
{
    struct vor_json *json = vt_json(" {\"o\":{\"x\":-1.5e2},\"a\":[1,\"two\",null],\"t\":true,"
                                    "\"f\":false,\"n\":null,\"s\":\"\\u00fc\\ud83d\\ude00\\/\"} ");
    const struct vor_json *a = vor_json_get(json, "a");
    double number = 0;

    ck_assert_int_eq(vor_json_kind(json), VOR_JSON_OBJECT);
    ck_assert_uint_eq(vt_json_count(json), 6);
    ck_assert_str_eq(vor_json_name(vor_json_first(json)), "o");
    ck_assert(vor_json_get_number(vor_json_get(vor_json_get(json, "o"), "x"), &number));
    ck_assert_double_eq(number, -150);
    ck_assert_int_eq(vor_json_kind(a), VOR_JSON_ARRAY);
    ck_assert_uint_eq(vt_json_count(a), 3);
    ck_assert_str_eq(vor_json_get_string(vor_json_next(vor_json_first(a))), "two");
    ck_assert_int_eq(vor_json_kind(vor_json_next(vor_json_next(vor_json_first(a)))), VOR_JSON_NULL);
    ck_assert_int_eq(vor_json_kind(vor_json_get(json, "f")), VOR_JSON_BOOL);
    ck_assert_str_eq(vor_json_get_string(vor_json_get(json, "s")), "\xc3\xbc\xf0\x9f\x98\x80/");
    vor_json_free(json);
}

VT_TEST(names_are_compared_with_their_case)
{
    struct vor_json *json = vt_json("{\"Points\":1,\"points\":2}");
    double value = 0;

    ck_assert_ptr_null(vor_json_get(json, "POINTS"));
    ck_assert(vor_json_get_number(vor_json_get(json, "points"), &value) && value == 2);
    vor_json_free(json);
}

VT_TEST(getters_of_the_wrong_kind_yield_nothing)
{
    struct vor_json *json = vt_json("[1,\"a\",true]");
    const struct vor_json *number = vor_json_first(json), *string = vor_json_next(number);
    double value;

    ck_assert_ptr_null(vor_json_get(json, "a"));
    ck_assert_ptr_null(vor_json_get(NULL, "a"));
    ck_assert_ptr_null(vor_json_get_string(number));
    ck_assert(!vor_json_get_number(string, &value));
    ck_assert(!vor_json_get_number(vor_json_next(string), &value));
    ck_assert(!vor_json_get_number(NULL, &value));
    ck_assert_ptr_null(vor_json_get_string(NULL));
    ck_assert_ptr_null(vor_json_first(number));
    ck_assert_ptr_null(vor_json_first(string));
    ck_assert_ptr_null(vor_json_name(number));
    ck_assert_uint_eq(vt_json_count(string), 0);
    vor_json_free(json);
}

VT_TEST(a_text_needs_no_nul_behind_it)
{
    struct vor_json *json = NULL;
    char *exact = malloc(4); /* a heap block of its own: reading past it is seen by ASan */
    double value = 0;

    memcpy(exact, "1234", 4);
    vt_assert_ok(vor_json_parse(&json, exact, 4, &vt_err));
    ck_assert(vor_json_get_number(json, &value));
    ck_assert_double_eq(value, 1234);
    vor_json_free(json);
    free(exact);
}
