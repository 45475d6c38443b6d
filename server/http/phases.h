/** The words in which connections are spoken of: where one stands, what limits them all. */
#ifndef VOR_SERVER_HTTP_PHASES_H
#define VOR_SERVER_HTTP_PHASES_H

#include "server/base/address.h"

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
enum vor_crowd { VOR_CROWD_NONE, VOR_CROWD_ALL, VOR_CROWD_ADDRESS };

/** One accepted connection. */
struct vor_peer;

/** All connections and the thread that sweeps them. */
struct vor_watchman;

/** As in vor_http_options; and for how many seconds a connection may be silent before it goes to
 * make room, as long as the reserve lasts. */
struct vor_watch_limits {
    double header_seconds, keep_seconds, body_seconds, body_idle_seconds, body_rate, reply_rate;
    double beat_seconds, grace_seconds;
    unsigned connections, each;
    const struct vor_networks *trusted; /**< borrowed; may be NULL */
};

#endif
