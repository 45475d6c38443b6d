/** The executor whose runs happen in a worker process (worker_main.h): starts it, watches it, ends
 * it when it no longer answers, and starts the next. All runs share one but for suspects, each of
 *  which has its own for as long as it takes. */
#ifndef VOR_SERVER_WORK_SUPERVISOR_H
#define VOR_SERVER_WORK_SUPERVISOR_H

#include "server/proc/zygote.h"
#include "server/work/codec_run.h"
#include "server/work/run_executor.h"

struct vor_supervisor;

struct vor_supervisor_config {
    struct vor_zygote *zygote;    /**< borrowed */
    unsigned kind;                /**< number of the kind whose function is vor_worker_main */
    struct vor_codec_place codec; /**< where results are encoded, its zygote the same; without one
                                       that happens in the worker */
    unsigned threads;             /**< of the pool, 1 .. VOR_THREADS_MAX */
    size_t memory;                /**< bytes that all runs together may have; 0 for any */
    double cancel_seconds;        /**< for a cancelled run to end where others run; 0 for 5 */
    double stall_seconds;         /**< for the worker to show that it is there; 0 for 10 */
};

/** Starts a worker process.
 *
 *  @retval VOR_E_NOMEM  its threads cannot be started
 *  @retval VOR_E_IO     there is no process to be had */
VOR_NODISCARD vor_status vor_supervisor_create(struct vor_supervisor **out,
                                               const struct vor_supervisor_config *config,
                                               struct vor_error *err);

/** Ends the worker process. No run may be under way. supervisor may be NULL. */
void vor_supervisor_destroy(struct vor_supervisor *supervisor);

/** The executor: VOR_RUN_SLOTS (ipc_codec.h) runs at a time. Borrowed.
 *
 *  What a listener answers is known to the run within 20 ms. A run that was cancelled and does not
 *  end is told as cancelled after 0.3 seconds, and ended with its process: after cancel_seconds,
 * as others lose what they have done, which end as VOR_RUN_DISTURBED; where nothing else runs
 * there, after a fifth of that. A worker that ends without being told to, or gives no sign of life
 * for stall_seconds, is VOR_RUN_CRASHED for all that runs there. */
struct vor_run_executor *vor_supervisor_executor(struct vor_supervisor *supervisor);

#endif
