/** Takes triangles away at the border of a mesh. */
#ifndef VOR_MESH_PEEL_H
#define VOR_MESH_PEEL_H

#include "core/geom/patch.h"
#include "core/mesh/complex.h"

/** Cosine of 150 degrees: of the angle of a triangle over an open edge from which on the border
 * runs along its other two. */
#define VOR_PEEL_BLUNT (-VOR_HEXAGON_HEIGHT)

/** Takes away all triangles at points of open edges, and all but the largest fan of each point.
 *
 *  @retval VOR_E_NOMEM  a byte a point does not fit
 *
 *  O(n), one thread. */
VOR_NODISCARD vor_status vor_peel(struct vor_complex *complex, struct vor_error *err);

/** Takes away the thin triangles that fill notches of a border: points of the border would count as
 *  surrounded. O(n), one thread.
 *
 *  @param[in] xyz  n x 3 */
void vor_peel_notches(struct vor_complex *complex, const float *xyz);

#endif
