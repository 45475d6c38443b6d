#include "server/base/uuid.h"

#include "server/base/clock.h"
#include "server/base/disk.h"

#include <errno.h>
#include <stdint.h>
#include <string.h>
#include <sys/random.h>

static const char digits[] = "0123456789abcdef";

static int is_dash(size_t at)
{
    return at == 8 || at == 13 || at == 18 || at == 23;
}

vor_status vor_random_fill(void *out, size_t size, struct vor_error *err)
{
    ssize_t got;

    do
        got = getrandom(out, size, 0);
    while (got < 0 && errno == EINTR);
    return got == (ssize_t)size ? VOR_OK : vor_fail_errno(err, errno, "random numbers");
}

void vor_uuid_write(struct vor_uuid *out, const uint8_t bytes[16], unsigned version)
{
    size_t at = 0;

    for (int i = 0; i < 16; i++) {
        unsigned byte = bytes[i];

        if (i == 6)
            byte = (byte & 0x0f) | version << 4;
        else if (i == 8)
            byte = (byte & 0x3f) | 0x80; /* variant */
        if (is_dash(at))
            out->text[at++] = '-';
        out->text[at++] = digits[byte >> 4];
        out->text[at++] = digits[byte & 15];
    }
    out->text[at] = '\0';
}

vor_status vor_uuid_make(struct vor_uuid *out, struct vor_error *err)
{
    uint64_t now = (uint64_t)vor_clock_wall_ms();
    uint8_t bytes[16];

    if (vor_random_fill(bytes + 6, 10, err) != VOR_OK)
        return VOR_E_IO;
    for (int i = 0; i < 6; i++)
        bytes[i] = (uint8_t)(now >> (40 - 8 * i));
    vor_uuid_write(out, bytes, 7);
    return VOR_OK;
}

int vor_uuid_begins(const char *text, size_t length)
{
    if (length == 0 || length >= sizeof((struct vor_uuid *)NULL)->text)
        return 0;
    for (size_t i = 0; i < length; i++)
        if (is_dash(i) ? text[i] != '-' : text[i] == '\0' || strchr(digits, text[i]) == NULL)
            return 0;
    return 1;
}

int vor_uuid_parse(struct vor_uuid *out, const char *text, size_t length)
{
    if (length != sizeof out->text - 1 || !vor_uuid_begins(text, length))
        return 0;
    memcpy(out->text, text, length);
    out->text[length] = '\0';
    return 1;
}
