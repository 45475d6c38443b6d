/** The reply of a request, before the library sees it. What handlers call is in http.h. */
#ifndef VOR_SERVER_HTTP_REPLY_H
#define VOR_SERVER_HTTP_REPLY_H

#include "server/http/http.h"

#include <stddef.h>
#include <stdint.h>

/** Reply as raw HTTP/1.1, head and bytes, for a socket that the library cannot answer on any more;
 *  NULL when memory is short. The caller frees it. */
char *vor_reply_raw(const struct vor_request *request);

/** The refusals of a body that is too long (detail is the room for its sentence) and of one that
 *  the sink cannot keep. */
void vor_refusal_excess(char *detail, size_t size, struct vor_refusal *refusal, uint64_t limit,
                        uint64_t got);
void vor_refusal_sink(struct vor_refusal *refusal, int http);

/** Drops the reply but for its first `fields` header fields. */
void vor_reply_clear(struct vor_request *request, unsigned fields);

#endif
