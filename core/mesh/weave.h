/** Triangles that the cells of their corners propose.
 *
 *  Those on which all three cells agree are a manifold but for points with several fans: all at a
 *  point come from its own cell, where each neighbour has one edge. After them come those that two
 *  cells propose, and one, the best first, where they leave it a manifold and lie beside the others
 *  at each corner.
 *
 *  Source: Boltcheva and Levy 2017, "Surface reconstruction by computing restricted Voronoi cells
 *  in parallel", Sec. 4. Departure: a triangle that not all cells propose is tested by angles in
 * the tangent planes of its corners, not by those between normals. */
#ifndef VOR_MESH_WEAVE_H
#define VOR_MESH_WEAVE_H

#include "core/mesh/complex.h"
#include "core/mesh/fan.h"

/** How many triangles so many cells proposed. */
struct vor_woven {
    size_t agreed[4]; /**< agreed[v]: taken, with v cells */
};

/** Adds the triangles that the fans propose.
 *
 *  @param[in,out] complex  of as many points, without triangles
 *
 *  @retval VOR_E_NOMEM
 *
 *  O(n), one thread. */
VOR_NODISCARD vor_status vor_weave(struct vor_complex *complex, struct vor_woven *told,
                                   const struct vor_fans *fans, const struct vor_sheet *sheet,
                                   struct vor_error *err);

#endif
