/** Flips edges of triangles whose other diagonal makes better ones, or leaves points nearer to six
 *  triangles each.
 *
 *  Source: Lawson 1977, "Software for C1 surface interpolation", of a plane. Departure: on a
 * surface an edge is flipped where the worse of the two triangles becomes better, unless the new
 * edge leaves the surface or joins two sheets. */
#ifndef VOR_MESH_FLIP_H
#define VOR_MESH_FLIP_H

#include "core/mesh/complex.h"
#include "core/mesh/sheet.h"

/** Looks at every edge once, those of the first points first, and flips it where that pays. The
 *  complex stays a manifold, with the same loops. Returns how many were flipped.
 *
 *  @param[in,out] complex  no edge has more than two triangles
 *  @param[in]     sheet    its normals are those at the points
 *  @param[in]     surrounded  whether triangles surround each point: an edge is flipped where its
 *                          ends and those of the other come nearer to six triangles, or three at a
 *                          loop, squared and summed; NULL: where the worse triangle becomes better
 *
 *  O(n), one thread. */
size_t vor_flip(struct vor_complex *complex, const struct vor_sheet *sheet,
                const unsigned char *surrounded);

/** Whether the edge from a to b may be flipped to one between its third corners, as
 * vor_complex_edge tells them: no triangle turns over, no sheets are joined, and the new edge
 * exists nowhere and leaves the surface no more than the old one. O(1). */
int vor_flip_may(const struct vor_complex *complex, const struct vor_sheet *sheet, uint32_t a,
                 uint32_t b, const uint32_t third[2]);

#endif
