/** Which input points around one lie on its sheet. */
#ifndef VOR_INPUT_ADJACENCY_H
#define VOR_INPUT_ADJACENCY_H

#include "core/geom/graph.h"
#include "core/input/domain.h"

/** Neighbours that a point has at most. */
#define VOR_ADJACENT 20

/** Makes the lists of the domain's points.
 *
 *  @param[out] out  free with vor_graph_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 94 bytes a point do not fit, and 28 more while it works
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool. The same lists for any number of threads. */
VOR_NODISCARD vor_status vor_adjacency_make(struct vor_graph *out, const struct vor_domain *domain,
                                            const struct vor_run *run, struct vor_error *err);

#endif
