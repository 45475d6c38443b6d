/* Oracle: our reader of decimal numbers against strtod and strtof, which round correctly. */
#include "proto/ply/ply_number.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 10, TRIES = 4000 };

static enum vor_ply_number read_text(const char *text, enum vor_type type, void *out)
{
    return vor_ply_number_read((const uint8_t *)text, strlen(text), type, out);
}

static void assert_like_strtod(const char *text)
{
    double want = strtod(text, NULL), got = 7;
    float want_single = strtof(text, NULL), got_single = 7;
    enum vor_ply_number status = read_text(text, VOR_FLOAT64, &got);

    if (isfinite(want)) {
        ck_assert_msg(status == VOR_PLY_NUMBER_OK, "%s is refused", text);
        ck_assert_msg(memcmp(&got, &want, sizeof got) == 0, "%s is %a, want %a", text, got, want);
    } else {
        ck_assert_msg(status == VOR_PLY_NUMBER_RANGE, "%s is taken for a double", text);
    }
    status = read_text(text, VOR_FLOAT32, &got_single);
    if (isfinite(want_single)) {
        ck_assert_msg(status == VOR_PLY_NUMBER_OK, "%s is refused as a float", text);
        ck_assert_msg(memcmp(&got_single, &want_single, sizeof got_single) == 0,
                      "%s is %a as a float, want %a", text, (double)got_single,
                      (double)want_single);
    } else {
        ck_assert_msg(status == VOR_PLY_NUMBER_RANGE, "%s is taken for a float", text);
    }
}

/* Digits, a point somewhere, perhaps a sign and an exponent. */
static void random_number(char *text, uint64_t seed, uint64_t index)
{
    uint64_t digits = 1 + vor_rng_below(seed, 1, index, 25);
    uint64_t point = vor_rng_below(seed, 2, index, digits + 2);
    size_t at = 0;

    if (vor_rng_below(seed, 3, index, 2) == 0)
        text[at++] = "+-"[vor_rng_below(seed, 4, index, 2)];
    for (uint64_t i = 0; i < digits; i++) {
        if (i == point)
            text[at++] = '.';
        text[at++] = (char)('0' + vor_rng_below(seed, 5, index * 64 + i, 10));
    }
    text[at] = '\0';
    if (vor_rng_below(seed, 6, index, 2) == 0)
        (void)sprintf(text + at, "%c%+d", "eE"[vor_rng_below(seed, 7, index, 2)],
                      (int)vor_rng_below(seed, 8, index, index % 3 == 0 ? 800 : 60) -
                          (index % 3 == 0 ? 400 : 30));
}

VT_TEST_LOOP(random_decimals_are_rounded_as_the_library_rounds_them, SEEDS)
{
    char text[64];

    for (uint64_t i = 0; i < TRIES; i++) {
        random_number(text, (uint64_t)_i + 1, i);
        assert_like_strtod(text);
    }
}

/* Every finite bit pattern comes back from the shortest and from longer ways to print it. */
VT_TEST_LOOP(printed_bit_patterns_come_back, SEEDS)
{
    char text[VOR_PLY_NUMBER_MAX + 1];

    for (uint64_t i = 0; i < TRIES; i++) {
        uint64_t bits = vor_rng_bits((uint64_t)_i + 1, 9, i);
        uint32_t low = (uint32_t)bits;
        double wide;
        float single;

        memcpy(&wide, &bits, sizeof wide);
        memcpy(&single, &low, sizeof single);
        if (!isfinite(wide) || !isfinite(single))
            continue;
        (void)snprintf(text, sizeof text, "%.*g", 15 + (int)(i % 10), wide);
        assert_like_strtod(text);
        (void)snprintf(text, sizeof text, "%.*g", 6 + (int)(i % 30), (double)single);
        assert_like_strtod(text);
    }
}

/* Half-way between two floats, and a hair to either side: where rounding twice goes wrong. */
VT_TEST_LOOP(half_way_cases_are_rounded_once, SEEDS)
{
    char text[VOR_PLY_NUMBER_MAX + 1];

    for (uint64_t i = 0; i < TRIES; i++) {
        float single = (float)(1 + (double)vor_rng_below((uint64_t)_i, 10, i, 1 << 23) * 0x1p-23);
        double half = ((double)single + (double)nextafterf(single, 3)) / 2;
        size_t length;

        (void)snprintf(text, sizeof text, "%.30f", half); /* exact: 24 binary places */
        assert_like_strtod(text);
        length = strlen(text);
        text[length - 1] = '1';
        assert_like_strtod(text);
        (void)snprintf(text, sizeof text, "%.17g", nextafter(half, 0));
        assert_like_strtod(text);
        (void)snprintf(text, sizeof text, "%.16g", half); /* beside it, but not by half a double */
        assert_like_strtod(text);
        (void)snprintf(text, sizeof text, "%.25f", half);
        text[strlen(text) - 1] = '9';
        assert_like_strtod(text);
    }
}

