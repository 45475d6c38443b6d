/** Connections: where one stands, what limits them all. */
#ifndef VOR_SERVER_HTTP_CONN_H
#define VOR_SERVER_HTTP_CONN_H

#include "server/http/http.h"

enum vor_phase {
    VOR_PHASE_HEAD,   /**< since accept, or since the request line on a kept connection */
    VOR_PHASE_BODY,   /**< body is arriving */
    VOR_PHASE_SERVE,  /**< a handler has it */
    VOR_PHASE_SEND,   /**< a reply of known length is on its way */
    VOR_PHASE_STREAM, /**< a reply without an end in sight; not one of the connections that count */
    VOR_PHASE_IDLE,   /**< kept, between requests */
    VOR_PHASE_COUNT
};

/** Too many: connections in all, or of one address. */
enum vor_conn_excess { VOR_EXCESS_NONE, VOR_EXCESS_ALL, VOR_EXCESS_ADDRESS };

/** One accepted connection. */
struct vor_conn;

struct vor_conn_guard;

/** True when the client has sent bytes that nobody has read yet; of a body in chunks that is
 * watched, more than those that end a chunk. */
bool vor_conn_has_unread(const struct vor_conn *conn);

#endif
