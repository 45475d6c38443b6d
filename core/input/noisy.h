/** Where an input is noisy: hardly a point there lies on a surface of even its nearest.
 *
 *  Source: none of the papers. Detail, creases and other sheets are in some places of a region, and
 *  noise is in all of it; so a low quantile of what surfaces leave tells it, as in input/edges.h.
 */
#ifndef VOR_INPUT_NOISY_H
#define VOR_INPUT_NOISY_H

#include "core/geom/graph.h"
#include "core/input/domain.h"

/** Points of a region: those that follow each other in a domain are near each other. Not measured.
 */
enum { VOR_NOISY_REGION = 1024 };

/** Finds the points in noisy regions, each of VOR_NOISY_REGION points that follow each other, the
 * last of up to 2,047.
 *
 *  @param[out] out    n: 1 for those, else 0
 *  @param[in]  graph  lists of the points nearest to each, nearest first
 *
 *  @retval VOR_E_NOMEM 4 bytes a point do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n), a microsecond a point, on the run's pool. The same for any number of threads. */
VOR_NODISCARD vor_status vor_noisy_find(unsigned char *out, const struct vor_domain *domain,
                                        const struct vor_graph *graph, const struct vor_run *run,
                                        struct vor_error *err);

#endif
