/** Lists of neighbours that stay on one sheet, by distances along the surface from three places.
 *
 *  Source: Lv et al. 2022, "Intrinsic and isotropic resampling for 3D point clouds", Sec. 3.2 and
 *  4.1: the distances along the surface to three points far from each other are coordinates; a
 *  neighbour must be near in space and near in these. Points that mirror each other have the same
 *  coordinates, and are told apart in space.
 *  Departure: coordinates are made for each connected component. The search for the first of the
 *  three begins at the component's first point and not at a random one. Both sets of neighbours
 *  have three times as many points as a list takes, because the coordinates stretch the surface,
 *  and by another factor in each direction.
 *  Departure: marches go along edges between points that are among each other's ten nearest: longer
 *  ones cross from sheet to sheet.
 *
 *  Limit: on a closed thin plate the three places lie on its rim, from which both faces are equally
 *  far. Of the lists of a plate of 1 x 1 x 0.02 with 20,000 points, 18 % of the neighbours lie on
 *  the other face.
 *  Limit: lists have at most VOR_ADJACENT points; fits to more, because of noise, are to the
 *  nearest points. */
#ifndef VOR_INPUT_SATELLITES_H
#define VOR_INPUT_SATELLITES_H

#include "core/geom/graph.h"
#include "core/input/domain.h"

/** Makes the lists of the domain's points, as vor_adjacency_make does (input/adjacency.h).
 *
 *  @param[out] out  free with vor_graph_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 94 bytes a point do not fit, and up to 315 more while it works
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n); the four marches run in one thread (geom/march.h), 19 us a point, the rest on the
 *  run's pool. The same lists for any number of threads. */
VOR_NODISCARD vor_status vor_satellites_make(struct vor_graph *out, const struct vor_domain *domain,
                                             const struct vor_run *run, struct vor_error *err);

#endif
