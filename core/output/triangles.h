/** The triangles of a result. */
#ifndef VOR_OUTPUT_TRIANGLES_H
#define VOR_OUTPUT_TRIANGLES_H

#include "core/cloud/mesh.h"
#include "core/output/output.h"

/** A result that was made, and what of; all borrowed. */
struct vor_triangles_of {
    const struct vor_cloud *in;      /**< the cloud that the domain was made of */
    const struct vor_cloud *cloud;   /**< the result */
    const struct vor_domain *domain; /**< what it lies on: the whole */
    struct vor_seeds *seeds;         /**< its points, or none where filters alone made it */
    const uint32_t *order;           /**< which seed each point of it is; NULL: without seeds */
    const struct vor_spec *spec;     /**< read: boundary */
};

/** Joins the points of a result by triangles (mesh/mesh.h), also where filters alone made it.
 *
 *  @param[out]    out     initialised, empty; filled only when VOR_OK is returned
 *  @param[in,out] report  receives the members mesh
 *  @param[in]     run     not ended by a stop
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED  as vor_mesh_make
 *
 *  O(n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_triangles_make(struct vor_mesh *out, struct vor_report *report,
                                            const struct vor_triangles_of *of,
                                            const struct vor_run *run, struct vor_error *err);

#endif
