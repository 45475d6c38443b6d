#include "server/api/handlers/handlers.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double wait_max = 86400;

/* One preference: a word, with or without a value. */
static void take(struct vor_preferences *out, const char *text, size_t length)
{
    static const char async[] = "respond-async", wait[] = "wait=";
    const size_t word = sizeof wait - 1;

    if (length == sizeof async - 1 && strncasecmp(text, async, length) == 0)
        out->is_async = true;
    if (length > word && length < 12 && strncasecmp(text, wait, word) == 0 &&
        strspn(text + word, "0123456789") == length - word) {
        double seconds = strtod(text + word, NULL);

        out->wait_seconds = seconds < wait_max ? seconds : wait_max;
    }
}

void vor_prefer_read(const struct vor_request *request, struct vor_preferences *out)
{
    unsigned index = 0;
    const char *value;

    *out = (struct vor_preferences){.wait_seconds = -1};
    while ((value = vor_request_header_next(request, "Prefer", &index)) != NULL) {
        while (*value != '\0') {
            size_t length;

            value += strspn(value, ",; \t");
            length = strcspn(value, ",; \t");
            take(out, value, length);
            value += length;
        }
    }
}
