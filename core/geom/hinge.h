/** Signs of faces that meet at creases, by which side of one is seen from the other.
 *
 *  Beside a crease normals are those of neither face, and edges of a graph tell little. From either
 *  face some of the other is seen, from points far enough from the crease; if their signs agree,
 *  both see its front or both its back. The solid angle says which, and how much of it.
 *
 *  Faces are what edges join whose ends lie in each other's plane, their signs consistent; points
 *  between faces belong to one beside them. Pairs of faces are joined, those first that see most of
 *  each other: with the signs that this says, or with those they have where it says little. Where
 *  nothing contradicts the signs that a component has, it keeps all of them. And where a quarter of
 *  its points lie in no face, nothing is decided: where noise is 0.3 of the spacing, and of scans
 * with noise and steps of depth (autzen, office1). */
#ifndef VOR_GEOM_HINGE_H
#define VOR_GEOM_HINGE_H

#include "core/geom/winding.h"

/** A surface with signs. */
struct vor_hinge {
    const struct vor_span *span;
    const struct vor_graph *graph;
    const struct vor_winding_points *points;
    const struct vor_knn *knn; /**< over the points */
    double bend; /**< of two points of a face, how far off each other's plane they may be, over
                      their distance, squared, and 1 less the cosine between their normals; sum */
    double seen; /**< what two faces see of each other, in spheres, below which it says nothing: the
                      root of its mean product. At 90 degrees 0.12 */
    double agree; /**< share of that product that must be left where its signs differ */
};

/** Finds signs for the points.
 *
 *  @param[out] odd  n: as span->odd
 *
 *  @retval VOR_E_NOMEM 20 bytes a point, and 16 for each edge between faces, do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n), and VOR_WINDING_PLACES searches for each pair of faces, on the run's pool. The same
 *  signs for any number of threads. */
VOR_NODISCARD vor_status vor_hinge_find(unsigned char *odd, const struct vor_hinge *on,
                                        const struct vor_run *run, struct vor_error *err);

#endif
