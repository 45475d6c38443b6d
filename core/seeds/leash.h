/** How far the points of a sequence go: no farther from where they were than those around them.
 *
 *  A frame with noise shows another surface, and so do fits where two sides are near, though
 *  nothing moved. Points that follow it go a spacing and more, and push others along. So each step
 *  leaves a point within its reach of its former place: the mean way from there of it and those
 *  around it as the polish begins, a new one's counted as a spacing, times (VOR_SEEDS_COHERENT /
 *  coherence)^2. That is hardly more than the mean way where the surface is at rest, and no limit
 *  where it moves.
 *
 *  At rest with noise of 0.2 spacings, frames 1 to 5 of 5,000 points, movement from frame to frame
 *  over that of single runs, without / with: fandisk 0.50 / 0.21, armadillo 0.69 / 0.28, bunny 0.67
 *  / 0.27; delta over theirs 1.15 / 0.87, 1.15 / 0.93, 1.21 / 1.02. Two degrees a frame, 10,000
 *  points: mean delta of an armadillo 0.0590 / 0.0573, of fandisk 0.0364 / 0.0381. By the first
 *  power instead of the second they move by 0.02 to 0.03 less, but fandisk has 0.0433 there.
 *
 *  Over 30 frames of 20,000 points: fandisk at rest 0.098 and 1.03, from 1.09 to 1.14 in frames 1
 * to 3 and below 1 at the end; a bunny with that noise that turns by 2 degrees a frame keeps 0.98
 * of its points, delta between 0.040 and 0.060 without growing.
 *
 *  The last steps of the polish are free, so that points even out: with them all held, delta of
 *  igea and a torus is 1.12 and 1.11 times that of single runs, else 0.97 and 1.04.
 *
 *  Source: none. */
#ifndef VOR_SEEDS_LEASH_H
#define VOR_SEEDS_LEASH_H

#include "core/seeds/seeds.h"

struct vor_leash {
    float (*at)[4]; /**< of each seed: x, y, z of its former place and its reach, infinite for a new
                         one; normalised. NULL: no seed has one */
    size_t size;    /**< of at, in bytes */
};

/** Measures the reach of seeds where they are, and indexes them. Leaves *out all zero without an
 *  earlier result or if no point of it lives on.
 *
 *  @param[out] out  free with vor_leash_free, whatever it returns
 *
 *  @retval VOR_E_NOMEM  20 bytes for each seed and 8 for each earlier point do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool. The same for any number of threads. */
VOR_NODISCARD vor_status vor_leash_make(struct vor_leash *out, struct vor_seeds *seeds,
                                        struct vor_error *err);

/** Takes x, the place that seed i is meant to go to, back within its reach. */
void vor_leash_hold(const struct vor_leash *leash, size_t i, double x[3]);

void vor_leash_free(struct vor_leash *leash, struct vor_memory *memory);

#endif
