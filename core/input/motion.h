/** How the surface moved since an earlier result: its points are carried along.
 *
 *  They are moved as one rigid body first, so that they come to lie on the surface fitted to the
 *  input, then as 4, 16, 64 and more parts, each of which changes what those before it left. A
 *  part is moved only as far as its contacts with the surface show more than noise: at rest with
 *  noise of 0.2 spacings nothing moves, and the figures of results are the same (four models of
 *  6,000 points, two seeds, four frames). There are as many contacts as fits to different input
 *  points, and a part has as many as a fit has points.
 *
 *  An armadillo that turns by 3 degrees a frame and bends by 1, 100,000 points sampled afresh,
 *  second frame, without / with: 0.957 / 0.999 of the points live on, CPU 8.5 / 6.0 s; with, of
 *  those of the first of 30 frames 0.966 are left in the last one, delta at most 0.0261. 10,000
 *  points with noise of 0.2 spacings, sixth frame: 0.158 / 0.139 spacings off the surface, fandisk
 *  0.124 / 0.094, as the surface of the frame before goes along, too (seeds/former.h). Where the
 *  shape does not show how it moves, as of a ball that turns, points stay.
 *
 *  Source: rigid motions by planes of contact as in align/fit.h (Chen and Medioni 1992); parts that
 *  are blended as in Sumner et al. 2007, "Embedded deformation for shape manipulation". Departure:
 *  parts are not tied to each other, but each to the motion of the larger ones. */
#ifndef VOR_INPUT_MOTION_H
#define VOR_INPUT_MOTION_H

#include "core/input/domain.h"

/** Moves domain->previous with the surface, and sets how far parts of it moved by themselves. Does
 *  nothing without an earlier result, if the input has fewer points than twenty fits take, or if
 *  the run is late.
 *
 *  @retval VOR_E_NOMEM 4 bytes for each earlier point and what vor_morton_order takes do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_motion_follow(struct vor_domain *domain, const struct vor_run *run,
                                           struct vor_error *err);

#endif
