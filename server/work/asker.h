/** Who waits for something that another thread does. */
#ifndef VOR_SERVER_WORK_ASKER_H
#define VOR_SERVER_WORK_ASKER_H

#include "server/base/address.h"

/** Somebody who asks. wake is called at most once, on another thread, after an answer to wait
 * alone; it must not call back. */
struct vor_asker {
    void (*wake)(void *ctx);
    void *ctx;
    struct vor_fairness_key caller; /**< whom a file that is read for it is read for */
};

/** A list of those who wait; NULL is empty. Its owner locks it. */
struct vor_askers;

/** Adds somebody; false when memory is out. */
int vor_waiting_add(struct vor_askers **list, const struct vor_asker *asker);

/** Takes the whole list, for vor_waiting_wake once the lock is given up. */
struct vor_askers *vor_waiting_take(struct vor_askers **list);

/** Wakes all of a list, and frees it. */
void vor_waiting_wake(struct vor_askers *list);

#endif
