/** A result beside its input: how far the two are from each other, and how many of the result's
 * points lie where the input ends (geom/boundary.h, the rim).
 *
 *  Source: none of the papers. A point lies at the border when the points around it leave an angle
 * of more than 130 degrees free (a missing neighbour leaves 120, a straight border 180), and the
 * input ends that way: around the input point nearest to a place most of a spacing ahead, the input
 * goes on to one side only, and not ahead. The first alone would count what chance leaves free in a
 * result that is not even, the second alone more than one row of points, or none where the input is
 * dense. Measured: none on closed smooth clouds; of a thousand points, up to five at sharp edges or
 * in a mere draw (iterations 0). Along borders, their length over the spacing within a tenth, and
 * up to a quarter fewer where the input has no more points than the result: it ends raggedly then.
 */
#ifndef VOR_OUTPUT_COMPARE_H
#define VOR_OUTPUT_COMPARE_H

#include "core/seeds/seeds.h"

#define VOR_COMPARE_POINTS 200000 /**< input points that are looked at, at most */

/** Of the distances from points to the nearest of others, normalised. */
struct vor_compare_apart {
    double mean, rms, max;
    uint64_t points; /**< that were looked at */
};

struct vor_comparison {
    struct vor_compare_apart in_to_out; /**< from the domain's points: all, or where there are more,
                                     VOR_COMPARE_POINTS of them at equal steps along their order */
    struct vor_compare_apart out_to_in; /**< from all seeds */
    uint64_t border;                    /**< seeds at the border of the input */
    uint64_t fitted[VOR_NEIGHBORS_MAX + 1]; /**< seeds whose surface was fitted to so many points */
};

/** Compares the result with the input. Seeds are on the whole domain and indexed where they are.
 *
 *  @param[in] spacing  mean distance of a seed to the nearest other one
 *  @param[in] refined  the last step of the method tried finer fits (vor_outcome.refined)
 *
 *  @retval VOR_E_NOMEM 44 bytes for each seed, and a little, do not fit
 *  @retval VOR_E_CANCELLED  as vor_run_for
 *
 *  O(n log n). Sums run in block order: the same bits for any number of threads. */
VOR_NODISCARD vor_status vor_compare(struct vor_comparison *out, struct vor_seeds *seeds,
                                     double spacing, int refined, struct vor_error *err);

#endif
