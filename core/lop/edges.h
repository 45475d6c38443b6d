/** Points on the edges of a surface that oriented points describe: which of them are put there, and
 *  where an edge runs.
 *
 *  Source: none of the papers. Insertion comes near edges and leaves half a spacing to either side
 *  of them. Where the normals around a point fall into two groups with nothing between, the planes
 *  of both sides meet in an edge (lop/latent.h). The points nearest to it are put onto it, one for
 *  each stretch of VOR_SITES_APART spacings. */
#ifndef VOR_LOP_EDGES_H
#define VOR_LOP_EDGES_H

#include "core/base/run.h"
#include "core/lop/latent.h"

/** Cosine between the normals of two sides at an edge, at most: 20 degrees. */
#define VOR_LOP_EDGE_COSINE 0.94
/* Figures: mean distance from the true edges of fandisk to the nearest point, over the diagonal,
 * and delta; 22,000 exact samples to 120,000, rho 0, 8 steps. Without any points on edges 2.5e-3.
 */
/** Spacings within which the other side of an edge is looked for: twice the following. */
#define VOR_LOP_EDGE_SEEN (2 * VOR_LOP_EDGE_NEAR)
/** Spacings from a point to the edge that it is put onto, at most. At 0.9 / 1.2 / 1.5, 0.8 apart:
 *  1.6e-3 / 1.14e-3 / 0.97e-3, 0.044 / 0.045 / 0.045. */
#define VOR_LOP_EDGE_NEAR 1.5

/** Where a point sees an edge. */
struct vor_lop_edge {
    float foot[3], along[3];
    float other[3]; /**< normal of the other side */
    float distance; /**< from the point to the foot; INFINITY where there is no edge */
    int past;       /**< the point lies past the edge, on the plane of its own side */
};

/** Looks for the edge next to point i.
 *
 *  @param[in] tree     of all samples, as they are
 *  @param[in] spacing  around the point
 *
 *  Thread-safe. */
void vor_lop_edge_find(struct vor_lop_edge *out, const struct vor_lop_samples *samples, size_t i,
                       double spacing, const struct vor_lop_tree *tree,
                       const struct vor_lop_latent *latent);

/** Chooses the points that are put onto their edges, nearest first, and puts them there.
 *
 *  @param[in,out] edge     of each sample
 *  @param[in,out] on       of each sample: 1 if it is on an edge; those that are stay, but for
 *                        those that come nearer to each other than VOR_LOP_CLOSE
 *  @param[in]     spacing  of each sample
 *
 *  @retval VOR_E_NOMEM
 *
 *  O(n + points near edges). */
VOR_NODISCARD vor_status vor_lop_edge_put(struct vor_lop_samples *samples,
                                          const struct vor_lop_edge *edge, unsigned char *on,
                                          const float *spacing, struct vor_error *err);

#endif
