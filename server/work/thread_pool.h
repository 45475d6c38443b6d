/** Threads for what may block: HTTP threads hand it over and go on. A free thread takes a task of
 * the caller for whom fewest are running, and of several such of the one whose task came first; of
 * that caller's tasks the lightest, and of several such the first. So nobody waits for more than
 * one task of each other caller, and who sends much that is heavy may still ask something small.
 * Thread-safe. */
#ifndef VOR_SERVER_WORK_THREAD_POOL_H
#define VOR_SERVER_WORK_THREAD_POOL_H

#include "core/base/status.h"
#include "server/base/address.h"
#include "server/jobs/job.h"

#include <stddef.h>
#include <stdint.h>

struct vor_thread_pool;

/** Something to do. Who hands it over fills in the first three members and keeps the struct until
 * run is called. */
struct vor_task {
    void (*run)(void *ctx); /**< on a thread of the pool; may free the task */
    void *ctx;
    struct vor_fairness_key caller; /**< whom it is for */
    uint64_t weight;                /**< about how long it takes, in any unit: bytes to read, say */
    struct vor_task *next;          /**< the pool's own */
};

/** A pool of at most `threads` (at least 1) threads, each started when a task finds no other and
 *  ended when it has had none for some seconds; at most `waiting_max` tasks wait for one.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_thread_pool_create(struct vor_thread_pool **out, unsigned threads,
                                                size_t waiting_max, struct vor_error *err);

/** Bounds what each caller may have of a pool of several threads: running_max (below the number of
 *  threads) of its tasks run, so that a thread is left for others, and a task waits behind fewer
 * than waiting_max. To be called before the first task; without it, what the pool has. */
void vor_thread_pool_share(struct vor_thread_pool *pool, unsigned running_max, size_t waiting_max);

/** Takes no more tasks, does those that wait, ends the threads. pool may be NULL. */
void vor_thread_pool_destroy(struct vor_thread_pool *pool);

/** Hands a task over.
 *
 *  @retval VOR_DONE      run will be called, exactly once
 *  @retval VOR_FULL      waiting_max tasks wait, or as many of this caller's go before it as may
 *  @retval VOR_FAILED    no thread runs and none can be started, as err (may be NULL) says
 *  @retval VOR_DRAINING  vor_thread_pool_destroy was called */
VOR_NODISCARD enum vor_job_outcome
vor_thread_pool_submit(struct vor_thread_pool *pool, struct vor_task *task, struct vor_error *err);

/** True once vor_thread_pool_destroy was called: a task that is long had better not begin. */
int vor_thread_pool_is_closing(struct vor_thread_pool *pool);

/** Waits until nothing waits or runs, `seconds` at most. */
void vor_thread_pool_wait(struct vor_thread_pool *pool, double seconds);

/* Who waits for something that another thread does. */

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
