#include "server/jobs/pace.h"

#include <math.h>

/* Whether a record says how many steps its stage takes. One that did not begin needs none. */
static int is_known(const struct vor_record *record)
{
    return record->of > 0 || record->step == 0;
}

/* Steps that may still come. */
static double steps_left(const struct vor_record *record)
{
    return fmax((double)record->of - record->step, 0) + record->ahead;
}

/* Steps from one record to a later one; of a stage between them, none is known. */
static double steps_between(const struct vor_record *from, const struct vor_record *to)
{
    return from->stage == to->stage ? (double)to->step - from->step : to->step;
}

/* Seconds that a step takes: of the stage at hand, of the one before it until there has been one; 0
 * where none has. */
static double step_seconds(const struct vor_pace *pace)
{
    double steps = steps_between(&pace->origin, &pace->last);

    return steps > 0 ? (pace->last.seconds - pace->origin.seconds) / steps : pace->before;
}

static int has_pace(const struct vor_pace *pace)
{
    return steps_between(&pace->origin, &pace->last) > 0 || pace->before > 0;
}

void vor_pace_add(struct vor_pace *pace, const struct vor_record *record)
{
    if (!pace->began) {
        pace->origin = *record;
    } else if (record->stage != pace->last.stage) {
        pace->before = step_seconds(pace);
        pace->origin = record->step > 0 ? pace->last : *record;
    }
    pace->began = 1;
    pace->all = fmax(pace->all, (double)record->of + record->ahead);
    pace->last = *record;
}

double vor_pace_done(const struct vor_pace *pace, const struct vor_spec *spec)
{
    double budget = spec->value[VOR_PARAM_SECONDS], done = 0;

    if (pace->began && is_known(&pace->last))
        done = pace->all > 0 ? (pace->all - steps_left(&pace->last)) / pace->all : 1;
    if (vor_spec_given(spec, VOR_PARAM_SECONDS) && budget > 0)
        done = fmax(done, pace->last.seconds / budget);
    return fmax(fmin(done, 1), 0);
}

double vor_pace_left(const struct vor_pace *pace, const struct vor_spec *spec)
{
    double left;

    if (!has_pace(pace) || !is_known(&pace->last))
        return -1;
    left = step_seconds(pace) * steps_left(&pace->last);
    if (vor_spec_given(spec, VOR_PARAM_SECONDS))
        left = fmin(left, fmax(spec->value[VOR_PARAM_SECONDS] - pace->last.seconds, 0));
    return left;
}
