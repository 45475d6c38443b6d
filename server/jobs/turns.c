#include "server/jobs/turns.h"

void vor_turns_init(struct vor_turns *turns, uint64_t budget)
{
    *turns = (struct vor_turns){.budget = budget};
    pthread_mutex_init(&turns->mutex, NULL);
}

void vor_turns_free(struct vor_turns *turns)
{
    pthread_mutex_destroy(&turns->mutex);
}

/* The mutex is held. */
static int may_begin(const struct vor_turns *turns, const struct vor_turn *turn)
{
    if (turns->running == 0)
        return 1;
    if (turns->alone || turn->alone)
        return 0;
    return turns->used < turns->budget && turn->bytes <= turns->budget - turns->used;
}

int vor_turns_begin(struct vor_turns *turns, const struct vor_turn *turn)
{
    int may;

    pthread_mutex_lock(&turns->mutex);
    may = may_begin(turns, turn);
    if (may) {
        turns->running++;
        turns->used += turn->bytes;
        turns->alone = turn->alone;
    }
    pthread_mutex_unlock(&turns->mutex);
    return may;
}

void vor_turns_end(struct vor_turns *turns, const struct vor_turn *turn)
{
    pthread_mutex_lock(&turns->mutex);
    turns->running--;
    turns->used -= turn->bytes;
    turns->alone = 0; /* who was alone was the only one */
    pthread_mutex_unlock(&turns->mutex);
}

uint64_t vor_turns_used(struct vor_turns *turns)
{
    uint64_t used;

    pthread_mutex_lock(&turns->mutex);
    used = turns->used;
    pthread_mutex_unlock(&turns->mutex);
    return used;
}
