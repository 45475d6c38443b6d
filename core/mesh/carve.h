/** Makes the mesh anew around loops that stay open because what would close them passes through
 *  triangles that are there: at sharp and thin parts the front takes some that lead it astray.
 *
 *  Open edges without / with it: of 12 flat tetrahedra (800 points, edges of 27 and 37 degrees) 195
 *  / 16; of 68 clouds of 17 families 47 / 0.
 *
 *  The triangles at such a loop are taken away, in growing rings, until they leave one loop that
 *  can be cut (mesh/cut.h); then the points in its middle are put into the triangles that they
 *  cost least in. Where nothing closes all is as it was.
 *
 *  Source: none; points are inserted one by one as in Lawson 1977 without his empty circles. */
#ifndef VOR_MESH_CARVE_H
#define VOR_MESH_CARVE_H

#include "core/mesh/balls.h"
#include "core/mesh/complex.h"

/** Closes loops by making what is around them anew.
 *
 *  @param[in,out] complex  a manifold; stays one
 *  @param[in,out] closed   the loops that were are added to it
 *  @param[in]     balls    of the points, where they are
 *
 *  Where there are open edges, neighbours are turned alike before (mesh/facing.h).
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for, between two loops
 *
 *  O(n + loops x edges^3), one thread. */
VOR_NODISCARD vor_status vor_carve(struct vor_complex *complex, size_t *closed,
                                   const struct vor_balls *balls, const struct vor_run *run,
                                   struct vor_error *err);

#endif
