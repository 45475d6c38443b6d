/** Sheets grown from where they are known to where they are not.
 *
 *  Where a surface bends too much for a look at one place, the lists of input/adjacency.h mix two
 *  sheets that are nearer to each other than the spacing; fits there run between both, and so do
 *  points that move on them. But next to such a place the sheets are mostly known. A point takes
 *  the sheet of the neighbour whose surface, continued, leads nearest to it; its list is made of
 *  the points along that surface, if one fits these far better than those of before. Points that
 *  found their sheet lead the next ones.
 *
 *  Source: none of the papers; region growing as in image segmentation. */
#ifndef VOR_INPUT_GROW_H
#define VOR_INPUT_GROW_H

#include "core/input/domain.h"

enum {
    /** Nearest points that are looked at for those of one sheet: twice 20 of two, and a few. */
    VOR_GROW_AROUND = 3 * VOR_NEIGHBORS_FEWEST
};
/** Most that a surface may be off a point that it leads to, in spacings, and what the distance
 *  between both adds. Half of it: the same within 3 %. */
#define VOR_GROW_LED 0.3
/** Distance of a point off the surface of one of its list, in spacings, from which on that lies on
 *  another sheet. Of pairs whose lists are sure, those on one sheet are less than 0.13 off in 99 of
 *  100 cases (shell; 0.22 on arma2), those on two more than 0.24. */
#define VOR_GROW_ACROSS 0.2

/** Makes lists of a graph better. Lists that are sure stay.
 *
 *  @param[in,out] graph  of the domain's points, by vor_adjacency_make
 *
 *  @retval VOR_E_NOMEM 66 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the graph is to be freed
 *
 *  O(n), and O(log n) for each point whose list is not sure, on the run's pool. The same lists for
 *  any number of threads. */
VOR_NODISCARD vor_status vor_grow(struct vor_graph *graph, const struct vor_domain *domain,
                                  const struct vor_run *run, struct vor_error *err);

#endif
