/** What an input is like, for people and programs that decide what to do with it. */
#ifndef VOR_METRICS_INSPECT_H
#define VOR_METRICS_INSPECT_H

#include "core/input/domain.h"
#include "core/report.h"

/** Fills in what a cloud alone tells: format, bounds, origin, attributes and points. O(n). */
void vor_inspect_cloud(struct vor_inspect *out, const struct vor_cloud *cloud);

/** Fills in what a prepared domain (vor_input_prepare) tells: all other members but area. Takes the
 *  origin from out, which vor_inspect_cloud has set.
 *  Makes lists of neighbours, as the request says, if the domain has none; of `intrinsic=none` they
 *  are the nearest points. Two points are in one component if a chain of points leads from one to
 *  the other, of which each two that follow each other are in each other's lists: the nearest
 *  points of a lone cluster lie beyond it, but it is not among theirs.
 *
 *  @param[in,out] domain  gets the lists; one-sided entries are dropped
 *  @param[in]     spec    read: intrinsic, vcm
 *
 *  @retval VOR_E_NOMEM    the lists (input/adjacency.h) or 29 bytes a point (with vcm 54) do not
 *                         fit, or those of vor_loops_find (input/loops.h)
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool. The same document for any number of threads. */
VOR_NODISCARD vor_status vor_inspect_domain(struct vor_inspect *out, struct vor_domain *domain,
                                            const struct vor_spec *spec, const struct vor_run *run,
                                            struct vor_error *err);

#endif