VT_TEST(edges_of_the_range_are_rounded_as_the_library_rounds_them)
{
    static const char texts[] =
        "0 -0 0.0 -0e-999 0e99999999999999999999 1e-99999999999999999999 1e308 "
        "1.7976931348623157e308 1.7976931348623158e308 1.7976931348623159e308 "
        "179769313486231570000000000000000000000e270 4.9e-324 2.4703282292062327e-324 "
        "2.4703282292062328e-324 2.2250738585072011e-308 2.2250738585072014e-308 "
        "3.4028234663852886e38 3.4028235677973366e38 3.4028235677973365e38 1.17549435e-38 "
        "1.1754942e-38 1.4e-45 7.006492321624085e-46 7.006492321624086e-46 9007199254740992 "
        "9007199254740993 9007199254740993.0000000000000000000000001 18446744073709551615 "
        "18446744073709551616 1e22 1e23 9007199254740992e22 9007199254740991e-22 16777217 "
        "16777217.0000001 16777219 33554435e22 .5 5. +.5e-0 "
        "00000000000000000000000000000000000000000000001.5 "
        "0.00000000000000000000000000000000000000000000000000000000001 8388608.5000000001 "
        "8388609.5 1e-46";
    char all[sizeof texts], *rest = all, *word;

    memcpy(all, texts, sizeof all);
    while ((word = strsep(&rest, " ")) != NULL)
        assert_like_strtod(word);
}

VT_TEST(a_number_has_127_bytes_and_not_128)
{
    char text[VOR_PLY_NUMBER_MAX + 2];
    double out;

    memset(text, '1', sizeof text);
    text[1] = '.';
    text[VOR_PLY_NUMBER_MAX] = '\0';
    assert_like_strtod(text);
    text[VOR_PLY_NUMBER_MAX] = '1';
    text[VOR_PLY_NUMBER_MAX + 1] = '\0';
    ck_assert_int_eq(read_text(text, VOR_FLOAT64, &out), VOR_PLY_NUMBER_JUNK);
    ck_assert_int_eq(read_text("", VOR_FLOAT64, &out), VOR_PLY_NUMBER_JUNK);
    ck_assert_int_eq(read_text("", VOR_INT8, &out), VOR_PLY_NUMBER_JUNK);
}

/* Oracle: junk is what strtod does not take whole, or takes as what PLY does not mean. */
VT_TEST_LOOP(mutated_numbers_are_taken_only_when_they_are_decimals, SEEDS)
{
    static const char alphabet[] = "0123456789+-.eE xXnNaAiIfFpP,_\t\x80";

    for (uint64_t i = 0; i < TRIES; i++) {
        uint64_t length = 1 + vor_rng_below((uint64_t)_i, 11, i, 7);
        char text[16], *end;
        double value, want;
        enum vor_ply_number status;

        for (uint64_t k = 0; k < length; k++)
            text[k] = alphabet[vor_rng_below((uint64_t)_i, 12, i * 8 + k, sizeof alphabet - 1)];
        text[length] = '\0';
        status = read_text(text, VOR_FLOAT64, &value);
        want = strtod(text, &end);
        if (text[strspn(text, "0123456789+-.eE")] == '\0' && *end == '\0')
            ck_assert_msg(isfinite(want) ? status == VOR_PLY_NUMBER_OK && value == want
                                         : status == VOR_PLY_NUMBER_RANGE,
                          "%s is not taken", text);
        else if (status != VOR_PLY_NUMBER_NONFINITE)
            ck_assert_msg(status == VOR_PLY_NUMBER_JUNK, "%s is taken", text);
        else
            ck_assert_msg(!isfinite(want) && *end == '\0', "%s is nan or inf", text);
    }
}

VT_TEST(whole_numbers_meet_the_range_of_their_type)
{
    static const int64_t low[] = {INT8_MIN, 0, INT16_MIN, 0, INT32_MIN, 0};
    static const int64_t high[] = {INT8_MAX,   UINT8_MAX, INT16_MAX,
                                   UINT16_MAX, INT32_MAX, UINT32_MAX};
    char text[32];

    for (unsigned t = 0; t < 6; t++)
        for (int64_t d = -3; d <= 3; d++) {
            enum vor_type type = (enum vor_type)(VOR_INT8 + t);
            int64_t near[2] = {low[t] + d, high[t] + d};

            for (int e = 0; e < 2; e++) {
                int64_t got = 0; /* little-endian: the low bytes are set */
                int inside = near[e] >= low[t] && near[e] <= high[t];

                (void)snprintf(text, sizeof text, "%lld", (long long)near[e]);
                ck_assert_int_eq(read_text(text, type, &got),
                                 inside ? VOR_PLY_NUMBER_OK : VOR_PLY_NUMBER_RANGE);
                if (inside)
                    ck_assert_mem_eq(&got, &near[e], vor_type_size(type));
            }
        }
}

VT_TEST(whole_numbers_of_64_bits_meet_their_range)
{
    int64_t s = 0;
    uint64_t u = 0;

    ck_assert_int_eq(read_text("-9223372036854775808", VOR_INT64, &s), VOR_PLY_NUMBER_OK);
    ck_assert(s == INT64_MIN);
    ck_assert_int_eq(read_text("9223372036854775807", VOR_INT64, &s), VOR_PLY_NUMBER_OK);
    ck_assert(s == INT64_MAX);
    ck_assert_int_eq(read_text("9223372036854775808", VOR_INT64, &s), VOR_PLY_NUMBER_RANGE);
    ck_assert_int_eq(read_text("-9223372036854775809", VOR_INT64, &s), VOR_PLY_NUMBER_RANGE);
    ck_assert_int_eq(read_text("18446744073709551615", VOR_UINT64, &u), VOR_PLY_NUMBER_OK);
    ck_assert(u == UINT64_MAX);
    ck_assert_int_eq(read_text("18446744073709551616", VOR_UINT64, &u), VOR_PLY_NUMBER_RANGE);
    ck_assert_int_eq(read_text("-1", VOR_UINT64, &u), VOR_PLY_NUMBER_RANGE);
}
