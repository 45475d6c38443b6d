/** Whether an input has edges, and the scale at which they show.
 *
 *  Source: none of the papers. Noise of more than a spacing hides edges: a crease fits its points
 *  hardly better than a smooth surface does. Among fewer of the points the same fits reach farther,
 *  and there the two sides differ by more than the noise.
 *
 *  Measured: a wedge of 90 degrees, 18,000 points with noise of 1.5 spacings, to as many: 0.4 % of
 *  the points are flagged. Within two spacings of the edge 89 % of the normals are more than 20
 *  degrees off, and none with half of the points; from the edge to the nearest point 2.2 and 0.8
 *  spacings. One scale is chosen for all of the input. */
#ifndef VOR_LOP_SCALE_H
#define VOR_LOP_SCALE_H

#include "core/input/domain.h"
#include "core/input/edges.h"

/** Finds out whether a domain has edges at all; of a dense one, some of its points say so.
 *
 *  @param[out] smooth  1: it has none
 *  @param[out] edges   of all points, free with vor_edges_free; untouched where there are none, or
 *                      only some of the points were asked, and on failure
 *  @param[in]  area    of the surface, in squared normalised units
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  Costs as vor_edges_find of at most some 40,000 points. The same for any number of threads. */
VOR_NODISCARD vor_status vor_lop_has_edges(int *smooth, struct vor_edges *edges,
                                           const struct vor_domain *domain, double area,
                                           const struct vor_run *run, struct vor_error *err);

/** Whether so many flagged points of n are too few to be edges. */
int vor_lop_is_smooth(size_t flagged, size_t n);

/** Takes every second point of an input that seems to have no edges, and of these again, until
 *  edges show. Leaves *out untouched where they never do, and where little noise or several sheets
 *  make it useless to look.
 *
 *  @param[out] out  free with vor_domain_free; untouched on failure
 *
 *  Fails and costs as vor_lop_has_edges for each scale, and O(n log n) for the indexes. */
VOR_NODISCARD vor_status vor_lop_find_scale(struct vor_domain *out, const struct vor_domain *in,
                                            double area, const struct vor_run *run,
                                            struct vor_error *err);

#endif
