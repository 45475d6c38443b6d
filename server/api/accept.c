#include "server/api/accept.h"

#include "proto/codec.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* The q of a media range's parameters; 1 when there is none. */
static double quality_of(const char *range, size_t length)
{
    for (size_t i = 0; i + 2 < length; i++) {
        if (range[i] != ';')
            continue;
        i += 1 + strspn(range + i + 1, " \t");
        if (i + 1 < length && (range[i] == 'q' || range[i] == 'Q') && range[i + 1] == '=')
            return strtod(range + i + 2, NULL);
    }
    return 1;
}

bool vor_accept_next(const struct vor_request *request, struct vor_accept_walk *walk,
                     struct vor_accept_range *out)
{
    size_t length, word;

    if (walk->at != NULL)
        walk->at += strspn(walk->at, ", \t");
    while (walk->at == NULL || *walk->at == '\0') {
        walk->at = vor_request_header_next(request, walk->header != NULL ? walk->header : "Accept",
                                           &walk->index);
        if (walk->at == NULL)
            return false;
        walk->at += strspn(walk->at, ", \t");
    }
    length = strcspn(walk->at, ",");
    word = strcspn(walk->at, ";, \t");
    out->quality = quality_of(walk->at, length);
    (void)snprintf(out->type, sizeof out->type, "%.*s", word < sizeof out->type ? (int)word : 0,
                   walk->at);
    walk->at += length;
    return true;
}

/* How closely a range matches a media type; 0: not at all. */
static int closeness(const char *range, const char *media_type)
{
    const struct vor_format *format = vor_format_by_media_type(media_type);
    size_t main_type = strcspn(media_type, "/") + 1;

    if (strcasecmp(range, media_type) == 0 ||
        (format != NULL && vor_format_by_media_type(range) == format))
        return 4;
    if (format != NULL && strcasecmp(range, "application/octet-stream") == 0)
        return 3;
    if ((strncasecmp(range, media_type, main_type) == 0 && strcmp(range + main_type, "*") == 0) ||
        (format != NULL && strcasecmp(range, "model/*") == 0))
        return 2;
    return strcmp(range, "*/*") == 0;
}

bool vor_accept_takes(const struct vor_request *request, const char *media_type)
{
    struct vor_accept_walk walk = {NULL};
    struct vor_accept_range range;
    bool given = false;
    double quality = 0;
    int closest = 0;

    while (vor_accept_next(request, &walk, &range)) {
        int fit = closeness(range.type, media_type);

        given = true;
        if (fit == 0 || fit < closest || (fit == closest && range.quality <= quality))
            continue;
        closest = fit;
        quality = range.quality;
    }
    return !given || quality > 0;
}

double vor_accept_named(const struct vor_request *request, const char *media_type)
{
    struct vor_accept_walk walk = {NULL};
    struct vor_accept_range range;
    double quality = 0;

    while (vor_accept_next(request, &walk, &range))
        if (strcasecmp(range.type, media_type) == 0 && range.quality > quality)
            quality = range.quality;
    return quality;
}

bool vor_accepts(const struct vor_request *request, const char *media_type)
{
    return vor_accept_named(request, media_type) > 0;
}
