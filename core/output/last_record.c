#include "core/output/last_record.h"

struct vor_record vor_last_record(const struct vor_outcome *told, const struct vor_report *report)
{
    struct vor_record record = told->last;

    if (told->steps[VOR_RUN_STAGE_POLISH] > 0 && record.stage != VOR_RUN_STAGE_POLISH) {
        record.stage = VOR_RUN_STAGE_POLISH; /* it was stopped before its first record */
        record.of = record.ahead;
        record.ahead = 0;
    }
    record.step = told->steps[record.stage];
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
    struct vor_record record;

    if (told->stages == 0 ||
        (told->last.iteration == report->iterations && told->last.polish == report->polish_steps &&
         told->last.best_delta == report->delta && told->last.best_sigma == report->sigma &&
         told->last.best_epsilon == report->epsilon))
        return VOR_OK;
    record = vor_last_record(told, report);
    record.seconds = vor_run_seconds(run);
    return vor_run_tell(run, &record) == VOR_CANCEL ? vor_run_answered(VOR_CANCEL, err) : VOR_OK;
}
