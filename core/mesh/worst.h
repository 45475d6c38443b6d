/** Makes the worst triangles better, one by one: their corners, and where those do not suffice the
 *  points around them, move to where the triangles around each are least bad, by the eighth powers
 *  of their strains above 1. Relaxation (mesh/relax.h) makes triangles better in the mean. In
 *  the end a point is where it was if the triangles around it are worse now and were better there,
 *  or it would begin to hang in the air (vor_attach_hanging).
 *
 *  Source: Freitag and Ollivier-Gooch 1997, "Tetrahedral mesh improvement using swapping and
 *  smoothing": smoothing by optimization is for the worst elements only. Departure: the place is
 *  found by a compass search, as the worst triangle's strain has kinks. Eighth powers, which no
 *  limit cuts off, in the place of squares above that of 45 degrees: smallest angle of fandisk to
 *  10,000, a block and igea to 20,000 (means of two seeds) 43.1, 42.8, 45.1 / 43.5, 42.9, 45.7.
 *  Points on creases move anywhere on their surface: along the crease alone, fandisk to 10,000 and
 *  armadillo to 30,000 (two seeds each) 44.3, 43.1, 38.5, 40.5, from edges to the mesh .205 and
 * .207 spacings / 44.8, 45.3, 43.1, 41.0, .210. Points that went back wherever triangles were
 * worse, though not better where the point was: on open squares the smallest angle of 19 seeds
 * was 27.3 in the place of 38.8. */
#ifndef VOR_MESH_WORST_H
#define VOR_MESH_WORST_H

#include "core/mesh/complex.h"
#include "core/mesh/sheet.h"

/** Moves corners of bad triangles. Points on loops stay.
 *
 *  @param[in,out] sheet  its normals become those where the points are
 *  @param[in,out] seeds  those of the sheet; their lists are not renewed
 *  @param[in]     fixed  that many of the last ones stay
 *  @param[in]     how    last fits are used again, finer ones where it says so
 *
 *  @retval VOR_E_NOMEM  16 bytes a triangle and 41 a point do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n), and 21 points a bad triangle whose corners have six, on one thread. The same positions for
 * any number of threads. */
VOR_NODISCARD vor_status vor_worst_improve(const struct vor_complex *complex,
                                           struct vor_sheet *sheet, struct vor_seeds *seeds,
                                           size_t fixed, const struct vor_recall *how,
                                           struct vor_error *err);

#endif
