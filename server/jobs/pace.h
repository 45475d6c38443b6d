/** How far a run is and how long it still takes, from its records and what its request allows. The
 *  daemon and the command line both reckon with this. */
#ifndef VOR_SERVER_JOBS_PACE_H
#define VOR_SERVER_JOBS_PACE_H

#include "core/report.h"
#include "core/spec.h"

#include <stdint.h>

/** Steps of the polish that the request allows at most. */
uint32_t vor_pace_polish(const struct vor_spec *spec);

/** Share of the run that is done, 0 .. 1. Iterations and steps of the polish count alike; once the
 *  polish has begun, the iterations are done, however many there were. A budget of seconds counts
 *  where more of it is used up. */
double vor_pace_done(const struct vor_spec *spec, const struct vor_record *record);

/** Seconds from `record` until all that the request allows is done, at the pace since `first` (all
 *  zero: since the run began); -1 while there is no pace. A step of the polish is taken to last as
 *  long as an iteration until there has been one: rather too long than too short. */
double vor_pace_left(const struct vor_spec *spec, const struct vor_record *first,
                     const struct vor_record *record);

/** The record that the pace is reckoned from: the first one, and in the polish, whose steps take
 *  another time than iterations, the last one before it. All zero before the first record. */
struct vor_pace {
    int began;
    struct vor_record first, last;
};

/** Takes in the next record of the run. */
void vor_pace_add(struct vor_pace *pace, const struct vor_record *record);

#endif
