/** The sum of the forces by which the points around a point repel it (seeds/repel.h), of four
 * points at once: each step of the polish asks it of nearly all points. */
#ifndef VOR_SEEDS_FORCES_H
#define VOR_SEEDS_FORCES_H

#include <stddef.h>
#include <stdint.h>

/** Points that are summed at once. */
#define VOR_FORCES_BATCH 4

/** How points repel each other. */
struct vor_forces {
    float h2;       /**< square of the mean spacing */
    float reach2;   /**< points farther than this, over their squared spacing, do not count */
    float overlap2; /**< of points nearer than this, over the same, the sum is not to be used */
    float most;     /**< largest weight of a point */
    unsigned power; /**< S: a point at the distance d has the weight (h/d)^(2S) */
};

/** Sums the offsets from the listed points to point i, times their weights.
 *
 *  @param[out] sum    3 floats
 *  @param[in]  at     of each point 4 floats: its place, and the spacing that it is to have over
 * the mean; a pair has the larger of both
 *  @param[in]  list   points other than i
 *  @param[in]  count  of these; a multiple of VOR_FORCES_BATCH
 *
 *  @return false where one of them nearly coincides with point i: their offset says little
 *
 *  O(count). Thread-safe. The same bits on all machines. */
int vor_forces_sum(float sum[3], const struct vor_forces *how, const float *at, size_t i,
                   const uint32_t *list, unsigned count);

#endif
