#include "server/jobs/pace.h"

#include <math.h>

uint32_t vor_pace_polish(const struct vor_spec *spec)
{
    return (uint32_t)spec->value[VOR_PARAM_POLISH];
}

/* Iterations and steps of the polish that may still come. */
static double steps_left(const struct vor_spec *spec, const struct vor_record *record)
{
    double iterations = (double)vor_spec_iterations(spec) - record->iteration;
    double polish = (double)vor_pace_polish(spec) - record->polish;

    if (record->polish > 0)
        iterations = 0;
    return fmax(iterations, 0) + fmax(polish, 0);
}

double vor_pace_done(const struct vor_spec *spec, const struct vor_record *record)
{
    double all = (double)vor_spec_iterations(spec) + vor_pace_polish(spec);
    double budget = spec->value[VOR_PARAM_SECONDS];
    double done = all > 0 ? (all - steps_left(spec, record)) / all : 1;

    if (vor_spec_given(spec, VOR_PARAM_SECONDS) && budget > 0)
        done = fmax(done, record->seconds / budget);
    return fmin(done, 1);
}

double vor_pace_left(const struct vor_spec *spec, const struct vor_record *first,
                     const struct vor_record *record)
{
    double steps =
        ((double)record->iteration - first->iteration) + ((double)record->polish - first->polish);
    double left;

    if (steps <= 0)
        return -1;
    left = (record->seconds - first->seconds) / steps * steps_left(spec, record);
    if (vor_spec_given(spec, VOR_PARAM_SECONDS))
        left = fmin(left, fmax(spec->value[VOR_PARAM_SECONDS] - record->seconds, 0));
    return left;
}

void vor_pace_add(struct vor_pace *pace, const struct vor_record *record)
{
    if (!pace->began)
        pace->first = *record;
    else if (record->polish > 0 && pace->last.polish == 0)
        pace->first = pace->last;
    pace->began = 1;
    pace->last = *record;
}
