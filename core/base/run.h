/** What a run gets from its caller: threads, memory, and whom to tell. */
#ifndef VOR_BASE_RUN_H
#define VOR_BASE_RUN_H

#include "core/base/memory.h"
#include "core/base/parallel.h"
#include "core/base/watch.h"

#include <stdint.h>

/** Counted work from one checkpoint to the next, in searches and cells: some 30 s of CPU. */
#define VOR_CHECKPOINT_WORK (UINT64_C(16) << 20)

/** One run; borrows everything. */
struct vor_run {
    struct vor_pool *pool;           /**< borrowed */
    struct vor_memory *memory;       /**< the job's; results allocate from it too */
    const struct vor_watch *watch;   /**< may be NULL */
    const struct vor_watch *no_stop; /**< the same, but never answers VOR_STOP (vor_no_stop_watch);
                                          NULL where watch never does */
    double began;          /**< the clock when the run began; records and budgets count from it */
    double late;           /**< the clock when its time is over by far (process.c); 0 for never */
    struct vor_part saved; /**< the checkpoint of an earlier run of the same request, to go on from;
                                its size is 0 for none. One that is damaged, or of another request,
                                is not used */
    uint64_t every;        /**< work from one checkpoint to the next, which moves points a little;
                                0: VOR_CHECKPOINT_WORK */
    struct vor_checkpoints *checkpoints; /**< the engine's (seeds/checkpoint.h); NULL: none */
};

/** The same run, not interrupted by VOR_STOP: for the parts before there is a result to hand back.
 *  Valid as long as run's watches are. */
static inline struct vor_run vor_run_unstoppable(const struct vor_run *run)
{
    struct vor_run whole = *run;

    if (run->no_stop != NULL)
        whole.watch = run->no_stop;
    return whole;
}

/** What the run's watch answers when it is asked, where no loop of the pool asks it. */
static inline enum vor_answer vor_run_poll(const struct vor_run *run)
{
    return run->watch != NULL && run->watch->poll != NULL ? run->watch->poll(run->watch->ctx)
                                                          : VOR_CONTINUE;
}

/** Tells the run's watch of a step. Returns what it answers. */
static inline enum vor_answer vor_run_tell(const struct vor_run *run,
                                           const struct vor_record *record)
{
    return run->watch != NULL && run->watch->progress != NULL
               ? run->watch->progress(run->watch->ctx, record)
               : VOR_CONTINUE;
}

/** Nothing for VOR_CONTINUE, else the failure that an answer means.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED */
VOR_NODISCARD static inline vor_status vor_run_answered(enum vor_answer answer,
                                                        struct vor_error *err)
{
    switch (answer) {
    case VOR_CONTINUE:
        return VOR_OK;
    case VOR_STOP:
        return vor_fail(err, VOR_E_STOPPED, "stopped by the caller");
    default:
        return vor_fail(err, VOR_E_CANCELLED, "cancelled by the caller");
    }
}

/** Runs task over 0 .. n - 1 on the run's pool, as vor_parallel_for.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as the watch answered; some rows are not done */
VOR_NODISCARD static inline vor_status vor_run_for(const struct vor_run *run, size_t n,
                                                   size_t block, vor_task task, void *ctx,
                                                   struct vor_error *err)
{
    return vor_run_answered(vor_parallel_for(run->pool, run->watch, n, block, task, ctx), err);
}

/** Does rows 0 .. n - 1 on the run's pool, as vor_parallel_rows; fails as vor_run_for. */
VOR_NODISCARD static inline vor_status vor_run_rows(const struct vor_run *run, size_t n,
                                                    size_t block, vor_row_task task, void *ctx,
                                                    struct vor_error *err)
{
    return vor_run_answered(vor_parallel_rows(run->pool, run->watch, n, block, task, ctx), err);
}

/** A function that is called on the pool, and what it returned. */
struct vor_one_call {
    vor_status (*function)(void *ctx, struct vor_error *err);
    void *ctx;
    struct vor_error *err;
    vor_status status;
};

static inline void vor_one_call_row(void *ctx, VOR_UNUSED size_t row, VOR_UNUSED unsigned worker)
{
    struct vor_one_call *call = ctx;

    call->status = call->function(call->ctx, call->err);
}

/** Calls what needs one thread on the run's pool; fails as it does, and as vor_run_for. */
VOR_NODISCARD static inline vor_status
vor_run_call(const struct vor_run *run, vor_status (*function)(void *ctx, struct vor_error *err),
             void *ctx, struct vor_error *err)
{
    struct vor_one_call call = {function, ctx, err, VOR_OK};
    vor_status status = vor_run_rows(run, 1, 1, vor_one_call_row, &call, err);

    return status == VOR_OK ? call.status : status;
}

/** A watch that answers VOR_CANCEL when another one does, and never VOR_STOP; with its clock. */
struct vor_no_stop {
    const struct vor_watch *inner;
    struct vor_watch watch;
};

static inline enum vor_answer vor_no_stop_poll(void *ctx)
{
    const struct vor_no_stop *no_stop = ctx;

    return no_stop->inner->poll(no_stop->inner->ctx) == VOR_CANCEL ? VOR_CANCEL : VOR_CONTINUE;
}

static inline double vor_no_stop_clock(void *ctx)
{
    const struct vor_no_stop *no_stop = ctx;

    return no_stop->inner->clock(no_stop->inner->ctx);
}

/** The watch of *no_stop over inner, which may be NULL; NULL if inner has neither poll nor clock.
 * Valid as long as both are. */
static inline const struct vor_watch *vor_no_stop_watch(struct vor_no_stop *no_stop,
                                                        const struct vor_watch *inner)
{
    no_stop->inner = inner;
    no_stop->watch = (struct vor_watch){
        .ctx = no_stop,
        .poll = inner != NULL && inner->poll != NULL ? vor_no_stop_poll : NULL,
        .clock = inner != NULL && inner->clock != NULL ? vor_no_stop_clock : NULL};
    return no_stop->watch.poll != NULL || no_stop->watch.clock != NULL ? &no_stop->watch : NULL;
}

/** Seconds by the watch's clock, 0 without one; vor_run_seconds counts from the run's beginning. */
static inline double vor_run_clock(const struct vor_run *run)
{
    return run->watch != NULL && run->watch->clock != NULL ? run->watch->clock(run->watch->ctx) : 0;
}

/** Whether the time that the request allows is over by far: what has to be done is then done the
 *  fastest way. Threads of the pool may ask. */
static inline int vor_run_is_late(const struct vor_run *run)
{
    return run->late > 0 && vor_run_clock(run) > run->late;
}

/** Seconds since the run began. */
static inline double vor_run_seconds(const struct vor_run *run)
{
    return vor_run_clock(run) - run->began;
}

#endif
