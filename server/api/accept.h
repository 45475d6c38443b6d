/** What a caller takes, by its headers Accept and Accept-Encoding. */
#ifndef VOR_SERVER_API_ACCEPT_H
#define VOR_SERVER_API_ACCEPT_H

#include "server/http/http.h"

#include <stdbool.h>

/** A walk over the ranges of all headers of a name; all zero but for that at its beginning. */
struct vor_accept_walk {
    const char *header; /**< NULL: Accept */
    unsigned index;
    const char *at; /**< rest of the header at hand; NULL before the first */
};

/** One range: a media type, with stars or without, or a coding; "" for one that is no such thing.
 */
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

/** The q that the headers give this very media type, the highest if it is there twice; 0 when it is
 *  not named, or is refused (q=0). Ranges with a star do not count. */
double vor_accept_named(const struct vor_request *request, const char *media_type);

/** True when the headers name this very media type with a q above 0. */
bool vor_accepts(const struct vor_request *request, const char *media_type);

#endif
