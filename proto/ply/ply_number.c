/* Most numbers have at most 15 digits and a small exponent: then digits and power of ten are both
 * exact doubles and one multiplication or division rounds correctly (Clinger 1990, "How to read
 * floating point numbers accurately"). The rest goes to strtod, which rounds correctly too. */
#include "proto/ply/ply_number.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(FLT_EVAL_METHOD == 0, "a double product must be rounded once, to double");

struct decimal {
    int negative;
    int cut; /* the digits do not fit into mantissa */
    uint64_t mantissa;
    int exponent; /* value = mantissa * 10^exponent */
};

static int is_digit(uint8_t c)
{
    return c >= '0' && c <= '9';
}

/* Digits at *at; mantissa takes those that fit. Returns how many there are. */
static size_t take_digits(const uint8_t **at, const uint8_t *end, struct decimal *decimal)
{
    const uint8_t *begin = *at;

    for (; *at < end && is_digit(**at); ++*at) {
        if (decimal->mantissa > (UINT64_MAX - 9) / 10)
            decimal->cut = 1;
        else
            decimal->mantissa = decimal->mantissa * 10 + (uint64_t)(**at - '0');
    }
    return (size_t)(*at - begin);
}

/* What follows an e. The bound keeps the sum with the number of digits clear of overflow. */
static int take_exponent(const uint8_t **at, const uint8_t *end, int *exponent)
{
    int negative = *at < end && **at == '-';
    int value = 0;

    if (*at < end && (**at == '-' || **at == '+'))
        ++*at;
    if (*at == end)
        return 0;
    for (; *at < end && is_digit(**at); ++*at)
        if (value < 100000)
            value = value * 10 + (**at - '0');
    *exponent += negative ? -value : value;
    return 1;
}

static int parse_decimal(const uint8_t *token, size_t length, struct decimal *out)
{
    const uint8_t *at = token, *end = token + length;
    size_t whole, fraction = 0;

    memset(out, 0, sizeof *out);
    out->negative = *at == '-';
    if (*at == '-' || *at == '+')
        at++;
    whole = take_digits(&at, end, out);
    if (at < end && *at == '.') {
        at++;
        fraction = take_digits(&at, end, out);
        out->exponent = -(int)fraction;
    }
    if (whole + fraction == 0)
        return 0;
    if (at < end && (*at == 'e' || *at == 'E')) {
        at++;
        if (!take_exponent(&at, end, &out->exponent))
            return 0;
    }
    return at == end;
}

/* True when value is the correctly rounded one. */
static int fast_double(const struct decimal *decimal, double *value)
{
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                    1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    int e = decimal->exponent;

    if (decimal->cut || decimal->mantissa > (UINT64_C(1) << 53) || e < -22 || e > 22)
        return 0;
    *value = (double)decimal->mantissa;
    *value = e < 0 ? *value / powers[-e] : *value * powers[e];
    if (decimal->negative)
        *value = -*value;
    return 1;
}

/* Rounding to double and then to float is right unless the double lies half-way between two floats:
 * then it may have been moved there. Below FLT_MIN half-way looks different. */
static int fast_float(double value, float *out)
{
    uint64_t bits;

    memcpy(&bits, &value, sizeof bits);
    if ((bits & UINT64_C(0x1fffffff)) == UINT64_C(0x10000000) ||
        (fabs(value) < (double)FLT_MIN && value != 0))
        return 0;
    *out = (float)value;
    return 1;
}

static int same_word(const uint8_t *at, size_t length, const char *word)
{
    size_t i = 0;

    while (i < length && word[i] != '\0' && (at[i] | 0x20) == word[i])
        i++;
    return i == length && word[i] == '\0';
}

static int begins(const uint8_t *at, size_t length, const char *word)
{
    size_t size = strlen(word);

    return length >= size && same_word(at, size, word);
}

/* nan, inf and infinity in any case, with a sign; nan(...) as C prints it, "nan(ind)" among them;
 * and what Microsoft's C library printed before: 1.#INF, and 1.#QNAN, 1.#SNAN or 1.#IND, rounded to
 * "1.#J" where there are few decimals, with digits behind where there are many. */
static int parse_nonfinite(const uint8_t *token, size_t length, double *out)
{
    int sign = length > 0 && (token[0] == '-' || token[0] == '+');
    const uint8_t *word = token + sign;
    size_t left = length - (size_t)sign;

    if (same_word(word, left, "inf") || same_word(word, left, "infinity") ||
        begins(word, left, "1.#inf"))
        *out = token[0] == '-' ? -INFINITY : INFINITY;
    else if (same_word(word, left, "nan") || begins(word, left, "1.#") ||
             (begins(word, left, "nan(") && word[left - 1] == ')'))
        *out = NAN;
    else
        return 0;
    return 1;
}

