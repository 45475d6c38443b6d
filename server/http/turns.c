#include "server/http/turns.h"

#include "server/base/clock.h"

/* A thread of the library serves one listener all its life. */
static _Thread_local unsigned place; /* from 1; 0 before the first turn */

void vor_turn_begin(struct vor_turns *turns)
{
    if (place == 0)
        place = atomic_fetch_add(&turns->threads, 1) % VOR_TURNS_MAX + 1;
    atomic_store(&turns->since[place - 1], vor_clock_seconds());
}

void vor_turn_end(struct vor_turns *turns)
{
    atomic_store(&turns->since[place - 1], 0);
}

double vor_turns_longest(const struct vor_turns *turns)
{
    double now = vor_clock_seconds(), longest = 0;

    for (unsigned i = 0; i < VOR_TURNS_MAX; i++) {
        double since = atomic_load(&turns->since[i]);

        if (since > 0 && now - since > longest)
            longest = now - since;
    }
    return longest;
}
