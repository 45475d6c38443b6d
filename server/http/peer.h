/** Deadlines and departures, which the library does not watch: a thread walks all connections, cuts
 *  what is late, and wakes a waiting request when its peer leaves. A peer may be NULL everywhere:
 *  it is one that is not watched. Thread-safe; nothing here blocks. */
#ifndef VOR_SERVER_HTTP_PEER_H
#define VOR_SERVER_HTTP_PEER_H

#include "core/base/status.h"
#include "server/http/waker.h"

#include <stdbool.h>
#include <stddef.h>

enum vor_phase {
    VOR_PHASE_HEAD,  /**< since accept, or since the request line on a kept connection */
    VOR_PHASE_BODY,  /**< body is arriving */
    VOR_PHASE_SERVE, /**< a handler or the reply's writer has it */
    VOR_PHASE_IDLE   /**< kept, between requests */
};

/** One accepted connection. */
struct vor_peer;

/** All connections and the thread that sweeps them. */
struct vor_watchman;

/** Seconds, as in vor_http_options; body_rate is bytes a second. */
struct vor_deadlines {
    double header_seconds, keep_seconds, body_seconds, body_idle_seconds, body_rate;
};

/** Starts the thread.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_watchman_start(struct vor_watchman **out,
                                            const struct vor_deadlines *deadlines,
                                            struct vor_error *err);

/** Stops the thread; every peer must have left. watchman may be NULL. */
void vor_watchman_stop(struct vor_watchman *watchman);

/** Cuts idle connections; from now on those that become idle too. */
void vor_watchman_quiesce(struct vor_watchman *watchman);

/** How many connections are open. */
unsigned vor_watchman_count(struct vor_watchman *watchman);

/** Wakes every request under way. */
void vor_watchman_wake_all(struct vor_watchman *watchman);

/** A connection comes; fd is borrowed until it leaves. NULL when memory is out. */
struct vor_peer *vor_peer_enter(struct vor_watchman *watchman, int fd);
void vor_peer_leave(struct vor_watchman *watchman, struct vor_peer *peer);

/** A phase begins, unless it is this one already; its deadlines are counted from now on. */
void vor_peer_phase(struct vor_watchman *watchman, struct vor_peer *peer, enum vor_phase phase);

/** Bytes of the body came. */
void vor_peer_received(struct vor_watchman *watchman, struct vor_peer *peer, size_t bytes);

/** The request under way on this connection, or NULL when there is none. The peer keeps a hold of
 *  its own on the waker. */
void vor_peer_request(struct vor_watchman *watchman, struct vor_peer *peer,
                      struct vor_waker *waker);

/** The request waits, or goes on. When the peer of one that waits leaves, its waker is told
 *  (vor_waker_gone) and woken. */
void vor_peer_wait(struct vor_watchman *watchman, struct vor_peer *peer, bool waiting);

/** Wakes the request once, `seconds` from now; in place of an earlier call. */
void vor_peer_timer(struct vor_watchman *watchman, struct vor_peer *peer, double seconds);

/** What to send, raw, when the body is late; malloc, taken over. NULL for nothing. */
void vor_peer_late(struct vor_watchman *watchman, struct vor_peer *peer, char *late);

/** When the connection closes, reads on for some seconds what the peer still sends, so that the
 *  reply is not lost to a reset. */
void vor_peer_linger(struct vor_watchman *watchman, struct vor_peer *peer);

/** The request is over. True when it was cut because its body was late. */
bool vor_peer_end(struct vor_watchman *watchman, struct vor_peer *peer);

#endif
