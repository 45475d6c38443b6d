/** What a caller takes, by its Accept headers. */
#ifndef VOR_SERVER_API_ACCEPT_H
#define VOR_SERVER_API_ACCEPT_H

#include "server/http/http.h"

#include <stdbool.h>

/** True when an Accept header names this media type, or none was sent and `absent` is true. Ranges
 *  with a star do not count. */
bool vor_accepts(const struct vor_request *request, const char *media_type, bool absent);

#endif
