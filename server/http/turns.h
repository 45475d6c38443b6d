/** Whether the threads that speak HTTP go on: each notes when its turn at a request began, and that
 *  it is over. A turn never waits, so one that lasts has met a lock, or a disk, that it should not
 *  have. Thread-safe. */
#ifndef VOR_SERVER_HTTP_TURNS_H
#define VOR_SERVER_HTTP_TURNS_H

#include <stdatomic.h>

enum { VOR_TURNS_MAX = 64 /**< threads that are watched; as many as --http-threads may be */ };

struct vor_turns {
    atomic_uint threads;
    _Atomic double since[VOR_TURNS_MAX]; /**< 0: between two turns */
};

/** A turn of this thread begins, or is over. */
void vor_turn_begin(struct vor_turns *turns);
void vor_turn_end(struct vor_turns *turns);

/** Seconds since the beginning of the turn that has lasted longest; 0 when none is under way. */
double vor_turns_longest(const struct vor_turns *turns);

#endif
