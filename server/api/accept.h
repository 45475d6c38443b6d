/** What a caller takes, by its Accept headers. */
#ifndef VOR_SERVER_API_ACCEPT_H
#define VOR_SERVER_API_ACCEPT_H

#include "server/http/http.h"

#include <stdbool.h>

/** True when an Accept header names this media type, or none was sent and `absent` is true. Ranges
 *  with a star do not count. */
bool vor_accepts(const struct vor_request *request, const char *media_type, bool absent);

/** A walk over the ranges of all Accept headers; all zero at its beginning. */
struct vor_accept_walk {
    unsigned index;
    const char *at; /**< rest of the header at hand; NULL before the first */
};

/** One range: a media type, with stars or without; "" for one that is no such thing. */
struct vor_accept_range {
    char type[80];
    double quality; /**< its q; 1 when it has none */
};

/** The next range of the headers; false past the last. */
bool vor_accept_next(const struct vor_request *request, struct vor_accept_walk *walk,
                     struct vor_accept_range *out);

/** True when the headers leave room for bytes of this media type: none was sent, or the range that
 *  matches it most closely has a q above 0. Every media type that is in use for a format of clouds
 *  stands for all of them, and so does application/octet-stream, less closely. */
bool vor_accept_takes(const struct vor_request *request, const char *media_type);

#endif
