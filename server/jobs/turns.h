/** Which jobs may run beside each other: those that fit into the memory together, and none beside
 *  one that is to run alone. */
#ifndef VOR_SERVER_JOBS_TURNS_H
#define VOR_SERVER_JOBS_TURNS_H

#include <pthread.h>
#include <stdint.h>

/** What a job needs to run. */
struct vor_turn {
    uint64_t bytes; /**< of memory, as estimated */
    int alone;      /**< nothing may run beside it */
};

/** What runs. Thread-safe. */
struct vor_turns {
    pthread_mutex_t mutex;
    uint64_t budget, used; /* bytes */
    unsigned running;
    int alone; /* what runs is to be alone */
};

/** Room for `budget` bytes. vor_turns_free once nobody calls any more. */
void vor_turns_init(struct vor_turns *turns, uint64_t budget);
void vor_turns_free(struct vor_turns *turns);

/** Books a turn, which vor_turns_end gives back. False, and nothing is booked, when it would not be
 *  as the first lines say. A turn of more bytes than there are is booked when nothing runs. */
int vor_turns_begin(struct vor_turns *turns, const struct vor_turn *turn);
void vor_turns_end(struct vor_turns *turns, const struct vor_turn *turn);

/** Bytes that are booked. */
uint64_t vor_turns_used(struct vor_turns *turns);

#endif