static enum vor_ply_number read_real(const uint8_t *token, size_t length, int single, void *out)
{
    struct decimal decimal;
    char text[VOR_PLY_NUMBER_MAX + 1];
    double value = 0;
    float rounded = 0;
    enum vor_ply_number status = VOR_PLY_NUMBER_OK;

    if (parse_decimal(token, length, &decimal)) {
        int fast = fast_double(&decimal, &value) && (!single || fast_float(value, &rounded));

        if (!fast) {
            memcpy(text, token, length);
            text[length] = '\0';
            if (single)
                rounded = strtof(text, NULL);
            else
                value = strtod(text, NULL);
        }
        if (!isfinite(single ? (double)rounded : value))
            return VOR_PLY_NUMBER_RANGE;
    } else if (parse_nonfinite(token, length, &value)) {
        rounded = (float)value;
        status = VOR_PLY_NUMBER_NONFINITE;
    } else {
        return VOR_PLY_NUMBER_JUNK;
    }
    memcpy(out, single ? (void *)&rounded : (void *)&value, single ? sizeof rounded : sizeof value);
    return status;
}

static void store_integer(uint64_t bits, enum vor_type type, void *out)
{
    uint8_t b8 = (uint8_t)bits;
    uint16_t b16 = (uint16_t)bits;
    uint32_t b32 = (uint32_t)bits;

    switch (vor_type_size(type)) {
    case 1:
        memcpy(out, &b8, 1);
        break;
    case 2:
        memcpy(out, &b16, 2);
        break;
    case 4:
        memcpy(out, &b32, 4);
        break;
    default:
        memcpy(out, &bits, 8);
        break;
    }
}

/* Reads a whole number, which may be written as programs print floats: "20.0", "2.0e+01". Fails
 * where a digit behind the point is not 0. *over: it exceeds 64 bits. */
static int parse_whole(const uint8_t *at, const uint8_t *end, uint64_t *value, int *over)
{
    struct decimal decimal;
    const uint8_t *stop = at;
    long before = 0; /* digits before the point, once the exponent has moved it */

    if (!parse_decimal(at, (size_t)(end - at), &decimal))
        return 0;
    for (; stop < end && (is_digit(*stop) || *stop == '.'); stop++)
        before += is_digit(*stop);
    before += decimal.exponent; /* the digits behind the point are taken off it */
    *value = 0;
    *over = 0;
    for (; at < stop; at++) {
        if (*at == '.')
            continue;
        if (before <= 0 && *at != '0')
            return 0;
        if (before-- <= 0)
            continue;
        *over |= __builtin_mul_overflow(*value, 10, value);
        *over |= __builtin_add_overflow(*value, (uint64_t)(*at - '0'), value);
    }
    for (; before > 0 && *value > 0 && !*over; before--)
        *over = __builtin_mul_overflow(*value, 10, value);
    return 1;
}

enum vor_ply_number vor_ply_number_read(const uint8_t *token, size_t length, enum vor_type type,
                                        void *out)
{
    /* The magnitude that a type of integers holds; one more for the negative end. */
    static const uint64_t largest[VOR_TYPE_COUNT] = {
        [VOR_INT8] = INT8_MAX,   [VOR_UINT8] = UINT8_MAX,   [VOR_INT16] = INT16_MAX,
        [VOR_INT32] = INT32_MAX, [VOR_UINT16] = UINT16_MAX, [VOR_UINT32] = UINT32_MAX,
        [VOR_INT64] = INT64_MAX, [VOR_UINT64] = UINT64_MAX};
    int negative, over;
    size_t sign;
    uint64_t value, most;

    if (length == 0 || length > VOR_PLY_NUMBER_MAX)
        return VOR_PLY_NUMBER_JUNK;
    if (type == VOR_FLOAT32 || type == VOR_FLOAT64)
        return read_real(token, length, type == VOR_FLOAT32, out);
    negative = token[0] == '-';
    sign = token[0] == '-' || token[0] == '+';
    most = largest[type];
    if (sign == length || token[sign] == '-' || token[sign] == '+' ||
        !parse_whole(token + sign, token + length, &value, &over))
        return VOR_PLY_NUMBER_JUNK;
    if (negative)
        most = type == VOR_INT8 || type == VOR_INT16 || type == VOR_INT32 || type == VOR_INT64
                   ? most + 1
                   : 0;
    if (over || value > most)
        return VOR_PLY_NUMBER_RANGE;
    store_integer(negative ? 0 - value : value, type, out); /* two's complement */
    return VOR_PLY_NUMBER_OK;
}
