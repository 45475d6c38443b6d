/** A stage of a run: points move step by step until the request or the caller stops them. The one
 *  loop of all methods: after each step it measures, keeps the best positions, tells the watch, and
 *  asks whether a stop is reached. */
#ifndef VOR_SEEDS_STAGE_H
#define VOR_SEEDS_STAGE_H

#include "core/metrics/uniformity.h"
#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

/** Share of the time allowed that a stage takes which another one follows. */
#define VOR_STAGE_SHARE 0.5

/** Room for the parts that a method adds to a checkpoint. */
#define VOR_STAGE_SLOTS 5

struct vor_stage;

/** A part of a step. Positions, and what the record tells of them, may change.
 *
 *  @retval VOR_E_STOPPED  the run is stopped: a step then does not count. None of a measurement,
 *                         which a stop does not interrupt */
typedef vor_status (*vor_stage_part)(struct vor_stage *stage, struct vor_error *err);

/** A stage. Lengths of the record are in the unit of the cloud. */
struct vor_stage {
    const struct vor_spec *spec; /**< read: delta, eta, moveStop, seconds */
    const struct vor_run *run;   /**< may be stopped */
    struct vor_outcome *told;
    struct vor_record
        record; /**< stage, of and ahead are the method's; step, seconds, iteration,
                     polish and best the loop's; the rest is of the last measurement */
    const struct vor_domain *domain; /**< what is told counts from it */
    float *xyz;                      /**< n x 3 */
    size_t n;
    void *of;               /**< the method's */
    vor_stage_part step;    /**< moves the points; where there is no measure, measures them too */
    vor_stage_part measure; /**< measures them; NULL: see step */
    unsigned measure_every; /**< steps from one measurement to the next, before the last ones */
    unsigned measure_last;  /**< last steps, which are measured one by one */
    unsigned tell_every;    /**< steps from one record for the watch to the next; 0: 1 */
    /** Whether the method ends the stage for a reason of its own; asked once for each step where
     *  nothing else does; NULL: never. */
    int (*ends)(struct vor_stage *stage);
    double share;   /**< of the time that the request allows; 0: the stage asks for none */
    int follows;    /**< another stage: it has no record of 0 steps, and if it makes all of its own,
                         why the run stopped is what that one says */
    int unfinished; /**< delta, eta and moveStop do not count yet */
    int keep_last;  /**< the positions kept are the last ones, not the most even */
    int saves;      /**< checkpoints are made of it (seeds/checkpoint.h): it has seeds */
    struct vor_part part[VOR_STAGE_SLOTS]; /**< then, what of the method's its next step reads */
    double moved;   /**< in the last step, by the farthest, in spacings of an even spread; infinite
                         where the method does not tell */
    double eta;     /**< of the last measurement; infinite where the request has none to stop at */
    double spacing; /**< mean distance to the nearest neighbour, normalised, as of the last
                         measurement */

    struct vor_seeds *seeds; /**< set by vor_stage_of_seeds; NULL: positions are not kept, the last
                                  ones are the result */
    float *nearest;          /**< scratch of seeds: distance of each to its nearest neighbour */
    float *best_xyz;         /**< the positions kept, n x 3 */
    struct vor_record best;  /**< their record */
    double took;             /**< seconds, by the last step */
};

/** Prepares a stage of seeds, whose other members are set, and takes their positions as the first.
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for
 *  @retval VOR_E_NOMEM      16 n bytes do not fit
 *
 *  O(n log n). Free with vor_stage_free, whatever it returns. */
VOR_NODISCARD vor_status vor_stage_of_seeds(struct vor_stage *stage, struct vor_seeds *seeds,
                                            struct vor_error *err);

/** Frees what is kept of seeds. */
void vor_stage_free(struct vor_stage *stage);

/** Measures how even the seeds are where they are, as a stop does not interrupt
 *  (vor_seeds_uniformity_now). */
VOR_NODISCARD vor_status vor_stage_measure(struct vor_stage *stage, struct vor_error *err);

/** Writes how even the points are into the record. */
void vor_stage_note(struct vor_stage *stage, const struct vor_uniformity *even);

/** Writes the longest of the points' last steps, n x 3, into the record. O(n). */
void vor_stage_note_move(struct vor_stage *stage, const float *step);

/** Measures the seeds and keeps them however even they are: those before no longer count. Fails as
 *  vor_seeds_uniformity_now. */
VOR_NODISCARD vor_status vor_stage_restart(struct vor_stage *stage, struct vor_error *err);

/** Whether delta, eta or moveStop of the request is reached, even if they do not count yet. */
int vor_stage_is_enough(const struct vor_stage *stage);

/** Runs the stage, adds it to what is told, and puts seeds to the positions kept. A stop by the
 *  caller is no failure: told->stopped says so.
 *
 *  @retval VOR_E_CANCELLED  the watch answered VOR_CANCEL
 *  @retval others           of the parts */
VOR_NODISCARD vor_status vor_stage_run(struct vor_stage *stage, struct vor_error *err);

/** Whether the run was stopped because the time that the request allows is over. */
int vor_stage_was_late(const struct vor_outcome *told, const struct vor_spec *spec,
                       const struct vor_run *run);

#endif
