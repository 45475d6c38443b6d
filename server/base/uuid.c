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

vor_status vor_uuid_make(struct vor_uuid *out, struct vor_error *err)
{
    uint64_t now = (uint64_t)vor_clock_wall_ms();
    uint8_t bytes[16];
    ssize_t got;
    size_t at = 0;

    do
        got = getrandom(bytes + 6, 10, 0);
    while (got < 0 && errno == EINTR);
    if (got != 10)
        return vor_fail_errno(err, errno, "random numbers");
    for (int i = 0; i < 6; i++)
        bytes[i] = (uint8_t)(now >> (40 - 8 * i));
    bytes[6] = (uint8_t)((bytes[6] & 0x0f) | 0x70); /* version 7 */
    bytes[8] = (uint8_t)((bytes[8] & 0x3f) | 0x80); /* variant of RFC 9562 */
    for (int i = 0; i < 16; i++) {
        if (is_dash(at))
            out->text[at++] = '-';
        out->text[at++] = digits[bytes[i] >> 4];
        out->text[at++] = digits[bytes[i] & 15];
    }
    out->text[at] = '\0';
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
