/** Handles that a triangle would make.
 *
 *  A triangle that touches the boundary in two places joins two boundary loops or cuts one in two.
 *  The former makes a handle where the surface joins both already. Handles of a shape are large;
 *  one that a few edges lead around is a tunnel through a thin part, and
 *  one that ends at a hole of few edges a tunnel from sheet to sheet.
 *
 *  Source: the change of the Euler characteristic when a cell is added, as in any text book. */
#ifndef VOR_MESH_HANDLE_H
#define VOR_MESH_HANDLE_H

#include "core/mesh/complex.h"
#include "core/mesh/twosided.h"

/** Whether a triangle over the open edge of its first two corners makes a small handle: its third
 *  corner is on the same component, not along the boundary, and few edges away along the surface or
 *  on a hole.
 *
 *  @param[in,out] sides   of the triangles there are
 *  @param[in]     corner  the third has triangles, and no edge to the others
 *
 *  O(1). */
int vor_handle_is(const struct vor_complex *complex, struct vor_twosided *sides,
                  const uint32_t corner[3]);

#endif
