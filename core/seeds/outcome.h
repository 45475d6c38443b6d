/** What a method says of its run, besides the points. */
#ifndef VOR_SEEDS_OUTCOME_H
#define VOR_SEEDS_OUTCOME_H

#include "core/report.h"

/** Begins all zero; each part of the method fills in what it did. Members that a method has no use
 *  for stay 0. */
struct vor_outcome {
    enum vor_stopped stopped;
    unsigned stages;                     /**< gone through: bits of 1 << VOR_RUN_STAGE_... */
    uint32_t steps[VOR_RUN_STAGE_COUNT]; /**< done, of each of them */
    double seconds[VOR_RUN_STAGE_COUNT]; /**< that each of them took */
    double seconds_start;                /**< placing the first points */
    struct vor_record last;              /**< as told to the watch */
    double area;                         /**< of the surface, normalised: the cells' sum; 0 where
                                              the method has none */
    uint64_t held, held_ever;            /**< points held back at the border: in the last step, and
                                              in any */
    uint64_t fallback_plane;             /**< points on a plane in the last step */
    uint64_t fallback_left;              /**< points left in place in the last step: no surface */
    int refined;                         /**< the last step tried finer fits (vor_seeds_refine) */
};

/** Notes that the method went through a stage. */
static inline void vor_outcome_stage(struct vor_outcome *told, enum vor_run_stage stage,
                                     uint32_t steps, double seconds)
{
    told->stages |= 1U << stage;
    told->steps[stage] += steps;
    told->seconds[stage] += seconds;
}

#endif
