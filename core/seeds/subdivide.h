/** Subdivision of seeds on a surface: each of them stays, and one is added in the middle of each
 *  edge of their Delaunay triangulation, four times as many in all. The lattice is the same, so
 * that places where it has faults are no more than before.
 *
 *  The edges are read off the seeds' flat cells (geom/flat.h): no triangulation is made. Where two
 *  seeds do not agree on an edge, or one leaves the surface on one side and comes back on the other
 *  as between two sheets, the seeds are too sparse for the surface.
 *
 *  Source: none of the papers; Hateley, Wei and Chen 2015, "Fast methods for computing centroidal
 *  Voronoi tessellations", take coarse tessellations to correct a fine one. */
#ifndef VOR_SEEDS_SUBDIVIDE_H
#define VOR_SEEDS_SUBDIVIDE_H

#include "core/seeds/seeds.h"

/** Most edges of a seed that are kept; five to seven are usual. */
#define VOR_EDGES_MOST VOR_PATCH_OCTAGON

/** The edges of a seed to others. */
struct vor_seed_edges {
    uint32_t to[VOR_EDGES_MOST];
    float middle[VOR_EDGES_MOST][3]; /**< on the surface of the seed */
    float outside[3]; /**< half way to the border; NAN where the cell does not reach one */
    float normal[3];  /**< of the surface */
    unsigned char count;
    unsigned char open; /**< its cell does not close */
};

/** The edges of all seeds; owns the array. */
struct vor_seeds_edges {
    struct vor_seed_edges *of; /**< n */
    size_t open;               /**< seeds whose cells do not close, as at a border */
    size_t doubtful; /**< edges that only one of their seeds has, or that leave the surface */
};

/** Finds the edges of seeds where they are. Indexes them.
 *
 *  @param[out] out  free with vor_seeds_edges_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM  160 n bytes do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool. The same bits for any number of threads. */
VOR_NODISCARD vor_status vor_seeds_edges_find(struct vor_seeds_edges *out, struct vor_seeds *seeds,
                                              struct vor_error *err);

/** edges may be all zero. */
void vor_seeds_edges_free(struct vor_seeds_edges *edges, struct vor_memory *memory);

/** Puts seeds at those of `coarse` and in the middle of their edges, in Morton order. Where the
 *  edges are too many, the shortest have none; where they are too few, seeds are added between the
 *  cells at a border and the border, and in triangles.
 *
 *  @param[out] fine   at least as many as `coarse`; its positions
 *  @param[in]  edges  of `coarse`, where they are
 *
 *  @retval VOR_E_NOMEM  128 n bytes do not fit, n of coarse
 *  @retval VOR_E_CANCELLED
 *
 *  O(n log n). The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_seeds_subdivide(struct vor_seeds *fine, const struct vor_seeds *coarse,
                                             const struct vor_seeds_edges *edges,
                                             struct vor_error *err);

#endif
