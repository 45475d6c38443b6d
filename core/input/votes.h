/** What two sheets fitted together say of pairs of points: on one sheet, or on two.
 *
 *  Around each point near which sheets were found, two of them are fitted to the points nearest to
 *  it (geom/twofold.h), several times to more and fewer. Each fit votes on pairs of the very
 *  nearest, the more the farther apart the sheets are there over what the points are off. Votes of
 *  many fits on one pair add up: each alone is wrong too often where sheets cross.
 *
 *  Of pairs on two wavy sheets 0.4 spacings apart that the sums are sure of to 99 %, 127 and 182
 *  of 233,000 are told wrong (6,000 points, two seeds).
 *
 *  Source: none of the papers; log odds add up as those of independent witnesses do. These are not
 *  quite such (VOTES_SHARE in input/regions.c). */
#ifndef VOR_INPUT_VOTES_H
#define VOR_INPUT_VOTES_H

#include "core/input/domain.h"

/** Points that a fit votes on, the nearest to its place; and fits there. */
enum { VOR_VOTES_MEMBERS = 22, VOR_VOTES_FITS = 3 };

/** The votes of the fits around one point. */
struct vor_votes_of {
    uint32_t member[VOR_VOTES_MEMBERS];
    signed char says[VOR_VOTES_FITS][VOR_VOTES_MEMBERS]; /**< of one sign on one side, the larger
                                                            the surer; all 0: no vote */
};

/** All zero: no votes. */
struct vor_votes {
    struct vor_memory *memory;
    struct vor_votes_of *of; /**< n */
};

/** Makes the votes around points where fits are made to lists of one sheet (graph->own); none where
 *  there are fewer points than a fit takes.
 *
 *  @param[out] out  free with vor_votes_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 156 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n), 80 us for each of those points, on the run's pool. The same votes for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_votes_make(struct vor_votes *out, const struct vor_domain *domain,
                                        const struct vor_graph *graph, const struct vor_run *run,
                                        struct vor_error *err);

/** votes may be all zero. */
void vor_votes_free(struct vor_votes *votes);

/** Most points of vor_votes_hear. */
enum { VOR_VOTES_HEARD = 3 * VOR_NEIGHBORS_FEWEST };

/** Adds up what is said of one point and each of those nearest to it: the log odds that both are on
 *  one sheet; below 0 they are on two, and 0 where nothing is said.
 *
 *  @param[out] odds   count
 *  @param[in]  index  the points nearest to point i; it may be among them
 *  @param[in]  count  at most VOR_VOTES_HEARD
 *
 *  O(count). Cannot fail. Thread-safe. */
void vor_votes_hear(double *odds, const struct vor_votes *votes, uint32_t i, const uint32_t *index,
                    unsigned count);

#endif
