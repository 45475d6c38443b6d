/** Moves the points of an input onto the smooth surface around them: takes noise away, point by
 *  point.
 *
 *  Source: Lv et al. 2022, "Intrinsic and isotropic resampling for 3D point clouds", Sec. 3.1, Eq.
 *  1 to 3: every point goes onto the moving least squares surface of its neighbours, weighted by
 *  distance.
 *
 *  Departure: the width of the weights is that of each point's own neighbourhood, whose number of
 *  points follows from the noise where it is (input/neighbors.h). The paper has eight, and one
 *  width for all points, the largest there is: the worst point sets it.
 *  Departure: the surface is a quadric that is fitted with these weights, not the plane through
 *  weighted means of neighbours and of their normals; there are no normals whose signs would have
 *  to be made to agree first. Measured on bunny, rms distance to the true surface over that of the
 *  input, with signed noise of 0.33 and 0.66 mean distances to the six nearest: a plane over 20
 *  neighbours 0.40 and 0.41, over 30 0.47 and 0.37; a quadric as below 0.344 and 0.342. Without
 *  noise the plane moves points by 0.1 of that distance (rms), the quadric by 0.031.
 *
 *  Where fewer neighbours have much less variance about their quadric, at an edge or a detail, the
 *  surface is that of the fewer ones; where all of them fill space, as in the scatter around a
 *  surface, that of 512 unless those have much less. Neighbours are those on the point's sheet: by
 *  the domain's lists if it has some (geom/graph.h), by layers if it has sheets (input/sheets.h).
 *
 *  Measured in the same way, on clouds that no constant was chosen by: igea, 30,000 points of
 *  white noise, 0.37 and 0.30, armadillo's vertices 0.45 and 0.42, fandisk 0.36 with 0.66. Without
 *  noise points of these move by 0.034, 0.069 and 0.050. */
#ifndef VOR_INPUT_MLS_H
#define VOR_INPUT_MLS_H

#include "core/input/domain.h"

/** Moves every point of a domain, and indexes them again. A point without a surface around it
 *  stays.
 *
 *  @retval VOR_E_NOMEM 12 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the domain may have to be freed
 *
 *  O(n k), 6 us of CPU a point and pass where there is no noise, 25 with 0.33, on the run's pool.
 * The same points for any number of threads. */
VOR_NODISCARD vor_status vor_mls_project(struct vor_domain *domain, const struct vor_run *run,
                                         struct vor_error *err);

#endif
