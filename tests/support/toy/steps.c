#include "tests/support/toy/steps.h"

#include <math.h>
#include <time.h>

struct toy_steps toy_steps_of(const struct vor_spec *spec, const struct vor_run *run)
{
    static const double blink = 0.05;
    double pause = spec->value[VOR_PARAM_PAUSE];
    struct toy_steps steps = {.run = run, .record = {.of = (uint32_t)spec->value[VOR_PARAM_PARTS]}};

    if (vor_spec_form(spec, VOR_PARAM_PAUSE) == VOR_FORM_WORD)
        pause = pause == VOR_WORD(1) ? blink : 0;
    steps.pause = pause;
    /* Nothing here is iterated: no such member has a value. */
    steps.record.delta = steps.record.sigma = steps.record.epsilon = (double)NAN;
    steps.record.energy = steps.record.max_move = (double)NAN;
    vor_record_unknown_best(&steps.record);
    return steps;
}

static vor_status answered(enum vor_answer answer, struct vor_error *err)
{
    if (answer == VOR_CONTINUE)
        return VOR_OK;
    return answer == VOR_STOP ? vor_fail(err, VOR_E_STOPPED, "stopped by the caller")
                              : vor_fail(err, VOR_E_CANCELLED, "cancelled by the caller");
}

static vor_status tell(struct toy_steps *steps, struct vor_error *err)
{
    const struct vor_watch *watch = steps->run->watch;

    steps->record.seconds = vor_run_seconds(steps->run);
    if (watch == NULL || watch->progress == NULL)
        return VOR_OK;
    return answered(watch->progress(watch->ctx, &steps->record), err);
}

vor_status toy_enter(struct toy_steps *steps, enum vor_run_stage stage, uint32_t others,
                     struct vor_error *err)
{
    steps->record.stage = stage;
    steps->record.step = 0;
    steps->record.ahead = others * steps->record.of;
    return tell(steps, err);
}

/* Waits until a step that began then has lasted long enough. Without a clock it has. */
static vor_status wait(const struct toy_steps *steps, double began, struct vor_error *err)
{
    static const struct timespec blink = {0, 1000000};
    const struct vor_watch *watch = steps->run->watch;
    vor_status status = VOR_OK;

    if (watch == NULL || watch->clock == NULL)
        return VOR_OK;
    while (status == VOR_OK && vor_run_clock(steps->run) < began + steps->pause) {
        (void)nanosleep(&blink, NULL);
        if (watch->poll != NULL)
            status = answered(watch->poll(watch->ctx), err);
    }
    return status;
}

size_t toy_part(const struct toy_steps *steps, size_t n, uint32_t part)
{
    return (size_t)((double)n * part / steps->record.of);
}

vor_status toy_go_through(struct toy_steps *steps, size_t n, toy_task task, void *ctx,
                          struct vor_error *err)
{
    struct vor_record *record = &steps->record;
    vor_status status = VOR_OK;

    while (status == VOR_OK && record->step < record->of) {
        double began = vor_run_clock(steps->run);

        status =
            task(ctx, toy_part(steps, n, record->step), toy_part(steps, n, record->step + 1), err);
        if (status == VOR_OK)
            status = wait(steps, began, err);
        record->step++;
        if (status == VOR_OK)
            status = tell(steps, err);
    }
    return status;
}
