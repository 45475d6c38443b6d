/** The thread that watches all connections: cuts what is late, wakes a waiting request when its
 * peer leaves or its time is over. Thread-safe; nothing here blocks, but for stopping. */
#ifndef VOR_SERVER_HTTP_WATCHMAN_H
#define VOR_SERVER_HTTP_WATCHMAN_H

#include "core/base/status.h"
#include "server/http/phases.h"

/** Starts the thread.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_watchman_start(struct vor_watchman **out,
                                            const struct vor_watch_limits *limits,
                                            struct vor_error *err);

/** Stops the thread; every peer must have left. watchman may be NULL. */
void vor_watchman_stop(struct vor_watchman *watchman);

/** Cuts every connection whose head or body is on its way, or whose reply is, and those that are
 *  kept. */
void vor_watchman_cut_slow(struct vor_watchman *watchman);

/** How many connections are open; not counted are streams, and those which have been cut. */
unsigned vor_watchman_count(struct vor_watchman *watchman);

/** How many connections without a request have sent bytes that nobody has read yet. */
unsigned vor_watchman_unread(struct vor_watchman *watchman);

/** Wakes every request under way. */
void vor_watchman_wake_all(struct vor_watchman *watchman);

#endif
