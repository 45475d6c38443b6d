#include "core/base/quote.h"

#include <assert.h>
#include <stdint.h>
#include <string.h>

static int is_plain(uint8_t c)
{
    return c >= 0x20 && c < 0x7f && c != '"' && c != '\\';
}

static size_t quoted_length(const uint8_t *bytes, size_t length)
{
    size_t total = 0;

    for (size_t i = 0; i < length; i++)
        total += is_plain(bytes[i]) ? 1 : 4;
    return total;
}

const char *vor_quote(char *out, size_t size, const void *bytes, size_t length)
{
    static const char hex[] = "0123456789abcdef";
    const uint8_t *from = bytes;
    size_t at = 0, reserve = quoted_length(from, length) < size ? 0 : 3;

    assert(size >= 8);
    for (size_t i = 0; i < length; i++) {
        int plain = is_plain(from[i]);

        if (at + (plain ? 1 : 4) + reserve >= size) {
            memcpy(out + at, "...", 3);
            at += 3;
            break;
        }
        if (plain) {
            out[at++] = (char)from[i];
            continue;
        }
        out[at++] = '\\';
        out[at++] = 'x';
        out[at++] = hex[from[i] >> 4];
        out[at++] = hex[from[i] & 15];
    }
    out[at] = '\0';
    return out;
}
