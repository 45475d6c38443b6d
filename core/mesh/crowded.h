/** Where two sheets of a mesh are nearer to each other than its edges are long. */
#ifndef VOR_MESH_CROWDED_H
#define VOR_MESH_CROWDED_H

#include "core/mesh/balls.h"
#include "core/mesh/complex.h"

/** Marks the points that have another within their mean edge that two edges do not lead to.
 *
 *  @param[in,out] sheet  receives `crowded`, where the input has no lists of neighbours
 *  @param[in]     balls  of the points, where they are
 *
 *  @retval VOR_E_NOMEM  a byte a point does not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_crowded_find(struct vor_sheet *sheet,
                                          const struct vor_complex *complex,
                                          const struct vor_balls *balls, const struct vor_run *run,
                                          struct vor_error *err);

#endif
