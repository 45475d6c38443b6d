#include "server/http/waker.h"

#include "server/http/mhd_library.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

/* Suspending and resuming must not cross: both happen under this lock, and a wake that finds the
 * request awake is kept for the next attempt to sleep. */
struct vor_waker {
    pthread_mutex_t lock;
    atomic_uint holds;
    struct MHD_Connection *connection;
    bool suspended, pending, over;
    atomic_bool gone;
};

struct vor_waker *vor_waker_create(struct MHD_Connection *connection)
{
    struct vor_waker *waker = calloc(1, sizeof *waker);

    if (waker == NULL)
        return NULL;
    (void)pthread_mutex_init(&waker->lock, NULL);
    atomic_init(&waker->holds, 1);
    waker->connection = connection;
    return waker;
}

struct vor_waker *vor_waker_hold(struct vor_waker *waker)
{
    (void)atomic_fetch_add(&waker->holds, 1);
    return waker;
}

void vor_waker_drop(struct vor_waker *waker)
{
    if (waker == NULL || atomic_fetch_sub(&waker->holds, 1) != 1)
        return;
    (void)pthread_mutex_destroy(&waker->lock);
    free(waker);
}

void vor_waker_wake(struct vor_waker *waker)
{
    (void)pthread_mutex_lock(&waker->lock);
    if (!waker->over && waker->suspended) {
        waker->suspended = false;
        vor_mhd->resume_connection(waker->connection);
    } else {
        waker->pending = true;
    }
    (void)pthread_mutex_unlock(&waker->lock);
}

bool vor_waker_sleep(struct vor_waker *waker, bool stays)
{
    bool sleeps;

    (void)pthread_mutex_lock(&waker->lock);
    sleeps = !waker->pending && (stays || !atomic_load(&waker->gone));
    waker->pending = false;
    if (sleeps) {
        waker->suspended = true;
        vor_mhd->suspend_connection(waker->connection);
    }
    (void)pthread_mutex_unlock(&waker->lock);
    return sleeps;
}

bool vor_waker_is_pending(struct vor_waker *waker)
{
    bool pending;

    (void)pthread_mutex_lock(&waker->lock);
    pending = waker->pending;
    (void)pthread_mutex_unlock(&waker->lock);
    return pending;
}

void vor_waker_gone(struct vor_waker *waker)
{
    atomic_store(&waker->gone, true);
}

bool vor_waker_is_gone(struct vor_waker *waker)
{
    return atomic_load(&waker->gone);
}

void vor_waker_end(struct vor_waker *waker)
{
    (void)pthread_mutex_lock(&waker->lock);
    waker->over = true;
    (void)pthread_mutex_unlock(&waker->lock);
}
