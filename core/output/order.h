/** Progressive order: an order of points whose beginnings, of any length, are spread evenly over
 *  all of the surface.
 *
 *  Source: farthest point first (Gonzalez 1985, "Clustering to minimize the maximum intercluster
 *  distance"; Eldar et al. 1997, "The farthest point strategy for progressive image sampling"): the
 *  next point is the one farthest from all before it.
 *
 *  Departure: the next point may be any that is at least 0.83 times as far as the farthest (NEARLY
 *  times MARGIN); of these it is the one that brings most points to a nearest neighbour at that
 *  distance. The last round allows all points about a spacing away, which are most of them. Among
 *  even points any set of more than a third has neighbours a spacing apart. Farthest first adds
 *  them anywhere, and delta stays high until each point has such a neighbour; here each new point
 *  gives one to as many as it can.
 *
 *  Measured, delta of a beginning: 0.02 from half of the points on, as that of a run of so many
 *  (with farthest first 0.12 at a half of 20,000), 0.08 to 0.13 up to a fifth, where a run without
 *  polish has 0.045 to 0.09, and more than 0.2 around 0.3. Coverage is 1.05 to 1.6 times that of a
 *  perfect lattice of as many points up to 0.7, 1.8 at 0.9; a random draw has 1.8 to 2.9. Also
 *  tried: plain farthest first (delta 0.12 at a half, 0.05 at 0.7; coverage 1.0 to 1.6),
 *  elimination by weights (0.1 to 0.15 early, 0.08 at a half; coverage 1.4 to 1.8), sublattices of
 *  every third point (0.05 to 0.27; coverage 1.4 to 2.3). Delta alone would be easy: the beginning
 *  of the spatial order, a patch with nothing elsewhere, has that of the whole.
 *
 *  Bound: in a perfect lattice of spacing s two points are either s or at least sqrt(3) s apart.
 *  So, with a share q of a subset's nearest neighbours beyond s, delta^2 >= (sqrt(3) - 1)^2 q (1 -
 *  q) / (1 + (sqrt(3) - 1) q)^2. One more point changes the neighbours of at most six. From a
 *  subset that is even by itself (q = 1) to the whole (q = 0), q takes every value, and delta
 *  passes 0.278, whatever the order. */
#ifndef VOR_OUTPUT_ORDER_H
#define VOR_OUTPUT_ORDER_H

#include "core/base/run.h"

#include <stddef.h>
#include <stdint.h>

/** Orders n points progressively, by Euclidean distances.
 *
 *  @param[out] order   n: a permutation of 0 .. n - 1 that begins with point 0; points that
 *                      coincide with an earlier one come last, by index
 *  @param[in] xyz      n x 3 floats, n >= 1, each of magnitude at most 1e6. Points near each other
 *                      should have near indices, as seeds have: beginnings are chosen from every
 *                      fourth, sixteenth ... point
 *  @param[in] spacing  mean distance to the nearest neighbour; 0 where not known
 *
 *  @retval VOR_E_NOMEM  28 n bytes, 52 for each of the first 32nd, and a little do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n) for points that are spread evenly; on the run's pool, most of it on one thread. The
 *  same order for any number of threads. Once the run is late (vor_run_is_late), the points not
 *  chosen yet follow in O(n): every second, of those between every second, and so on. */
VOR_NODISCARD vor_status vor_order_progressive(uint32_t *order, const float *xyz, size_t n,
                                               double spacing, const struct vor_run *run,
                                               struct vor_error *err);

#endif
