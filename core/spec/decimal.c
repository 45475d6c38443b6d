#include "core/spec/decimal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Bytes of a number; numbers of a list. */
enum { LENGTH_MAX = 40, COUNTS_MAX = 256 };

/* strtod would take more than a decimal number: only digits, sign, point and exponent reach it, and
 * only in the C locale that a program starts with. */
int vor_decimal_read(double *out, const char *text, size_t length)
{
    char copy[LENGTH_MAX + 1], *end;
    double number;

    if (length == 0 || length > LENGTH_MAX)
        return 0;
    memcpy(copy, text, length);
    copy[length] = '\0';
    if (copy[strspn(copy, "+-.0123456789eE")] != '\0' || strpbrk(copy, "0123456789") == NULL)
        return 0;
    number = strtod(copy, &end);
    if (end != copy + length)
        return 0;
    *out = number;
    return 1;
}

int vor_decimal_read_count(double *out, const char *text)
{
    char expanded[LENGTH_MAX + 1];
    size_t length = strlen(text);
    char last = length > 0 ? text[length - 1] : '\0';

    if (last != 'k' && last != 'K' && last != 'M')
        return vor_decimal_read(out, text, length);
    if (length + 1 > LENGTH_MAX || strpbrk(text, "eE") != NULL)
        return 0;
    (void)snprintf(expanded, sizeof expanded, "%.*se%d", (int)length - 1, text,
                   last == 'M' ? 6 : 3);
    return vor_decimal_read(out, expanded, length + 1);
}

int vor_decimal_read_at(double *out, const char *text, unsigned index)
{
    for (; index > 0; index--) {
        text += strcspn(text, ",");
        if (*text++ != ',')
            return 0;
    }
    return vor_decimal_read(out, text, strcspn(text, ","));
}

int vor_decimal_are_counts(const char *text, double min, double max)
{
    double sorted[COUNTS_MAX] = {0}, number;
    unsigned count = 0, at;

    for (size_t length;; text += length + 1) {
        length = strcspn(text, ",");
        if (count == COUNTS_MAX || !vor_decimal_read(&number, text, length) ||
            number != rint(number) || !(number >= min && number <= max))
            return 0;
        for (at = count++; at > 0 && sorted[at - 1] > number; at--)
            sorted[at] = sorted[at - 1];
        if (at > 0 && sorted[at - 1] == number)
            return 0;
        sorted[at] = number;
        if (text[length] == '\0')
            return 1;
    }
}

int vor_decimal_read_vector(double out[3], const char *text)
{
    double read[3];

    for (int i = 0; i < 3; i++) {
        size_t length = strcspn(text, ",");

        if (!vor_decimal_read(&read[i], text, length))
            return 0;
        text += length;
        if (i < 2 && *text++ != ',')
            return 0;
    }
    if (*text != '\0')
        return 0;
    memcpy(out, read, sizeof read);
    return 1;
}
