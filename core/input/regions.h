/** Sheets told apart over the whole input, where single places do not tell them apart.
 *
 *  Lists that were made place by place (input/adjacency.h) hold points of two sheets
 *  where these are nearer to each other than their spacing. Here pairs of points say whether they
 *  lie on one sheet or on two, by what two sheets fitted together around them say (input/votes.h),
 *  and where none are by how far the surface fitted to the list of one passes the other; all of
 *  them together decide (geom/parting.h). Then each point between two regions is asked
 *  again, from its neighbours alone: it belongs to the region through whose points around it a
 *  smooth surface (geom/through.h) leads nearest to it. Lists there keep to one region.
 *
 *  Two faces of one thin part are two regions, though they are joined around its rim: there both
 *  end the same way and lean towards each other, and lists of points at the end go around it. So
 *  they do over a crease, where all that lies beyond either end leans to the side of the other.
 *
 *  Source: none of the papers; the second step is leave-one-out cross-validation. */
#ifndef VOR_INPUT_REGIONS_H
#define VOR_INPUT_REGIONS_H

#include "core/input/domain.h"

/** Makes lists of a graph better. Those of points around which all belong to one region stay.
 *
 *  @param[in,out] graph  of the domain's points, by vor_adjacency_make
 *
 *  @retval VOR_E_NOMEM 574 bytes a point do not fit, and 16 for each pair that parts, of 24 at most
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the graph is to be freed
 *
 *  O(n log^2 n), on the run's pool but for the decisions, which take one thread. The same lists for
 *  any number of threads. */
VOR_NODISCARD vor_status vor_regions_make(struct vor_graph *graph, const struct vor_domain *domain,
                                          const struct vor_run *run, struct vor_error *err);

#endif
