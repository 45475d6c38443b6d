/** Work of another thread that a request waits for. The request may be over before the work is, so
 *  both hold what they share: a struct that begins with this one, and whose last holder frees it.
 */
#ifndef VOR_SERVER_HTTP_DEFERRED_H
#define VOR_SERVER_HTTP_DEFERRED_H

#include "server/http/http.h"

#include <stdatomic.h>
#include <stdbool.h>

struct vor_deferred {
    struct vor_waker *waker;
    atomic_int holds;
    atomic_bool is_done;
    void (*release)(struct vor_deferred *deferred); /**< frees the struct around it */
};

/** Begins with one hold, the request's: the struct becomes its state (vor_request_set_state). */
void vor_deferred_begin(struct vor_deferred *deferred, struct vor_request *request,
                        void (*release)(struct vor_deferred *deferred));

/** Hands it to a thread: one hold more, and it is not done. From here on the request's side reads
 *  nothing that the work writes until vor_deferred_is_done. */
void vor_deferred_retain(struct vor_deferred *deferred);

/** The work is done: wakes the request, and gives the thread's hold back. */
void vor_deferred_complete(struct vor_deferred *deferred);

/** The work was not begun: gives the hold back on the request's side. */
void vor_deferred_cancel(struct vor_deferred *deferred);

bool vor_deferred_is_done(const struct vor_deferred *deferred);

#endif
