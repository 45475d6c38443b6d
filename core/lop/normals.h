/** The input as oriented points whose normals do not smear over edges, and which lie where the
 *  points of their own side say.
 *
 *  Source: Huang et al. 2013, "Edge-Aware Point Set Resampling", Sec. 4, Eq. 1 and 2: normals are
 *  smoothed by those of the neighbours, the more the nearer and the more alike these are (theta,
 *  psi), of angle sigmaN.
 *
 *  Departure: the paper starts from a PCA at each point and smooths the normals of the samples
 *  alone. Near an edge such normals lie between those of both sides, and smoothing keeps some: one
 *  point in ten next to an edge of 90 degrees. Here each point takes the best plane among those
 *  through the neighbourhoods around it, which near an edge is one that does not cross it: flat,
 * through the point, and not facing away from it, as the other face of a wall does. Then neighbours
 * count by how near their own planes pass to the point (beside theta and psi), and the normal
 * starts anew from that of a neighbour which most of these agree with. Departure: the points move
 * along their normals onto their side. A neighbour is seen along the mean of both normals, to which
 * the chord of a circle is perpendicular: curvature then moves no point, as it does with the normal
 * of either. Departure: points on fillets about as wide as the fits are put onto these
 * (lop/fillets.h). Departure: where the input has edges, a point that none of its own side are
 * around goes beside the others (lop/beside.h). Departure: the neighbours are as many as a fit
 * takes there, whatever sigmaP: planes through more of them make facets of a surface that bends.
 * sigmaP is the reach of the projection and of insertion. */
#ifndef VOR_LOP_NORMALS_H
#define VOR_LOP_NORMALS_H

#include "core/input/orient.h"
#include "core/lop/samples.h"

/** How that is done. */
struct vor_lop_normals_how {
    double sigma_n;  /**< radians, up to pi / 2 */
    size_t points;   /**< of the result: sides are found on about as many (input/orient.h) */
    double area;     /**< of the surface, in squared normalised units */
    int plain;       /**< there is one sheet in each place (input/orient.h) */
    int edges;       /**< the input has some: fillets are told from them (lop/fillets.h) */
    uint32_t rounds; /**< times that normals are smoothed and points moved; 0: they stay */
    struct vor_orientation *orientation; /**< out: all zero before; the sides of the domain, free
                                              with vor_orientation_free, also on failure */
};

/** Makes the points of the domain, in their order.
 *
 *  @param[out] out  free with vor_lop_samples_free; untouched on failure. area: squared distance of
 *                   each point of the domain to the last of the VOR_LOP_AREA_OF nearest
 *
 *  @retval VOR_E_NOMEM  94 bytes a point, and 4 for each neighbour that counts, do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_lop_normals(struct vor_lop_samples *out,
                                         const struct vor_domain *domain,
                                         const struct vor_lop_normals_how *how,
                                         const struct vor_run *run, struct vor_error *err);

#endif
