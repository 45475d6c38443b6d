/** What a key may have of the daemon: the checks of a request for a job. They hold for keys alone;
 *  a caller who needs none has no bounds of his own. */
#ifndef VOR_SERVER_API_LIMITS_H
#define VOR_SERVER_API_LIMITS_H

#include "server/api/app.h"

/** Counts a request against the rate of its key, and tells it of that in heads of the answer: which
 *  one holds, how many more requests pass at once, and in how many seconds that is as it was
 *  (RateLimit-Policy, RateLimit; draft-ietf-httpapi-ratelimit-headers-10). Only Retry-After is a
 *  promise.
 *
 *  @return true, or false after a rate-limited problem has been replied */
bool vor_limits_rate(struct vor_request *request);

#endif
