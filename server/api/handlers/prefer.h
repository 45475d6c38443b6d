/** The preferences of a request (RFC 7240). */
#ifndef VOR_SERVER_API_HANDLERS_PREFER_H
#define VOR_SERVER_API_HANDLERS_PREFER_H

#include "server/http/http.h"

#include <stdbool.h>

struct vor_preferences {
    bool is_async;       /**< respond-async */
    double wait_seconds; /**< wait=N, 0 .. 86400 (more counts as that); -1 for none */
};

/** Reads every Prefer header; preferences that we do not know, or cannot read, do not matter. */
void vor_prefer_read(const struct vor_request *request, struct vor_preferences *out);

#endif
