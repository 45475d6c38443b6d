/** Suspending a request and calling it back. */
#ifndef VOR_SERVER_HTTP_WAKER_H
#define VOR_SERVER_HTTP_WAKER_H

#include "server/http/http.h"

#include <stdbool.h>

/** A waker for the request on this connection, with one hold; NULL when memory is out. */
struct vor_waker *vor_waker_create(struct MHD_Connection *connection);

/** Suspends the request, from within one of its steps. False, and it is not suspended, when it was
 *  woken since it last slept, or when its peer has left, unless it stays all the same. */
bool vor_waker_sleep(struct vor_waker *waker, bool stays);

/** Marks that the peer left, and tells. */
void vor_waker_gone(struct vor_waker *waker);
bool vor_waker_is_gone(struct vor_waker *waker);

/** True when it was woken since it last slept. */
bool vor_waker_is_pending(struct vor_waker *waker);

/** The request is over: its connection is not touched any more. */
void vor_waker_end(struct vor_waker *waker);

#endif
