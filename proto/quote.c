#include "proto/quote.h"

#include <assert.h>
#include <stdint.h>
#include <string.h>

const char *vor_quote(char *out, size_t size, const void *bytes, size_t length)
{
    static const char hex[] = "0123456789abcdef";
    const uint8_t *from = bytes;
    size_t at = 0;

    assert(size >= 8);
    for (size_t i = 0; i < length; i++) {
        int plain = from[i] >= 0x20 && from[i] < 0x7f && from[i] != '"' && from[i] != '\\';

        if (at + (plain ? 1 : 4) + (i + 1 < length ? 3 : 0) >= size) {
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
