#include "server/base/option.h"

#include "core/base/nearest.h"
#include "core/base/quote.h"
#include "core/spec/decimal.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    SHOWN_SIZE = 64, /* of what a caller wrote, in a message */
    NAMES_SIZE = 512 /* of the names that an ambiguous one may stand for */
};

const char *vor_option_value(const struct vor_option_row *info)
{
    static const char *const values[] = {
        [VOR_TYPE_COUNT_OF] = "N", [VOR_TYPE_BYTES] = "BYTES", [VOR_TYPE_TIME] = "SECONDS",
        [VOR_TYPE_FLAG] = "",      [VOR_TYPE_CHOICE] = "WORD",
    };

    return info->type == VOR_TYPE_TEXT || info->type == VOR_TYPE_LIST ? info->unit
                                                                      : values[info->type];
}

const char *vor_option_range(const struct vor_option_row *info, char out[VOR_OPTION_RANGE_SIZE])
{
    int at = 0;

    out[0] = '\0';
    if (info->type == VOR_TYPE_CHOICE)
        at = snprintf(out, VOR_OPTION_RANGE_SIZE, "one of %s", info->unit);
    else if (info->type != VOR_TYPE_FLAG && info->max > 0)
        at = snprintf(out, VOR_OPTION_RANGE_SIZE, "%.10g to %.10g %s%s", info->min, info->max,
                      info->unit, info->type == VOR_TYPE_BYTES ? ", or with K, M, G or T" : "");
    if (info->fallback[0] != '\0' && info->type != VOR_TYPE_FLAG)
        (void)snprintf(out + at, VOR_OPTION_RANGE_SIZE - (size_t)at, "%sdefault %s",
                       at > 0 ? ", " : "", info->fallback);
    return out;
}

vor_status vor_option_read(double *out, const struct vor_option_row *info, const char *text,
                           struct vor_error *err)
{
    double number = vor_number_read(text, strlen(text), info->type == VOR_TYPE_BYTES);
    const char *word = info->unit;
    char shown[SHOWN_SIZE];

    vor_quote(shown, sizeof shown, text, strlen(text));
    if (info->type == VOR_TYPE_CHOICE) {
        for (int i = 0; *word != '\0'; i++) {
            size_t length = strcspn(word, " ");

            if (strlen(text) == length && memcmp(word, text, length) == 0) {
                *out = i;
                return VOR_OK;
            }
            word += length + (word[length] == ' ');
        }
        return vor_fail_param(err, VOR_E_PARAM, info->name, "--%s is \"%s\", want one of %s",
                              info->name, shown, info->unit);
    }
    if (!(number >= info->min && number <= info->max) ||
        (info->type != VOR_TYPE_TIME && number != rint(number)))
        return vor_fail_param(err, VOR_E_PARAM, info->name,
                              "--%s is \"%s\", want %s from %.10g to %.10g", info->name, shown,
                              info->type == VOR_TYPE_TIME    ? "seconds"
                              : info->type == VOR_TYPE_BYTES ? "bytes (K, M, G, T)"
                                                             : "a whole number",
                              info->min, info->max);
    *out = number;
    return VOR_OK;
}

double vor_number_read(const char *text, size_t length, int may_scale)
{
    static const char suffixes[] = "KMGT";
    const char *suffix = NULL;
    double number;

    if (may_scale && length > 0)
        suffix = memchr(suffixes, toupper((unsigned char)text[length - 1]), sizeof suffixes - 1);
    if (length == 0 || text[0] == '+' || text[0] == '-' ||
        !vor_decimal_read(&number, text, length - (suffix != NULL)))
        return NAN;
    return suffix != NULL ? ldexp(number, 10 * (int)(suffix - suffixes + 1)) : number;
}

char *vor_trim(char *text)
{
    static const char blanks[] = " \t\r\n";
    size_t size;

    text += strspn(text, blanks);
    size = strlen(text);
    while (size > 0 && strchr(blanks, text[size - 1]) != NULL)
        size--;
    text[size] = '\0';
    return text;
}

int vor_whole_read(unsigned *out, const char *text, unsigned least, unsigned most)
{
    double number;

    if (text[strspn(text, "0123456789")] != '\0' ||
        !vor_decimal_read(&number, text, strlen(text)) || number < least || number > most)
        return 0;
    *out = (unsigned)number;
    return 1;
}

vor_status vor_option_refuse(const struct option *longs, const char *word, const char *command,
                             struct vor_error *err)
{
    const char *name = word + strspn(word, "-");
    size_t length = strcspn(name, "="), at = 0;
    char shown[SHOWN_SIZE], names[NAMES_SIZE], meant[VOR_NEAREST_TEXT_SIZE];
    struct vor_nearest nearest;
    int found = 0;

    vor_quote(shown, sizeof shown, word, (size_t)(name - word) + length);
    vor_nearest_init(&nearest, name, name - word == 2 ? length : 0);
    for (const struct option *o = longs; o->name != NULL; o++) {
        int is_same = o > longs && o->val == o[-1].val;

        if (!is_same)
            vor_nearest_try(&nearest, o->name, strlen(o->name));
        if (strncmp(o->name, name, length) != 0 || (is_same && found > 0))
            continue;
        if (at < sizeof names)
            at += (size_t)snprintf(names + at, sizeof names - at, "%s--%s", found > 0 ? " or " : "",
                                   o->name);
        found++;
    }
    if (name - word == 2 && length > 0 && found > 1)
        return vor_fail(err, VOR_E_PARAM, "%s is ambiguous, want %s", shown, names);
    if (nearest.count > 0)
        return vor_fail(err, VOR_E_PARAM, "no option %s%s", shown,
                        vor_nearest_text(&nearest, "--", meant));
    return vor_fail(err, VOR_E_PARAM, "no option %s; see voronoid %s --help", shown, command);
}
