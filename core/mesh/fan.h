/** The flat cells of seeds, and which neighbours cut their edges.
 *
 *  A flat cell is a polygon in the tangent plane at its seed, cut by the bisectors with the seeds
 * on the same sheet; its dual is the Delaunay triangulation seen from the seed. Corners where the
 *  edges of two neighbours meet propose triangles. Where the request has a metric, the cell is cut
 *  in that of its seed (geom/stretch.h).
 *
 *  Source: Chen et al. 2018, "Isotropic surface remeshing" 5.7; Boltcheva and Levy 2017, "Surface
 *  reconstruction by computing restricted Voronoi cells in parallel". */
#ifndef VOR_MESH_FAN_H
#define VOR_MESH_FAN_H

#include "core/mesh/sheet.h"

/** Most edges of a cell; one with more gives no triangles. Cells have about six. */
enum { VOR_FAN_MOST = 16 };

/** Edge of a patch that no neighbour cut. */
#define VOR_FAN_OPEN UINT32_MAX

/** The cells of n seeds. */
struct vor_fans {
    struct vor_memory *memory;
    size_t n;
    uint32_t *neighbor; /**< n x VOR_FAN_MOST: who cut the edges, in their order around the seed */
    unsigned char *count; /**< n: edges */
};

/** Cuts the cells of all seeds.
 *
 *  @param[out]    out    free with vor_fans_free; untouched on failure
 *  @param[in,out] seeds  those of the sheet, indexed where they are (vor_seeds_index)
 *
 *  @retval VOR_E_NOMEM 65 bytes a seed do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_fans_make(struct vor_fans *out, const struct vor_sheet *sheet,
                                       struct vor_seeds *seeds, const struct vor_run *run,
                                       struct vor_error *err);

/** fans may be all zero. */
void vor_fans_free(struct vor_fans *fans);

/** True when a corner of the cell of i proposes the triangle (i, j, k). O(VOR_FAN_MOST). */
int vor_fans_has(const struct vor_fans *fans, uint32_t i, uint32_t j, uint32_t k);

#endif
