#include "server/base/span.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>

enum { TRACE_DIGITS = VOR_TRACE_ID_SIZE - 1, SPAN_DIGITS = VOR_SPAN_ID_SIZE - 1 };

static const char digits[] = "0123456789abcdef";

/* Copies `size` digits; false when there are others, or only zeros where these are refused. */
static int take(char *out, const char *text, size_t size, int may_be_zero)
{
    if (strspn(text, digits) < size || (!may_be_zero && strspn(text, "0") >= size))
        return 0;
    memcpy(out, text, size);
    out[size] = '\0';
    return 1;
}

/* "00-" 32 digits "-" 16 digits "-" 2 digits. */
int vor_span_parse(struct vor_span *out, const char *text)
{
    char version[3];

    if (strlen(text) >= VOR_TRACEPARENT_SIZE - 1 && take(version, text, 2, 1) &&
        strcmp(version, "ff") != 0 && text[2] == '-' &&
        take(out->trace, text + 3, TRACE_DIGITS, 0) && text[35] == '-' &&
        take(out->id, text + 36, SPAN_DIGITS, 0) && text[52] == '-' &&
        take(out->flags, text + 53, 2, 1) &&
        (text[55] == '\0' || (strcmp(version, "00") != 0 && text[55] == '-')))
        return 1;
    memset(out, 0, sizeof *out);
    return 0;
}

void vor_span_begin(struct vor_span *out, const struct vor_span *of)
{
    uint64_t number = 0;

    if (of->trace[0] == '\0' || getrandom(&number, sizeof number, GRND_NONBLOCK) != sizeof number) {
        memset(out, 0, sizeof *out);
        return;
    }
    *out = *of;
    (void)snprintf(out->id, sizeof out->id, "%016llx", (unsigned long long)(number | 1));
}

const char *vor_span_text(const struct vor_span *span, char out[VOR_TRACEPARENT_SIZE])
{
    out[0] = '\0';
    if (span->trace[0] != '\0')
        (void)snprintf(out, VOR_TRACEPARENT_SIZE, "00-%s-%s-%s", span->trace, span->id,
                       span->flags);
    return out;
}
