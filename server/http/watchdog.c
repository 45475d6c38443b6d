#include "server/http/watchdog.h"

#include "server/base/clock.h"

/* A thread of the library serves one listener all its life. */
static _Thread_local unsigned place; /* from 1; 0 before the first call */

void vor_watchdog_enter(struct vor_watchdog *watchdog)
{
    if (place == 0)
        place = atomic_fetch_add(&watchdog->threads, 1) % VOR_WATCHED_MAX + 1;
    atomic_store(&watchdog->since[place - 1], vor_clock_seconds());
}

void vor_watchdog_leave(struct vor_watchdog *watchdog)
{
    atomic_store(&watchdog->since[place - 1], 0);
}

double vor_watchdog_longest(const struct vor_watchdog *watchdog)
{
    double now = vor_clock_seconds(), longest = 0;

    for (unsigned i = 0; i < VOR_WATCHED_MAX; i++) {
        double since = atomic_load(&watchdog->since[i]);

        if (since > 0 && now - since > longest)
            longest = now - since;
    }
    return longest;
}
