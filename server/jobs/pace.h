/** How far a run is and how long it still takes, from its records and the time that its request
 * allows. The daemon and the command line both reckon with this. */
#ifndef VOR_SERVER_JOBS_PACE_H
#define VOR_SERVER_JOBS_PACE_H

#include "core/report.h"
#include "core/spec.h"

/** What is kept of the records of a run. All zero before the first. */
struct vor_pace {
    int began;
    double all;    /**< steps that the run takes at most: those of its first stage and all ahead */
    double before; /**< seconds that a step of the stage before took; 0 where that is not known */
    struct vor_record last;
    /** The record that the pace is reckoned from: the first one and, in a later stage, whose steps
     * take another time, that of its 0 steps, or where there was none, the last one before it. */
    struct vor_record origin;
};

/** Takes in the next record of the run. A run that begins again starts with an empty pace. */
void vor_pace_add(struct vor_pace *pace, const struct vor_record *record);

/** Share of the run that is done, 0 .. 1. The steps of all stages count alike, and those that a
 * stage did not need are done once the next one has begun. A budget of seconds counts where more of
 * it is used up. 0 before the first record, and where a record does not say how many steps its
 * stage takes. */
double vor_pace_done(const struct vor_pace *pace, const struct vor_spec *spec);

/** Seconds from the last record until all steps that may come are done, or the budget is used up;
 * -1 while there is no pace: before the second record, and where a record does not say how many
 * steps its stage takes. A step of a stage is taken to last as long as one of the stage before
 * until there has been one: rather too long than too short. */
double vor_pace_left(const struct vor_pace *pace, const struct vor_spec *spec);

#endif
