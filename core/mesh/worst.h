/** Makes the worst triangles better, one by one: their corners move to where the triangles around
 *  each are least bad, by the squares of what strains have too much. Relaxation (mesh/relax.h)
 *  makes triangles better in the mean, and leaves points on creases where they are, which is where
 *  the worst triangles lie; there they move along the crease here, or where one is poor
 *  (vor_relax_is_free) anywhere. In the end a point is where it was if the triangles around it
 *  would be worse, or it would hang in the air (vor_attach_hanging).
 *
 *  Source: Freitag and Ollivier-Gooch 1997, "Tetrahedral mesh improvement using swapping and
 *  smoothing": smoothing by optimization is for the worst elements only. Departure: the place is
 *  found by a compass search, as the worst triangle's strain has kinks. Squares in the place of the
 *  largest strain: lowest quality and smallest angle of igea to 20,000, fandisk to 10,000 and the
 *  armadillo to 30,000 .826, 43.8, .761, 42.8, .799, 44.3 / .830, 43.9, .760, 42.8, .768, 44.8. */
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
 *  O(n), and 20 us a bad triangle, on one thread. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_worst_improve(const struct vor_complex *complex,
                                           struct vor_sheet *sheet, struct vor_seeds *seeds,
                                           size_t fixed, const struct vor_recall *how,
                                           struct vor_error *err);

#endif
