/** Whether the threads that speak HTTP go on: each notes when the library called us, be it with a
 *  request, a read of a stream or the end of a connection, and that we returned. None of that
 * waits, so a call that lasts has met a lock, or a disk, that it should not have. What the library
 * does by itself, as sendfile of a file, is not seen. Thread-safe. */
#ifndef VOR_SERVER_HTTP_WATCHDOG_H
#define VOR_SERVER_HTTP_WATCHDOG_H

#include <stdatomic.h>

enum { VOR_WATCHED_MAX = 64 /**< threads that are watched; as many as --http-threads may be */ };

struct vor_watchdog {
    atomic_uint threads;
    _Atomic double since[VOR_WATCHED_MAX]; /**< 0: between two calls */
};

/** This thread is called, or returns. */
void vor_watchdog_enter(struct vor_watchdog *watchdog);
void vor_watchdog_leave(struct vor_watchdog *watchdog);

/** Seconds that the call under way has lasted that began first; 0 when there is none. */
double vor_watchdog_longest(const struct vor_watchdog *watchdog);

#endif
