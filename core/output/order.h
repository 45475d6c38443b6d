/** The order in which points are handed over, such that the first of them, however many, are spread
 * evenly over all of the surface.
 *
 * Source: farthest point first (Gonzalez 1985, "Clustering to minimize the maximum intercluster
 * distance"; Eldar et al. 1997, "The farthest point strategy for progressive image sampling"): the
 * next point is the one farthest from all before it.
 *
 * Departure: among all that are nearly that far, the next is the one that brings most points to a
 * nearest neighbour at that distance, and the last step of "nearly that far" takes in all points
 * about a spacing away, which are most of them. In even points any set of more than a third has
 * neighbours a spacing apart. Farthest first adds them anywhere, and delta stays high until each
 * has got one; here each new one ends the wait of as many as it can. Delta of the first half of
 * 20,000: 0.02 instead of 0.12.
 *
 * What can be had: in a perfect lattice of spacing s no two points are farther than s and nearer
 * than sqrt(3) s. So, with a share q of a subset's nearest neighbours beyond s, delta^2 >= (sqrt(3)
 * - 1)^2 q (1 - q) / (1 + (sqrt(3) - 1) q)^2. One more point changes the neighbours of at most six:
 * on the way from a subset that is even by itself (q = 1) to all (q = 0) q takes every value, and
 * delta passes 0.278, whatever the order. */
#ifndef VOR_OUTPUT_ORDER_H
#define VOR_OUTPUT_ORDER_H

#include "core/base/run.h"

#include <stddef.h>
#include <stdint.h>

/** order[] gets 0 .. n - 1, point 0 first. Points that coincide with one before them come last, by
 * index. Distances are Euclidean.
 *
 *  @param[in] xyz      n x 3 floats, n >= 1, each of magnitude at most 1e6; points near each other
 *                      best have near indices, as seeds have: beginnings are looked for among every
 *                      fourth, sixteenth ... point
 *  @param[in] spacing  mean distance to the nearest neighbour; 0 where not known
 *
 *  @retval VOR_E_NOMEM                      28 n bytes, 52 for each of the first 32nd, and a little
 *                                           do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n) where points are spread evenly; on the run's pool, most of it on one thread. The same
 *  order for any number of threads. */
VOR_NODISCARD vor_status vor_order_progressive(uint32_t *order, const float *xyz, size_t n,
                                               double spacing, const struct vor_run *run,
                                               struct vor_error *err);

#endif
