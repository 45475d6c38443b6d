#include "server/http/deferred.h"

#include "server/http/waker.h"

void vor_deferred_cancel(struct vor_deferred *deferred)
{
    struct vor_waker *waker = deferred->waker;

    if (atomic_fetch_sub(&deferred->holds, 1) != 1)
        return;
    deferred->release(deferred);
    vor_waker_drop(waker);
}

static void end_request(void *state)
{
    struct vor_deferred *deferred = state;

    atomic_store(&deferred->is_over, true);
    if (deferred->over != NULL)
        deferred->over(deferred);
    vor_deferred_cancel(deferred);
}

void vor_deferred_begin(struct vor_deferred *deferred, struct vor_request *request,
                        void (*release)(struct vor_deferred *deferred))
{
    deferred->waker = vor_waker_hold(request->waker);
    atomic_init(&deferred->holds, 1);
    atomic_init(&deferred->is_done, false);
    atomic_init(&deferred->is_over, false);
    deferred->release = release;
    vor_request_set_state(request, deferred, end_request);
}

void vor_deferred_retain(struct vor_deferred *deferred)
{
    atomic_fetch_add(&deferred->holds, 1);
    atomic_store(&deferred->is_done, false);
}

void vor_deferred_done(struct vor_deferred *deferred)
{
    atomic_store(&deferred->is_done, true);
}

void vor_deferred_complete(struct vor_deferred *deferred)
{
    vor_deferred_done(deferred);
    vor_waker_wake(deferred->waker);
    vor_deferred_cancel(deferred);
}

bool vor_deferred_is_done(const struct vor_deferred *deferred)
{
    return atomic_load(&deferred->is_done);
}

bool vor_deferred_is_left(const struct vor_deferred *deferred)
{
    return atomic_load(&deferred->is_over) || vor_waker_is_gone(deferred->waker);
}
