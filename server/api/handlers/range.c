#include "server/api/handlers/range.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Digits at *text, moved behind them; false when there are none or too many. */
static bool take_number(const char **text, uint64_t *out)
{
    size_t length = strspn(*text, "0123456789");

    if (length == 0 || length > 18)
        return false;
    *out = strtoull(*text, NULL, 10);
    *text += length;
    return true;
}

enum vor_range vor_range_parse(const char *text, uint64_t size, uint64_t *offset, uint64_t *length)
{
    uint64_t first = 0, last = UINT64_MAX;
    bool has_first, has_last;

    if (text == NULL || strncasecmp(text, "bytes=", 6) != 0)
        return VOR_RANGE_WHOLE;
    text += 6;
    has_first = take_number(&text, &first);
    if (*text != '-')
        return VOR_RANGE_WHOLE;
    text++;
    has_last = take_number(&text, &last);
    if (*text != '\0' || (!has_first && !has_last) || (has_first && has_last && last < first))
        return VOR_RANGE_WHOLE;
    if (!has_first) {
        if (last == 0 || size == 0)
            return VOR_RANGE_OUTSIDE;
        first = last < size ? size - last : 0;
        last = size - 1;
    }
    if (first >= size)
        return VOR_RANGE_OUTSIDE;
    if (last >= size)
        last = size - 1;
    *offset = first;
    *length = last - first + 1;
    return VOR_RANGE_PART;
}
