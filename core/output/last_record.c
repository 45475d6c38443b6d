#include "core/output/last_record.h"

static int is_told(const struct vor_record *last, const struct vor_report *report)
{
    return last->iteration == report->iterations && last->polish == report->polish_steps &&
           last->best_delta == report->delta && last->best_sigma == report->sigma &&
           last->best_epsilon == report->epsilon;
}

/* Moves a record to the stage that the run ended in. */
static void end_stage(struct vor_record *record, const struct vor_outcome *told)
{
    if (told->steps[VOR_RUN_STAGE_POLISH] > 0 && record->stage != VOR_RUN_STAGE_POLISH) {
        record->stage = VOR_RUN_STAGE_POLISH; /* it was stopped before its first record */
        record->of = record->ahead;
        record->ahead = 0;
    }
    record->step = told->steps[record->stage];
}

struct vor_record vor_last_record(const struct vor_outcome *told, const struct vor_report *report)
{
    struct vor_record record = told->last;

    end_stage(&record, told);
    record.iteration = report->iterations;
    record.polish = report->polish_steps;
    record.delta = record.best_delta = report->delta;
    record.sigma = record.best_sigma = report->sigma;
    record.epsilon = record.best_epsilon = report->epsilon;
    record.best_iteration = told->kept.iteration;
    record.best_polish = told->kept.polish;
    return record;
}

vor_status vor_last_record_tell(const struct vor_outcome *told, const struct vor_report *report,
                                const struct vor_run *run, struct vor_error *err)
{
    const struct vor_watch *watch = run->watch;
    struct vor_record record;

    if (watch == NULL || watch->progress == NULL || told->stages == 0 ||
        is_told(&told->last, report))
        return VOR_OK;
    record = vor_last_record(told, report);
    record.seconds = vor_run_seconds(run);
    if (watch->progress(watch->ctx, &record) == VOR_CANCEL)
        return vor_fail(err, VOR_E_CANCELLED, "cancelled by the caller");
    return VOR_OK;
}
