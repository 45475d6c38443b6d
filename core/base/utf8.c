#include "core/base/utf8.h"

#include <string.h>

size_t vor_utf8_length(const unsigned char *p, size_t left)
{
    unsigned char low = 0x80, high = 0xbf; /* what the second byte may be */
    size_t length;

    if (left == 0 || p[0] < 0x80)
        return left > 0;
    if (p[0] < 0xc2 || p[0] > 0xf4)
        return 0;
    length = p[0] < 0xe0 ? 2 : p[0] < 0xf0 ? 3 : 4;
    if (p[0] == 0xe0)
        low = 0xa0;
    else if (p[0] == 0xed)
        high = 0x9f;
    else if (p[0] == 0xf0)
        low = 0x90;
    else if (p[0] == 0xf4)
        high = 0x8f;
    if (left < length || p[1] < low || p[1] > high)
        return 0;
    for (size_t i = 2; i < length; i++)
        if (p[i] < 0x80 || p[i] > 0xbf)
            return 0;
    return length;
}

long vor_utf8_count(const char *text)
{
    const unsigned char *at = (const unsigned char *)text;
    size_t left = strlen(text);
    long count = 0;

    for (; left > 0; count++) {
        size_t length = vor_utf8_length(at, left);
        int is_c1 = length == 2 && at[0] == 0xc2 && at[1] < 0xa0;

        if (length == 0 || at[0] < 0x20 || at[0] == 0x7f || is_c1)
            return -1;
        at += length;
        left -= length;
    }
    return count;
}

int vor_utf8_is_plain(const char *text, size_t size)
{
    size_t length;

    for (size_t i = 0; i < size; i += length) {
        unsigned char c = (unsigned char)text[i];

        length = vor_utf8_length((const unsigned char *)text + i, size - i);
        if (length == 0 || c < 0x20 || c == 0x7f)
            return 0;
    }
    return 1;
}
