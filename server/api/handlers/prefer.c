#include "server/api/handlers/handlers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double wait_max = 86400;

void vor_prefer_read(const struct vor_request *request, struct vor_preferences *out)
{
    static const char async[] = "respond-async", early[] = "respond-early", wait[] = "wait=";
    const size_t word = sizeof wait - 1;
    unsigned index = 0;
    const char *value;

    *out = (struct vor_preferences){.wait_seconds = -1};
    while ((value = vor_request_header_next(request, "Prefer", &index)) != NULL)
        for (size_t length; *value != '\0'; value += length) {
            value += strspn(value, ",; \t");
            length = strcspn(value, ",; \t");
            if (length == sizeof async - 1 && strncasecmp(value, async, length) == 0)
                out->is_async = true;
            if (length == sizeof early - 1 && strncasecmp(value, early, length) == 0)
                out->is_early = true;
            if (length > word && length < 12 && strncasecmp(value, wait, word) == 0 &&
                strspn(value + word, "0123456789") == length - word)
                out->wait_seconds = fmin(strtod(value + word, NULL), wait_max);
        }
}
