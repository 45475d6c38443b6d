/** Compares a result with its input: how far the two are from each other, and how many of the
 *  result's points lie where the input ends (geom/boundary.h, the rim).
 *
 *  Source: none of the papers. A point lies at the border when the points around it leave an angle
 *  of more than 130 degrees free (a missing neighbour leaves 120, a straight border 180) and the
 *  input ends that way: around the input point nearest to a place most of a spacing ahead, the
 *  input extends to one side only, and not ahead. The first test alone would count angles that
 *  chance leaves free in an uneven result, the second alone more than one row of points, or none
 *  where the input is dense. Measured: none on closed smooth clouds; up to five of a thousand
 *  points at sharp edges or in a mere draw (iterations 0). Along borders their number is the length
 *  over the spacing within a tenth, and up to a quarter less where the input has no more points
 *  than the result, because it ends raggedly then. */
#ifndef VOR_OUTPUT_COMPARE_H
#define VOR_OUTPUT_COMPARE_H

#include "core/metrics/mls_error.h"
#include "core/seeds/seeds.h"

/** Most input points whose distance to the result is taken. Their rms is then within 0.2 % of that
 *  of all: it varies by about half of itself from point to point. */
#define VOR_COMPARE_POINTS 200000
/** The same for the geometric error, which costs ten times as much a point: with 10,000 points of
 *  a result 0.07 s of CPU in all. */
#define VOR_COMPARE_ERROR_POINTS 10000

/** Distances from points to the nearest of others, normalised. */
struct vor_compare_apart {
    double mean, rms, max;
    uint64_t points; /**< whose distances these are */
};

/** What a comparison finds. */
struct vor_comparison {
    /** From the domain's points, or VOR_COMPARE_POINTS of them at equal steps along their order. */
    struct vor_compare_apart ref_to_out;
    struct vor_compare_apart out_to_ref;    /**< from all seeds */
    struct vor_mls_error mls_error;         /**< if there are VOR_MLS_ERROR_LEAST seeds or more */
    uint64_t border;                        /**< seeds at the border of the input */
    uint64_t fitted[VOR_NEIGHBORS_MAX + 1]; /**< fitted[k]: seeds whose surface is fitted to k */
};

/** Compares the result with the input.
 *
 *  @param[in] seeds    on the whole domain, and indexed where they are (vor_seeds_index)
 *  @param[in] spacing  mean distance of a seed to the nearest other one
 *  @param[in] refined  the last step of the method tried finer fits (vor_outcome.refined)
 *
 *  @retval VOR_E_NOMEM 44 bytes for each seed, and a little, do not fit
 *  @retval VOR_E_CANCELLED  as vor_run_for
 *
 *  O(n log n), on the run's pool. Sums run in block order: the same bits for any number of threads.
 */
VOR_NODISCARD vor_status vor_compare(struct vor_comparison *out, struct vor_seeds *seeds,
                                     double spacing, int refined, struct vor_error *err);

/** Measures the distances from the domain's points to the nearest seed alone: ref_to_out of a
 *  comparison.
 *
 *  @param[out] error  mls_error of a comparison; NULL: it is not measured
 *  @param[in]  seeds  read: domain, n, xyz, run
 *
 *  Fails as vor_compare. O(n log n), on the run's pool. The same bits for any number of threads. */
VOR_NODISCARD vor_status vor_compare_ref_to_out(struct vor_compare_apart *out,
                                                struct vor_mls_error *error,
                                                struct vor_seeds *seeds, struct vor_error *err);

#endif
