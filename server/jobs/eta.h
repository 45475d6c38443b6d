/** How far a run is and how long it still takes, from its request, its records and what its stages
 * cost beside each other. The daemon and the command line both reckon with this. */
#ifndef VOR_SERVER_JOBS_ETA_H
#define VOR_SERVER_JOBS_ETA_H

#include "core/report.h"
#include "core/spec.h"

/** What a run has to do. All zero where that is not known: times are then only compared with each
 * other. */
struct vor_eta_work {
    double points_in;
    double points_out; /**< that are asked for */
    unsigned threads;
    enum vor_method_choice method;
    double samples; /**< points that wlop and ear project; ear inserts the others */
};

/** The work of a run of a request on so many points, by so many threads; all zero where the request
 * does not say how many points it makes, or has another method than cvt, wlop and ear. */
struct vor_eta_work vor_eta_work_of(const struct vor_spec *spec, uint64_t points, unsigned threads);

/** What is kept of the records of a run. All zero before the first, but for the work. */
struct vor_eta {
    struct vor_eta_work work;
    int began;
    double all;    /**< steps that the run takes at most, as vor_eta_done counts them: those of its
                        first stage and all ahead */
    double before; /**< how slow the stage before was; 0 where that is not known */
    struct vor_record last;
    /** The record that the estimate is reckoned from: the first one and, in a later stage, whose
     * steps take another time, that of its 0 steps, or where there was none, the last one before
     * it. */
    struct vor_record origin;
};

/** Takes in the next record of the run. A run that begins again starts with an empty one. */
void vor_eta_add(struct vor_eta *eta, const struct vor_record *record);

/** Share of the run that is done, 0 .. 1. The steps of all stages count alike, those of wlop and
 * ear, where the work is known, by what they usually take; those that a stage did not need are done
 * once the next one has begun. A budget of seconds counts where more of it is used up. 0 before the
 * first record, and where a record does not say how many steps its stage takes. */
double vor_eta_done(const struct vor_eta *eta, const struct vor_spec *spec);

/** Seconds from the last record, or before it from the beginning, until the run ends, or its budget
 * is used up. -1 where that is not known: without a record, or with one of no steps, if the work is
 * not known, for processes without a method, and where a record does not say how many steps its
 * stage takes.
 *
 * Steps to come take what they usually take beside those that were done (eta.c), and a run without
 * a polish the usual number of iterations, if the request gives none. Before the first step, times
 * are those of the machine they were measured on. */
double vor_eta_left(const struct vor_eta *eta, const struct vor_spec *spec);

#endif
