/** Normals that a method found, on points that moved since.
 *
 *  Source: none of the papers. Huang et al. 2013 give a point inserted the normal of one that lies
 *  flat beside it (Sec. 4); so does this where a mesh moves points, or takes them from one place to
 *  another. */
#ifndef VOR_MESH_CARRY_H
#define VOR_MESH_CARRY_H

#include "core/mesh/complex.h"
#include "core/seeds/seeds.h"

/** Gives each point the normal of a corner of its triangles, it among them: of those that look to
 *  the side to which the triangles face, one that was found near by and in whose plane the point
 *  lies. Points without triangles, without a normal, or without such a corner keep what they have.
 *
 *  @param[in]     complex  triangles that face outward
 *  @param[in]     before   n x 3: the places where the seeds' normals were found
 *  @param[in,out] seeds    normals change
 *
 *  @retval VOR_E_NOMEM 12 bytes a seed do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_carry_normals(struct vor_seeds *seeds,
                                           const struct vor_complex *complex, const float *before,
                                           struct vor_error *err);

#endif
