/** The triangles of a result. */
#ifndef VOR_OUTPUT_TRIANGLES_H
#define VOR_OUTPUT_TRIANGLES_H

#include "core/cloud/mesh.h"
#include "core/output/output.h"

/** Joins the seeds by triangles (mesh/mesh.h). Where a method polished them, they move a little, so
 *  that the triangles become better. Of a soup only the order is made.
 *
 *  @param[out]    out     initialised, empty; filled only when VOR_OK is returned
 *  @param[out]    order   room for which seed each point of the result is (vor_placed.order); free
 *                         with vor_free, also on failure
 *  @param[in,out] report  receives the members mesh; read: on_islands
 *  @param[in]     told    by the method
 *  @param[in]     spec    read: soup, repair
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED  as vor_mesh_make
 *
 *  O(n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_triangles_of_seeds(struct vor_mesh *out, uint32_t **order,
                                                struct vor_report *report, struct vor_seeds *seeds,
                                                const struct vor_outcome *told,
                                                const struct vor_spec *spec, struct vor_error *err);

/** A result that was made, and what of; all borrowed. A soup replaces the cloud. */
struct vor_triangles_of {
    const struct vor_cloud *in;      /**< the cloud that the domain was made of */
    struct vor_cloud *cloud;         /**< the result */
    const struct vor_domain *domain; /**< what it lies on: the whole */
    struct vor_seeds *seeds;         /**< its points, or none where filters alone made it */
    const uint32_t *order;           /**< which seed each point of it is; NULL: without seeds */
    const struct vor_spec *spec;     /**< read: boundary, patch, soup */
};

/** Renumbers the triangles over the seeds for the points of the result, or where filters alone made
 *  it joins its points by triangles, which stay where they are. Of a soup the result becomes the
 *  corners of the polygons (mesh/soup.h).
 *
 *  @param[in,out] mesh    of vor_triangles_of_seeds, or initialised and empty; empty on failure
 *  @param[in,out] report  receives the members mesh
 *  @param[in]     run     not ended by a stop
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED  as vor_mesh_make
 *
 *  O(n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_triangles_finish(struct vor_mesh *mesh, struct vor_report *report,
                                              const struct vor_triangles_of *of,
                                              const struct vor_run *run, struct vor_error *err);

#endif
