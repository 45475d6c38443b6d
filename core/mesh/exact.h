/** Moves points of a mesh onto the surface through the input points around them.
 *
 *  Between two sheets nearer to each other than the spacing of the input, a fit to twenty points is
 *  off its sheet by up to half of the gap: then a point of the mesh lies on neither, or nearer to
 *  the other one. A smooth surface that goes through the points of the sheet (geom/through.h) is
 *  half as far off.
 *
 *  Source: none of the papers. Lists of neighbours are made only where the input is exact enough
 *  for fits to twenty points (input/input.c), so that it follows no noise. */
#ifndef VOR_MESH_EXACT_H
#define VOR_MESH_EXACT_H

#include "core/mesh/sheet.h"

/** Moves those seeds that were fitted to one of several sheets, each onto the sheet that its
 *  triangles were made on. Others stay, and so do all where no lists of neighbours were made.
 *
 *  @param[in]     sheet  of these seeds; its normals stay as they are
 *  @param[in,out] seeds  positions change
 *  @param[in]     fixed  that many of the last ones stay
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; some have moved
 *
 *  O(1) a seed, on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_exact_put(const struct vor_sheet *sheet, struct vor_seeds *seeds,
                                       size_t fixed, struct vor_error *err);

#endif
