/** What the watchman is told of a connection. A peer may be NULL everywhere: it is one that is not
 *  watched. Thread-safe; nothing here blocks. */
#ifndef VOR_SERVER_HTTP_PEER_H
#define VOR_SERVER_HTTP_PEER_H

#include "server/http/phases.h"
#include "server/http/waker.h"

#include <stdbool.h>
#include <stddef.h>

/** A connection comes, from that address (NULL: none); fd is borrowed until it leaves. If there are
 *  too many now, the oldest silent one is cut. NULL when memory is out. */
struct vor_peer *vor_peer_enter(struct vor_watchman *watchman, int fd,
                                const struct vor_address *from);
void vor_peer_leave(struct vor_watchman *watchman, struct vor_peer *peer);

/** Whether too many requests are under way for this one to be served; who is silent does not count,
 *  as it would go. */
enum vor_crowd vor_peer_crowd(struct vor_watchman *watchman, const struct vor_peer *peer);

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

/** Wakes the request soon, once those had their turn that were due before. peer is not NULL. */
void vor_peer_turn(struct vor_watchman *watchman, struct vor_peer *peer);

/** Wakes the request once, `seconds` from now or when an earlier call said so, whichever is first;
 *  among many that are due at once, when its turn comes. */
void vor_peer_timer(struct vor_watchman *watchman, struct vor_peer *peer, double seconds);

/** What to send, raw, when the body is late; malloc, taken over. NULL for nothing. */
void vor_peer_late(struct vor_watchman *watchman, struct vor_peer *peer, char *late);

/** When the connection closes, reads on for some seconds what the peer still sends, so that the
 *  reply is not lost to a reset. */
void vor_peer_linger(struct vor_watchman *watchman, struct vor_peer *peer);

/** The request is over. True when it was cut because its body was late. */
bool vor_peer_end(struct vor_watchman *watchman, struct vor_peer *peer);

#endif
