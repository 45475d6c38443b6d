/** Gaps between seeds: places farther from all of them than in a lattice. Repulsion alone opens
 *  them where regions of different orientation meet.
 *
 *  Source: none of the papers. The farthest corner of a seed's Voronoi cell is the middle of the
 *  widest gap next to it. While seeds repel each other it pulls them; at the end those around a gap
 *  that is still wide go towards it once, by all that it is too wide, and nothing pushes back. */
#ifndef VOR_SEEDS_GAPS_H
#define VOR_SEEDS_GAPS_H

#include "core/seeds/seeds.h"

/** Pitches from the middle of a gap to the seeds around it: a wider one pulls. In a lattice it is
 *  0.577. At 0.6 / 0.65 / 0.7: igea 0.0216 / 0.0176 / 0.0172, fandisk 0.0235 / 0.0197 / 0.0192;
 *  above, gaps stay: largest one on igea 0.706 spacings at 0.65, 0.732 at 0.7 (one seed). */
#define VOR_GAP_WIDE 0.65
/** The pull of paces that stay the same: share of the excess that one step goes. At 0.075 / 0.15 /
 *  0.3: igea 0.0172 / 0.0176 / 0.0185, fandisk 0.0188 / 0.0197 / 0.0218. */
#define VOR_GAP_PULL 0.15

struct vor_gaps {
    float *pull;          /**< n x 3: towards the widest gap next to each seed */
    unsigned char *quiet; /**< n: no gap is next to it, as of the last look */
    double pitch;         /**< of the hexagonal lattice of as many seeds on the same area */
    double wide;          /**< pitches: wider ones are gaps */
    double share;         /**< of what is too wide, which a seed is pulled by */
};

/** Sets the pull of seed i, whose cell is at hand, and whether it is quiet. */
void vor_gaps_find(const struct vor_gaps *gaps, const struct vor_seeds *seeds,
                   const struct vor_scratch *scratch, size_t i);

/** Narrows gaps by one move of the seeds around them, but for quiet ones and those near a border.
 *  Much wider gaps stay: there is something in the way that closes none of them.
 *
 *  @param[in]     gaps    as of the last look; pull and quiet change
 *  @param[in,out] seeds   xyz changes
 *  @param[out]    next    3 n, for its own use
 *  @param[in]     recall  of last fits
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  O(n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_gaps_narrow(const struct vor_gaps *gaps, struct vor_seeds *seeds,
                                         float *next, const struct vor_recall *recall,
                                         struct vor_error *err);

#endif
