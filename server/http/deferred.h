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
    atomic_bool is_done, is_over;
    void (*over)(struct vor_deferred *deferred);    /**< the request is over, and its hold not given
                                                         back yet; may be NULL */
    void (*release)(struct vor_deferred *deferred); /**< frees the struct around it */
};

/** Begins with one hold, the request's: the struct becomes its state (vor_request_set_state). over
 *  is kept as it is. */
void vor_deferred_begin(struct vor_deferred *deferred, struct vor_request *request,
                        void (*release)(struct vor_deferred *deferred));

/** Hands it to a thread: one hold more, and it is not done. From here on the request's side reads
 *  nothing that the work writes until vor_deferred_is_done. */
void vor_deferred_retain(struct vor_deferred *deferred);

/** What the request waits for is there; the thread goes on. */
void vor_deferred_done(struct vor_deferred *deferred);

/** The work is done: wakes the request, and gives the thread's hold back. */
void vor_deferred_complete(struct vor_deferred *deferred);

/** Gives a hold back and wakes nobody: the work was not begun, or the request is over. */
void vor_deferred_cancel(struct vor_deferred *deferred);

bool vor_deferred_is_done(const struct vor_deferred *deferred);

/** True once nobody waits for the work: the request is over, or its client was seen to leave. */
bool vor_deferred_is_left(const struct vor_deferred *deferred);

#endif
