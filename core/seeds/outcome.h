/** What a method tells about its run, besides the points. */
#ifndef VOR_SEEDS_OUTCOME_H
#define VOR_SEEDS_OUTCOME_H

#include "core/report.h"

/** All zero at first; each part of the method adds what it did. Members that a method does not use
 *  stay 0. */
struct vor_outcome {
    enum vor_stopped stopped;
    unsigned stages;                     /**< gone through: bits 1 << VOR_RUN_STAGE_... */
    uint32_t steps[VOR_RUN_STAGE_COUNT]; /**< done in each stage */
    double seconds[VOR_RUN_STAGE_COUNT]; /**< that each stage took */
    double seconds_start;                /**< that placing the first points took */
    struct vor_record last;              /**< the last record, as the watch got it */
    struct vor_record kept;              /**< that of the positions handed over */
    double area;                         /**< of the surface: the sum of the cells, in squared
                                              normalised units; 0 if the method has no cells */
    double area_even;                    /**< with a density, each cell's over the square of the
                                              value of the field; else the same */
    uint64_t held, held_ever;            /**< points held back at the border: in the last step, in
                                              any step */
    uint64_t fallback_plane;             /**< points on a plane in the last step */
    uint64_t fallback_left;              /**< points left in place in the last step: no surface */
    uint64_t inner_steps, evaluations;   /**< of a descent of an energy, and of that energy */
    double worst_descent;                /**< largest energy after the steps of an iteration over
                                              that before */
    double aspect;                       /**< median of the cells */
    int oriented;                        /**< the method looked for the sides of the input */
    size_t one_sided;                    /**< components of the input that have one side only,
                                              where it did */
    VOR_FIELD_WARNINGS(warnings)
    int refined; /**< the last step tried finer fits (vor_seeds_refine) */
};

/** Notes that the method went through a stage, or through more steps of it. */
static inline void vor_outcome_stage(struct vor_outcome *told, enum vor_run_stage stage,
                                     uint32_t steps, double seconds)
{
    told->stages |= 1U << stage;
    told->steps[stage] += steps;
    told->seconds[stage] += seconds;
}

#endif
