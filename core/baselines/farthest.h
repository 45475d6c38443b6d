/** Farthest point sampling: each point is the one of the input that is farthest from those before.
 *
 *  Source: Gonzalez 1985, "Clustering to minimize the maximum intercluster distance"; Eldar et al.
 *  1997, "The farthest point strategy for progressive image sampling".
 *
 *  A new point changes distances near it alone. So the input, which is in Morton order, is cut into
 *  runs of points, and a binary tree over these knows the box and the largest distance below each
 *  of its nodes: what lies farther from the new point than that is left out, as in Han et al. 2023,
 *  "QuickFPS". The points are the same as without the tree. */
#ifndef VOR_BASELINES_FARTHEST_H
#define VOR_BASELINES_FARTHEST_H

#include "core/base/run.h"

/** Chooses `count` of n points.
 *
 *  @param[out] out    count x 3, in the order in which they are chosen
 *  @param[in]  xyz    n x 3, all in different places; quick where they are in Morton order
 *  @param[in]  count  0 .. n
 *  @param[in]  first  index of the point to begin with; of points equally far the one with the
 *                     smallest index follows
 *
 *  @retval VOR_E_NOMEM  9 bytes a point do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log count), on one thread: half a second for 20,000 of a million. */
VOR_NODISCARD vor_status vor_farthest_points(float *out, const float *xyz, size_t n, size_t count,
                                             size_t first, const struct vor_run *run,
                                             struct vor_error *err);

#endif
