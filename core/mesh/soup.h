/** The polygons of the seeds' restricted Voronoi cells, as they are: each has points of its own.
 *
 *  Source: the polygon soup of Chen et al. 2018, Sec. 5.7, of which that paper makes a mesh. Cells
 *  are those of the run (geom/cell.h): one polygon in the tangent plane where the surface hardly
 *  bends, else pieces of a finer patch. Where the input ends they end with the patch. */
#ifndef VOR_MESH_SOUP_H
#define VOR_MESH_SOUP_H

#include "core/cloud/cloud.h"
#include "core/cloud/mesh.h"
#include "core/seeds/seeds.h"

/** The points of a result and the seeds that they are; all borrowed. */
struct vor_soup_of {
    const struct vor_cloud *result;
    struct vor_seeds *seeds; /**< on the whole domain */
    const uint32_t *order;   /**< which seed each point of the result is; NULL: the same number */
};

/** Makes the polygons, those of the result's first point first.
 *
 *  @param[out] out   initialised, empty; receives the corners of the polygons, each with the
 *                    attributes of its cell's point
 *  @param[out] mesh  initialised, empty; receives the polygons (vor_mesh.polygons). Where the
 *                    result has normals, they face that way
 *
 *  Both are untouched on failure.
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *  @retval VOR_E_LIMIT more corners than VOR_POINTS_MAX
 *
 *  O(n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_soup_make(struct vor_cloud *out, struct vor_mesh *mesh,
                                       const struct vor_soup_of *of, struct vor_error *err);

#endif
