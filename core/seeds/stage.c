#include "core/seeds/stage.h"

#include "core/base/linalg.h"
#include "core/seeds/checkpoint.h"
#include "core/seeds/uniformity.h"

#include <math.h>
#include <string.h>

vor_status vor_stage_of_seeds(struct vor_stage *stage, struct vor_seeds *seeds,
                              struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;

    stage->seeds = seeds;
    stage->domain = seeds->whole;
    stage->xyz = seeds->xyz;
    stage->n = seeds->n;
    stage->nearest = vor_malloc(memory, seeds->n, sizeof *stage->nearest);
    stage->best_xyz = vor_malloc(memory, seeds->n, 3 * sizeof *stage->best_xyz);
    if (stage->nearest == NULL || stage->best_xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    return vor_stage_restart(stage, err);
}

void vor_stage_free(struct vor_stage *stage)
{
    if (stage->seeds == NULL)
        return;
    VOR_FREE_ALL(stage->seeds->run.memory, stage->best_xyz, stage->nearest);
}

void vor_stage_note(struct vor_stage *stage, const struct vor_uniformity *even)
{
    stage->spacing = even->mean;
    stage->record.delta = even->delta;
    stage->record.sigma = even->sigma * stage->domain->unit;
    stage->record.epsilon = even->epsilon;
}

void vor_stage_note_move(struct vor_stage *stage, const float *step)
{
    double longest = 0;

    for (size_t i = 0; i < stage->n; i++) {
        double length2 = vor_dotf(&step[3 * i], &step[3 * i]);

        longest = length2 > longest ? length2 : longest; /* fmax crashes gcc 12 for arm64 */
    }
    stage->record.max_move = sqrt(longest) * stage->domain->unit;
}

vor_status vor_stage_measure(struct vor_stage *stage, struct vor_error *err)
{
    struct vor_uniformity even;
    vor_status status = vor_seeds_uniformity_now(&even, stage->nearest, stage->seeds, err);

    if (status == VOR_OK)
        vor_stage_note(stage, &even);
    return status;
}

/* Keeps the positions, of which the record is. */
static void keep(struct vor_stage *stage)
{
    stage->best = stage->record;
    if (stage->best_xyz != NULL)
        memcpy(stage->best_xyz, stage->xyz, 3 * stage->n * sizeof *stage->xyz);
}

vor_status vor_stage_restart(struct vor_stage *stage, struct vor_error *err)
{
    vor_status status = vor_stage_measure(stage, err);

    stage->eta = INFINITY;
    if (status == VOR_OK)
        keep(stage);
    return status;
}

static enum vor_answer tell_watch(struct vor_stage *stage)
{
    const struct vor_watch *watch = stage->run->watch;
    const struct vor_record *record = &stage->record;
    struct vor_moving moving = {.xyz = stage->xyz, .n = stage->n, .unit = stage->domain->unit};

    stage->told->last = *record;
    memcpy(moving.shift, stage->domain->shift, sizeof moving.shift);
    if (watch != NULL && watch->progress != NULL && watch->points != NULL)
        watch->points(watch->ctx, &moving, record);
    return vor_run_tell(stage->run, record);
}

/* Keeps the positions if they are the best so far, and tells the watch if that is due. */
static enum vor_answer tell(struct vor_stage *stage, int is_due)
{
    struct vor_record *record = &stage->record;

    if (stage->seeds == NULL || stage->keep_last || record->delta < stage->best.delta)
        keep(stage);
    record->best_iteration = stage->best.iteration;
    record->best_polish = stage->best.polish;
    record->best_delta = stage->best.delta;
    record->best_sigma = stage->best.sigma;
    record->best_epsilon = stage->best.epsilon;
    return is_due ? tell_watch(stage) : VOR_CONTINUE;
}

static int is_even_enough(const struct vor_stage *stage)
{
    return vor_spec_given(stage->spec, VOR_PARAM_DELTA) &&
           stage->record.delta <= stage->spec->value[VOR_PARAM_DELTA];
}

static int is_regular_enough(const struct vor_stage *stage)
{
    return vor_spec_given(stage->spec, VOR_PARAM_ETA) &&
           stage->eta <= stage->spec->value[VOR_PARAM_ETA];
}

static int is_still(const struct vor_stage *stage)
{
    return vor_spec_given(stage->spec, VOR_PARAM_MOVE_STOP) &&
           stage->moved <= stage->spec->value[VOR_PARAM_MOVE_STOP];
}

int vor_stage_is_enough(const struct vor_stage *stage)
{
    return is_even_enough(stage) || is_regular_enough(stage) || is_still(stage);
}

static int is_late(const struct vor_spec *spec, double share, double seconds)
{
    return vor_spec_given(spec, VOR_PARAM_SECONDS) &&
           seconds > share * spec->value[VOR_PARAM_SECONDS];
}

int vor_stage_was_late(const struct vor_outcome *told, const struct vor_spec *spec,
                       const struct vor_run *run)
{
    return told->stopped == VOR_STOPPED_CALLER && is_late(spec, 1, vor_run_seconds(run));
}

/* Whether a stop is reached, other than by the method. */
static int is_over(struct vor_stage *stage)
{
    const struct vor_record *record = &stage->record;
    enum vor_stopped *stopped = &stage->told->stopped;

    if (!stage->unfinished && is_even_enough(stage))
        *stopped = VOR_STOPPED_DELTA;
    else if (!stage->unfinished && is_regular_enough(stage))
        *stopped = VOR_STOPPED_ETA;
    else if (!stage->unfinished && is_still(stage))
        *stopped = VOR_STOPPED_MOVE;
    else if (record->step >= record->of)
        *stopped = stage->follows ? *stopped : VOR_STOPPED_ITERATIONS;
    else if (stage->share > 0 && is_late(stage->spec, stage->share, record->seconds + stage->took))
        *stopped = VOR_STOPPED_SECONDS;
    else
        return 0;
    return 1;
}

/* Computes eta where the request has one to stop at. A stop keeps the positions that have it. */
static vor_status measure_eta(struct vor_stage *stage, struct vor_error *err)
{
    struct vor_cells cells;
    vor_status status;

    if (!vor_spec_given(stage->spec, VOR_PARAM_ETA) || stage->seeds == NULL ||
        stage->seeds->wanted.value != NULL)
        return VOR_OK;
    status = vor_seeds_index(stage->seeds, stage->run, err);
    VOR_THEN(status, vor_seeds_cells(&cells, stage->seeds, err));
    if (status != VOR_OK)
        return status;
    stage->eta = cells.open < stage->n ? cells.eta : INFINITY;
    stage->keep_last |= !stage->unfinished && is_regular_enough(stage);
    return VOR_OK;
}

static vor_status step(struct vor_stage *stage, struct vor_error *err)
{
    struct vor_record *record = &stage->record;
    double before = record->seconds;
    vor_status status = stage->step(stage, err);
    int is_due;

    if (status != VOR_OK)
        return status;
    record->step++;
    if (record->stage == VOR_RUN_STAGE_POLISH)
        record->polish = record->step;
    else if (record->stage != VOR_RUN_STAGE_INSERT)
        record->iteration = record->step;
    record->seconds = vor_run_seconds(stage->run);
    stage->took = record->seconds - before;
    is_due = stage->measure == NULL || record->step % stage->measure_every == 0 ||
             record->step + stage->measure_last >= record->of || is_over(stage);
    if (is_due && stage->measure != NULL)
        status = stage->measure(stage, err);
    if (is_due && status == VOR_OK)
        status = measure_eta(stage, err);
    if (status != VOR_OK)
        return status;
    return vor_run_answered(tell(stage, stage->tell_every < 2 ||
                                            record->step % stage->tell_every == 0 ||
                                            is_over(stage)),
                            err);
}

static struct vor_checkpoint_of checkpoint_of(struct vor_stage *stage)
{
    size_t row = 3 * stage->n * sizeof *stage->xyz;
    struct vor_checkpoint_of of = {.run = stage->run,
                                   .spec = stage->spec,
                                   .seeds = stage->seeds,
                                   .told = stage->told,
                                   .stage = stage->record.stage,
                                   .part = {{stage->best_xyz, row},
                                            {&stage->record, sizeof stage->record},
                                            {&stage->best, sizeof stage->best},
                                            {&stage->moved, sizeof stage->moved},
                                            {&stage->eta, sizeof stage->eta},
                                            {&stage->spacing, sizeof stage->spacing},
                                            {&stage->unfinished, sizeof stage->unfinished},
                                            {&stage->keep_last, sizeof stage->keep_last}}};

    memcpy(&of.part[VOR_CHECKPOINT_SLOTS - VOR_STAGE_SLOTS], stage->part, sizeof stage->part);
    return of;
}

/* Begins the loop, or goes on where a checkpoint was made. */
static vor_status begin(struct vor_stage *stage, int *goes_on, struct vor_error *err)
{
    const struct vor_checkpoint_of of = checkpoint_of(stage);
    vor_status status = VOR_OK;

    *goes_on = 0;
    if (stage->saves)
        status = vor_checkpoint_take(&of, goes_on, err);
    if (status != VOR_OK)
        return status;
    stage->record.seconds = vor_run_seconds(stage->run);
    if (*goes_on)
        return vor_run_answered(tell_watch(stage), err);
    stage->moved = stage->eta = INFINITY;
    if (stage->seeds == NULL)
        stage->best = stage->record;
    return stage->follows ? VOR_OK : vor_run_answered(tell(stage, 1), err);
}

static int ends(struct vor_stage *stage)
{
    return is_over(stage) || (stage->ends != NULL && stage->ends(stage));
}

static vor_status loop(struct vor_stage *stage, struct vor_error *err)
{
    int goes_on; /* with a step that was to follow when it was saved */
    vor_status status = begin(stage, &goes_on, err);

    while (status == VOR_OK && (goes_on || !ends(stage))) {
        const struct vor_checkpoint_of of = checkpoint_of(stage);

        if (stage->saves && !goes_on)
            vor_checkpoint_make(&of);
        goes_on = 0;
        status = step(stage, err);
    }
    if (status != VOR_E_STOPPED)
        return status;
    stage->told->stopped = VOR_STOPPED_CALLER;
    return VOR_OK;
}

vor_status vor_stage_run(struct vor_stage *stage, struct vor_error *err)
{
    struct vor_outcome *told = stage->told;
    double before = vor_run_clock(stage->run);
    vor_status status;

    if (stage->follows && (told->stopped == VOR_STOPPED_DELTA || told->stopped == VOR_STOPPED_ETA))
        /* its points have moved since */
        told->stopped = VOR_STOPPED_ITERATIONS;
    status = loop(stage, err);
    if (status != VOR_OK)
        return status;
    if (stage->best_xyz != NULL)
        memcpy(stage->xyz, stage->best_xyz, 3 * stage->n * sizeof *stage->xyz);
    told->kept = stage->best;
    if (!stage->follows || stage->record.step > 0)
        vor_outcome_stage(told, stage->record.stage, stage->record.step,
                          vor_run_clock(stage->run) - before);
    return VOR_OK;
}
