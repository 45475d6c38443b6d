/** Closes small loops where cells disagreed: where four points lie nearly on a circle, at creases
 *  and tips.
 *
 *  A loop is closed by the triangles that are best together (mesh/cut.h). It stays where a triangle
 *  would lie over no points of the input, where the input ends or has a hole, or would pass through
 *  another. */
#ifndef VOR_MESH_CLOSE_H
#define VOR_MESH_CLOSE_H

#include "core/mesh/balls.h"
#include "core/mesh/complex.h"

/** Closes what can be closed.
 *
 *  @param[out] closed  how many loops were
 *  @param[in]  balls   of the points, where they are
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for, between two loops; the loops before
 *          are closed
 *
 *  O(n + loops x edges^3), one thread. */
VOR_NODISCARD vor_status vor_close(struct vor_complex *complex, size_t *closed,
                                   const struct vor_balls *balls, const struct vor_run *run,
                                   struct vor_error *err);

#endif
