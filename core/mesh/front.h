/** Triangles over points of a surface, by an advancing front.
 *
 *  Over an open edge the next triangle is that of the local Delaunay triangulation with the
 *  smallest empty ball, if the surface does not fold back there; the best of all open edges comes
 *  first, those over which the surface turns by less than 30 degrees before sharper ones. Where
 *  nothing is left to do and points are without triangles, it begins there anew. The mesh stays a
 *  manifold of two sides, over the input, on one sheet. A triangle that passes through one of
 *  those at the points nearest to its corners is not taken.
 *  Creases, tips and uneven points need no agreement between neighbours, which dual cells do.
 *
 *  Source: Cohen-Steiner and Da 2004, "A greedy Delaunay-based surface reconstruction algorithm".
 *  Departure: no Delaunay triangulation is made: whether a triangle has an empty ball is read off
 *  the points around it. Where the request has a metric, that of the edge's first point counts.
 *  Triangles lie along the normals of the surface, and face as those that are there already at
 *  their corners do, so that two sheets that face each other are not bridged; open edges that are
 *  left are tried again without that. At last triangles at open edges are taken away and the front
 *  goes on from there: most holes are where it came from two sides. Where the input has lists of
 *  neighbours, triangles join what these join; where it is not found to have sheets on most of it,
 *  creases cut lists too, and open edges that are left are tried again without. */
#ifndef VOR_MESH_FRONT_H
#define VOR_MESH_FRONT_H

#include "core/mesh/complex.h"
#include "core/mesh/over.h"

/** Adds triangles until no open edge takes one.
 *
 *  @param[in,out] complex  a manifold; stays so, but for points of several fans
 *  @param[in,out] overs    of its points; its balls are set
 *
 *  @retval VOR_E_NOMEM     25 bytes a point and 2 KB for each edge that was open do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n), one thread. */
VOR_NODISCARD vor_status vor_front_advance(struct vor_complex *complex, struct vor_overs *overs,
                                           const struct vor_run *run, struct vor_error *err);

#endif
