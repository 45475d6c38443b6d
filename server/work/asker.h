/** Who waits for something that another thread does. */
#ifndef VOR_SERVER_WORK_ASKER_H
#define VOR_SERVER_WORK_ASKER_H

#include "server/base/fairness_key.h"

/** Somebody who asks. wake is called at most once, on another thread, after an answer to wait
 * alone; it must not call back. */
struct vor_asker {
    void (*wake)(void *ctx);
    void *ctx;
    struct vor_fairness_key caller; /**< whom a file that is read for it is read for */
};

#endif
