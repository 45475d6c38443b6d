/** Whether the surface of triangles that are added one by one stays one of two sides.
 *
 *  Normals are of little use at a thin sharp wedge. Triangles that few cells propose may lead
 * around it so that a way along them comes back on the other side; triangles that close loops then
 * make a surface that passes through itself. So each such triangle is checked before it is taken.
 * Groups of triangles are joined with the side of each to its group (union-find, its roots with
 * parity).
 *
 *  Source: Tarjan 1975, "Efficiency of a good but not linear set union algorithm"; the parity is
 *  usual in tests whether a graph has two colours. */
#ifndef VOR_MESH_TWOSIDED_H
#define VOR_MESH_TWOSIDED_H

#include "core/mesh/complex.h"

/** Triangles that share edges, in groups. */
struct vor_twosided {
    struct vor_memory *memory;
    uint32_t *parent;        /**< room: a triangle of the group, itself at its root */
    unsigned char *contrary; /**< room: whether it faces the other way than that one */
    unsigned char *one;      /**< room: at roots, whether the group has one side only */
};

/** Joins the triangles of a complex in groups.
 *
 *  @param[out] out   free with vor_twosided_free; untouched on failure
 *  @param[in]  more  so many triangles may be added
 *
 *  @retval VOR_E_NOMEM 6 bytes a triangle, and one that may be added, do not fit
 *
 *  Nearly O(triangles), one thread. */
VOR_NODISCARD vor_status vor_twosided_make(struct vor_twosided *out,
                                           const struct vor_complex *complex, size_t more,
                                           struct vor_error *err);

/** sides may be all zero. */
void vor_twosided_free(struct vor_twosided *sides);

/** Whether a triangle that is not yet added leaves each group that has two sides with two. O(1). */
int vor_twosided_takes(struct vor_twosided *sides, const struct vor_complex *complex,
                       const uint32_t corner[3]);

/** Joins triangle t, which was just added, to those beside it. O(1). */
void vor_twosided_add(struct vor_twosided *sides, const struct vor_complex *complex, uint32_t t);

/** Whether triangles t and u are in one group. Nearly O(1). */
int vor_twosided_joined(struct vor_twosided *sides, uint32_t t, uint32_t u);

#endif
