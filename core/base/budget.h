/** The time that a request allows a run: once it is over, loops end as if the caller had stopped
 * the run, and what cannot be left out is done the fastest way. */
#ifndef VOR_BASE_BUDGET_H
#define VOR_BASE_BUDGET_H

#include "core/base/run.h"

#include <stdatomic.h>

/** A watch that answers VOR_STOP once the time is over, and else as another one does. */
struct vor_budget {
    const struct vor_watch *inner;
    double until;     /* by its clock */
    atomic_int ended; /* it answered VOR_STOP, and not the other one */
    struct vor_watch watch;
};

/** Makes run's watch one that ends after `seconds` from run->began, and sets run->late. Does
 *  nothing where its watch has no clock or no poll, which says that threads of the pool may ask.
 *  Both watches must outlive the run. */
void vor_budget_begin(struct vor_budget *budget, struct vor_run *run, double seconds);

/** Whether the time ended a loop. False for a budget that is all zero. */
static inline int vor_budget_ended(const struct vor_budget *budget)
{
    return atomic_load(&budget->ended);
}

#endif
