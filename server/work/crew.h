/** Threads for what may block: HTTP threads hand it over and go on. Tasks begin in the order in
 *  which they were handed over. Thread-safe. */
#ifndef VOR_SERVER_WORK_CREW_H
#define VOR_SERVER_WORK_CREW_H

#include "core/base/status.h"
#include "server/jobs/job.h"

#include <stddef.h>

struct vor_crew;

/** Something to do. The caller fills in run and ctx and keeps the struct until run is called. */
struct vor_task {
    void (*run)(void *ctx); /**< on a thread of the crew; may free the task */
    void *ctx;
    struct vor_task *next; /**< the crew's own */
};

/** Starts `threads` (at least 1) threads; at most `waiting_max` tasks wait for one.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_crew_create(struct vor_crew **out, unsigned threads,
                                         size_t waiting_max, struct vor_error *err);

/** Takes no more tasks, does those that wait, ends the threads. crew may be NULL. */
void vor_crew_destroy(struct vor_crew *crew);

/** Hands a task over.
 *
 *  @retval VOR_DONE      run will be called, exactly once
 *  @retval VOR_FULL      waiting_max tasks wait
 *  @retval VOR_DRAINING  vor_crew_destroy was called */
VOR_NODISCARD enum vor_job_outcome vor_crew_take(struct vor_crew *crew, struct vor_task *task);

/** True once vor_crew_destroy was called: a task that is long had better not begin. */
int vor_crew_closing(struct vor_crew *crew);

/** Waits until nothing waits or runs, `seconds` at most. */
void vor_crew_settle(struct vor_crew *crew, double seconds);

#endif
