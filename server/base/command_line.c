#include "server/base/command_line.h"

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
