/** What the files of this room share of the whole: options, counters, the guard of connections. */
#ifndef VOR_SERVER_HTTP_STATE_H
#define VOR_SERVER_HTTP_STATE_H

#include "server/base/address.h"
#include "server/http/http.h"
#include "server/http/watchdog.h"

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

enum {
    VOR_CONNECTION_BYTES = 49152 /**< what the library keeps for a connection: the longest header
                                    block, and room to read a body and to answer */
};

struct MHD_Daemon;
struct vor_conn_guard;

struct vor_http {
    struct vor_http_options options;
    struct MHD_Daemon *daemon;
    struct vor_conn_guard *guard;
    char address[VOR_SOCKET_PATH_MAX + 8];
    int fd;           /**< listening; the library's from start to quiesce, -1 then */
    atomic_uint busy; /**< requests under way */
    atomic_bool quiesced, closing;
    struct vor_watchdog watchdog;
};

/* The reply of a request, before the library sees it. What handlers call is in http.h. */

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
