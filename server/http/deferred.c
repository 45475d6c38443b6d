#include "server/http/deferred.h"

static void drop(struct vor_deferred *deferred)
{
    struct vor_waker *waker = deferred->waker;

    if (atomic_fetch_sub(&deferred->holds, 1) != 1)
        return;
    deferred->release(deferred);
    vor_waker_drop(waker);
}

static void drop_state(void *state)
{
    drop(state);
}

void vor_deferred_begin(struct vor_deferred *deferred, struct vor_request *request,
                        void (*release)(struct vor_deferred *deferred))
{
    deferred->waker = vor_request_waker(request);
    atomic_init(&deferred->holds, 1);
    atomic_init(&deferred->is_done, false);
    deferred->release = release;
    vor_request_set_state(request, deferred, drop_state);
}

void vor_deferred_retain(struct vor_deferred *deferred)
{
    atomic_fetch_add(&deferred->holds, 1);
    atomic_store(&deferred->is_done, false);
}

void vor_deferred_complete(struct vor_deferred *deferred)
{
    atomic_store(&deferred->is_done, true);
    vor_waker_wake(deferred->waker);
    drop(deferred);
}

void vor_deferred_cancel(struct vor_deferred *deferred)
{
    drop(deferred);
}

bool vor_deferred_is_done(const struct vor_deferred *deferred)
{
    return atomic_load(&deferred->is_done);
}
