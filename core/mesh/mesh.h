/** Triangles from the points of a result.
 *
 *  An advancing front (mesh/front.h), and small loops closed (mesh/close.h), some by
 *  making what is around them anew (mesh/carve.h). Then edges are flipped (mesh/flip.h) and points
 *  moved a little (mesh/relax.h), so that triangles become better. Where edges are open then, the
 *  front goes on once more. At last faults may be repaired (mesh/repair.h): not where there are
 *  sheets, a density or an earlier result. What comes out is a manifold, turned one way
 *  (mesh/facing.h). Normals that the method found are those of where the points are then
 *  (mesh/carry.h).
 *
 *  Source: Cohen-Steiner and Da 2004, as mesh/front.h says. Departure: not the dual of restricted
 *  cells as in Chen et al. 2018, Sec. 5.7: three cells rarely agree at creases and tips. */
#ifndef VOR_MESH_MESH_H
#define VOR_MESH_MESH_H

#include "core/cloud/mesh.h"
#include "core/report.h"
#include "core/seeds/seeds.h"

/** What may be done to points. */
struct vor_mesh_how {
    int moves;    /**< they may be moved along the surface */
    int refine;   /**< to finer fits (vor_seeds_refine) */
    int repairs;  /**< and taken away in one place and added in another */
    size_t fixed; /**< that many of the last ones stay */
};

/** Makes the triangles over the seeds, in their order.
 *
 *  @param[out]    out     initialised, empty; filled only when VOR_OK is returned; fewer than three
 *                         seeds give no triangles
 *  @param[in,out] report  receives the members mesh but its seconds; lengths in the domain's unit
 *  @param[in,out] seeds   on the whole domain; they move where how->moves says so
 *
 *  @retval VOR_E_NOMEM 600 bytes a seed do not fit, or vor_adjacency_make where there are sheets
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool, half of it on one thread. The same bytes for any number of
 * threads. */
VOR_NODISCARD vor_status vor_mesh_make(struct vor_mesh *out, struct vor_report *report,
                                       struct vor_seeds *seeds, const struct vor_mesh_how *how,
                                       struct vor_error *err);

/** Renumbers the corners: the point at place k of the result is seed order[k].
 *
 *  @param[in] order  a permutation of 0 .. n - 1
 *
 *  @retval VOR_E_NOMEM 4 n bytes do not fit; the mesh is as it was */
VOR_NODISCARD vor_status vor_mesh_reorder(struct vor_mesh *mesh, const uint32_t *order, size_t n,
                                          struct vor_error *err);

#endif
