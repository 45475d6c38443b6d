/** All connections, and the thread that guards them: it closes what is late, or too many, and wakes
 *  a waiting request when its client leaves or its time is over. libmicrohttpd's own time-out
 * starts again with every byte, and it does not look at a suspended connection at all. Thread-safe;
 * nothing here blocks, but for stopping. */
#ifndef VOR_SERVER_HTTP_CONN_GUARD_H
#define VOR_SERVER_HTTP_CONN_GUARD_H

#include "core/base/status.h"
#include "server/http/conn.h"
#include "server/http/waker.h"

#include <stdbool.h>
#include <stddef.h>

/** Starts the thread.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_conn_guard_start(struct vor_conn_guard **out,
                                              const struct vor_conn_limits *limits,
                                              struct vor_error *err);

/** Stops the thread; every connection has left. guard may be NULL. */
void vor_conn_guard_stop(struct vor_conn_guard *guard);

/** How many connections are open; not counted are streams, and those which have been closed. */
unsigned vor_conn_guard_count(struct vor_conn_guard *guard);

/** A connection comes, from that address (NULL: none); fd is borrowed until it leaves. If there are
 *  too many now, the oldest silent one is closed. NULL when memory is out. */
struct vor_conn *vor_conn_enter(struct vor_conn_guard *guard, int fd,
                                const struct vor_address *from);
/** conn may be NULL. */
void vor_conn_leave(struct vor_conn *conn);

/** Whether too many requests are under way for this one to be served; silent connections do not
 *  count, as they would be closed. */
enum vor_conn_excess vor_conn_excess(struct vor_conn_guard *guard, const struct vor_conn *conn);

/** A phase begins, unless it is this one already; its deadlines are counted from now on. */
void vor_conn_phase(struct vor_conn *conn, enum vor_phase phase);

/** From now on its requests are woken when bytes come or may be sent, too. */
void vor_conn_watch(struct vor_conn *conn, bool is_chunked);

/** Whether bytes came to a watched connection since this was last asked. */
bool vor_conn_news(struct vor_conn *conn);

/** Bytes of the body came. */
void vor_conn_received(struct vor_conn *conn, size_t bytes);

/** A request begins, and keeps a hold of its own on the waker; or it is over (NULL). */
void vor_conn_request(struct vor_conn *conn, struct vor_waker *waker);

/** The request waits, or goes on. When the client of one that waits leaves, its waker is told
 *  (vor_waker_gone) and woken. */
void vor_conn_wait(struct vor_conn *conn, bool waiting);

/** Wakes the request once, `seconds` from now or when an earlier call said so, whichever is first;
 *  among many that are due at once, when its turn comes. */
void vor_conn_wake_after(struct vor_conn *conn, double seconds);

/** What to send, raw, when the body is late; malloc, taken over. NULL for nothing. */
void vor_conn_late(struct vor_conn *conn, char *late);

/** When the connection closes, reads on for some seconds what the client still sends, so that the
 *  reply is not lost to a reset. */
void vor_conn_linger(struct vor_conn *conn);

/** The request is over. True when it was ended because its body was late. */
bool vor_conn_end(struct vor_conn *conn);

#endif
