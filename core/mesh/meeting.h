/** Takes away triangles where two sheets meet.
 *
 *  Along the lines where sheets cross, and where they all but touch, a point lies as near to the
 *  one as to the other: its position does not tell which of them its triangles are of, and some
 *  lead from sheet to sheet. Two sheets fitted together to the input around a point
 *  (geom/twofold.h) tell how far apart they are there. The price is an opening along such a line,
 *  as with mesh/crossing.h.
 *
 *  Source: none of the papers. */
#ifndef VOR_MESH_MEETING_H
#define VOR_MESH_MEETING_H

#include "core/mesh/complex.h"
#include "core/mesh/sheet.h"

/** Drops triangles with a corner where two sheets are nearer to each other than VOR_MEETING_NEAR
 *  spacings of one: a seed that was fitted to one of several, beside input points that lists do not
 *  lead to from its own, as around a rim, and around which points do not keep to one side by their
 *  place, as on a bump of one sheet. Then points keep the largest of their fans. For inputs found
 * to have sheets on most of them (input/regions.h).
 *
 *  @param[in,out] complex  no point has several fans; stays so
 *  @param[in]     sheet    of its points, which may have moved since they were listed
 *
 *  @retval VOR_E_NOMEM     a byte a point does not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the complex is as it was
 *
 *  O(n log N) of N input points, on the run's pool but for the last step. The same triangles for
 *  any number of threads. */
VOR_NODISCARD vor_status vor_meeting_drop(struct vor_complex *complex,
                                          const struct vor_sheet *sheet, const struct vor_run *run,
                                          struct vor_error *err);

/** At none / 0.1 / 0.12 / 0.15: of arma2_120k (surfaces that cross at four degrees) to 40,000
 *  1.36 / 1.03 / 0.93 / 0.83 % of 69,676 / 68,606 / 68,335 / 67,796 triangles are on two sheets; of
 *  shell60k to 20,000 118 / 95 / 91 / 82 of 39,765 / 39,653 / 39,632 / 39,538. With other seeds
 *  arma2_120k has up to 1.05 % at 0.12, 0.87 at 0.15. */
#define VOR_MEETING_NEAR 0.15

#endif
