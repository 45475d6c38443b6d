#include "server/base/base64.h"

#include <string.h>

enum { BITS = 6, MASK = 63 };

static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

void vor_base64_write(const uint8_t *bytes, size_t size, char *out)
{
    unsigned held = 0, bits = 0;

    for (size_t i = 0; i < size; i++) {
        held = held << 8 | bytes[i];
        for (bits += 8; bits >= BITS; bits -= BITS)
            *out++ = digits[held >> (bits - BITS) & MASK];
        held &= (1u << bits) - 1;
    }
    if (bits > 0)
        *out++ = digits[held << (BITS - bits) & MASK];
    *out = '\0';
}

long vor_base64_read(const char *text, uint8_t *out, size_t max)
{
    unsigned held = 0, bits = 0;
    size_t size = 0;

    for (; *text != '\0'; text++) {
        const char *digit = strchr(digits, *text);

        if (digit == NULL)
            return -1;
        held = held << BITS | (unsigned)(digit - digits);
        bits += BITS;
        if (bits < 8)
            continue;
        if (size == max)
            return -1;
        bits -= 8;
        out[size++] = (uint8_t)(held >> bits);
        held &= (1u << bits) - 1;
    }
    return bits < BITS && held == 0 ? (long)size : -1;
}
