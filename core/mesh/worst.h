/** Makes the worst triangles better, one by one: their corners move to where the worst triangle
 *  around each is least bad. Relaxation (mesh/relax.h) makes triangles better in the mean, and
 *  leaves points on creases where they are, which is where the worst triangles lie; there they move
 *  along the crease here.
 *
 *  Source: Freitag and Ollivier-Gooch 1997, "Tetrahedral mesh improvement using swapping and
 *  smoothing": smoothing by optimization is for the worst elements only. Departure: the place is
 *  found by a compass search, as the worst triangle's strain has kinks. */
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
 *  @retval VOR_E_NOMEM  17 bytes a triangle do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n), and 20 us a bad triangle, on one thread. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_worst_improve(const struct vor_complex *complex,
                                           struct vor_sheet *sheet, struct vor_seeds *seeds,
                                           size_t fixed, const struct vor_recall *how,
                                           struct vor_error *err);

#endif
