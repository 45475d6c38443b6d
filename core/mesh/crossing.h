/** Takes away triangles that pass through others.
 *
 *  Where two sheets are nearer to each other than the spacing of the input, some points of the one
 *  are taken for points of the other: triangles lead there from sheet to sheet, and mostly through
 *  those of the other sheet that lead back. No other rule finds triangles on two sheets as surely:
 *  of shell60k to 20,000, 250 of 39,572 pass through others, 139 of which are among the 264 on two
 *  sheets. The price is an opening at each such place, and along lines where the surfaces of the
 *  input do cross. Where there are no sheets, triangles are compared with those near them as they
 *  are added, but not again when edges are flipped and points move (mesh/flip.h, mesh/relax.h).
 *
 *  Source: none of the papers; edges against triangles as in Moller 1997, "A fast triangle-triangle
 *  intersection test", without its intervals. */
#ifndef VOR_MESH_CROSSING_H
#define VOR_MESH_CROSSING_H

#include "core/mesh/balls.h"
#include "core/mesh/complex.h"

/** Drops triangles of which an edge passes through another one near them that they share no corner
 *  with, or that an edge of such a one passes through; touching is none. For inputs found to have
 *  sheets on most of them (input/regions.h).
 *
 *  Where points have moved since they passed through none, corners of triangles that pass through
 *  one that lists lead to are first put back, again as long as that halves their number: around a
 *  rim that is narrower than the spacing the triangles are right, and it is the places that are
 *  wrong. Between sheets that no lists join it is the triangles. Put back all the same, 79 of 2,513
 *  lead from one to the other of two wavy sheets .4 spacings apart (unit/mesh_test); so 14 of
 *  2,672.
 *
 *  @param[in,out] complex  no point has several fans; stays so
 *  @param[in,out] seeds    its points, which may have moved since `sheet` listed them
 *  @param[in]     before   where they were; NULL: none has moved
 *
 *  @retval VOR_E_NOMEM     a byte a triangle and an index of the points do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the complex is as it was
 *
 *  O(n log n), and as much for each halving, on the run's pool but for the last step. The same
 *  triangles for any number of threads. */
VOR_NODISCARD vor_status vor_crossing_drop(struct vor_complex *complex, struct vor_seeds *seeds,
                                           const struct vor_sheet *sheet, const float *before,
                                           struct vor_error *err);

/** A triangle that a given one passes through, at a point that is listed around a corner of it,
 * also if they have one corner in common; complex->count where there is none. The first `since` are
 * not looked at. O(1). */
size_t vor_crossing_near(const struct vor_complex *complex, const struct vor_balls *balls,
                         const uint32_t corner[3], size_t since);

#endif
