/** Makes the worst triangles better, one by one: their corners, and where those do not suffice the
 *  points around them, move to where the triangles around each are least bad, by the eighth powers
 *  of their strains above 1. Where a triangle stays bad, each edge around its corners is flipped on
 *  trial, and the points around it are moved. Relaxation (mesh/relax.h) makes triangles better in
 *  the mean. A point is moved only where the triangles are better once it lies on the surface that
 *  is fitted where it comes to, which on a crease is another than the one along which the place was
 *  found, and where it does not begin to hang in the air (vor_attach_hanging).
 *
 *  Source: Freitag and Ollivier-Gooch 1997, "Tetrahedral mesh improvement using swapping and
 *  smoothing": smoothing by optimization is for the worst elements only. Departure: the place is
 *  found by a compass search, as the worst triangle's strain has kinks. Eighth powers, which no
 *  limit cuts off, in the place of squares above that of 45 degrees: smallest angle of fandisk to
 *  10,000, a block and igea to 20,000 (means of two seeds) 43.1, 42.8, 45.1 / 43.5, 42.9, 45.7.
 *  Points on creases move anywhere on their surface. All points put onto their surfaces after a
 *  pass, and taken back where that was worse / each at once / with flips: least of five seeds,
 *  armadillo to 30,000 38.8 / 42.1 / 45.0, fandisk 39.3 / 42.9 / 45.1.
 *
 *  Where the mesh is folded, so that triangles lie over each other, flips that change which way
 *  triangles face are tried too, several at once: one alone leaves points on top of others. Least
 *  angle of armadillo, seeds 3 and 5, fandisk, seed 2, and three gears without / with them: 43.8
 *  43.8 40.9 38.0 36.9 42.2 / 44.9 44.9 45.2 43.5 45.3 45.2.
 *
 *  The first passes are by strain, the last by angle: around one triangle strain falls at the cost
 *  of another's angle. Least angle of bunny to 5,000, three seeds, a gear and an open sheet by
 * strain alone / so: 42.5 43.2 43.1 43.5 41.7 / 44.7 45.0 44.0 45.1 43.2; least quality .775 .785
 * .758 .819 .735 / .748 .759 .745 .782 .725. */
#ifndef VOR_MESH_WORST_H
#define VOR_MESH_WORST_H

#include "core/mesh/complex.h"
#include "core/mesh/sheet.h"

/** Moves corners of bad triangles, and flips edges near them. Points on loops stay.
 *
 *  @param[in,out] complex  stays a manifold with the same loops and parts
 *  @param[in,out] sheet  its normals become those where the points are
 *  @param[in,out] seeds  those of the sheet; their lists are not renewed
 *  @param[in]     fixed  that many of the last ones stay
 *  @param[in]     how    last fits are used again, finer ones where it says so
 *
 *  @retval VOR_E_NOMEM  16 bytes a triangle and 2 a point do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n), and up to 5 ms a triangle that stays bad, on one thread. No more flips are tried than
 * there are points, as most triangles may be bad: a helix of 5,000 points to 10,000, all flips /
 * so: 40 / 6 s. The same for any number of threads. */
VOR_NODISCARD vor_status vor_worst_improve(struct vor_complex *complex, struct vor_sheet *sheet,
                                           struct vor_seeds *seeds, size_t fixed,
                                           const struct vor_recall *how, struct vor_error *err);

#endif
