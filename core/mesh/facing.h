/** Which way triangles face.
 *
 *  Neighbours are turned alike. Each connected component then faces away from its own inside: a
 *  closed one by its volume, an open one by its mean winding number (geom/winding.h), however thin
 *  it is. Where that is small, as on a terrain, it faces upward: the largest coordinate
 * of the sum of its normals is positive. A component with one side only, such as a Moebius band, is
 *  counted; along some of its edges neighbours face opposite ways. */
#ifndef VOR_MESH_FACING_H
#define VOR_MESH_FACING_H

#include "core/mesh/complex.h"

/** What was found. */
struct vor_facing {
    size_t components, one_sided;
};

/** Turns the triangles of a complex without points of several fans.
 *
 *  @param[in] xyz  n x 3; NULL: neighbours are turned alike, but no component outward
 *
 *  @retval VOR_E_NOMEM 5 bytes a triangle do not fit
 *
 *  O(triangles), and 32 times that for open components; one thread. */
VOR_NODISCARD vor_status vor_facing_turn(struct vor_complex *complex, struct vor_facing *told,
                                         const float *xyz, struct vor_error *err);

#endif
