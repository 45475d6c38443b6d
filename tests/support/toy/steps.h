/** The stages of a toy's run as they are told, all of as many steps. */
#ifndef VOR_TOY_STEPS_H
#define VOR_TOY_STEPS_H

#include "core/base/run.h"
#include "core/report.h"

struct toy_steps {
    const struct vor_run *run;
    struct vor_record record; /**< as told last */
    double pause;             /**< seconds that a step takes at least */
};

/** No stage yet. Reads parts and pause. */
struct toy_steps toy_steps_of(const struct vor_spec *spec, const struct vor_run *run);

/** Enters a stage, which so many others follow, and tells the watch.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  what the watch answered */
VOR_NODISCARD vor_status toy_enter(struct toy_steps *steps, enum vor_run_stage stage,
                                   uint32_t others, struct vor_error *err);

/** Does rows begin .. end - 1. */
typedef vor_status (*toy_task)(void *ctx, size_t begin, size_t end, struct vor_error *err);

/** Where part `part` of n rows begins. */
size_t toy_part(const struct toy_steps *steps, size_t n, uint32_t part);

/** Goes through the stage: does a part of n rows with each step, waits until the step has lasted
 *  long enough, and tells the watch. Without a clock nothing is waited for.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  what the watch answered: parts from record.step on are
 *                                          not done; as the task */
VOR_NODISCARD vor_status toy_go_through(struct toy_steps *steps, size_t n, toy_task task, void *ctx,
                                        struct vor_error *err);

#endif
