/** Turns regions whose signs most of the edges around them contradict.
 *
 *  A spanning tree joins two regions by one edge, and one wrong edge turns a whole region: a bore,
 *  whose rim noise rounds off. All edges across its rim together say so.
 *
 *  Source: Kernighan and Lin 1970, "An efficient heuristic procedure for partitioning graphs", with
 *  regions in place of nodes: the one whose turn gains most is turned, until none gains. A region
 * is what edges that agree join, across points of which hardly an edge disagrees; the points
 * between regions belong to the one beside them that they agree with most. */
#ifndef VOR_GEOM_FLIP_H
#define VOR_GEOM_FLIP_H

#include "core/geom/winding.h"

/** Regions grow by the nearest of a point's neighbours, one in so many: the farthest lie across a
 *  rim, and some of these agree by chance. A bore of 183 points that faces inward, of the edges
 *  across its rim that agree and lie between points without doubt: 15 by all, 0 by these. */
enum { VOR_FLIP_REACH = 3 };

/** What decides. */
struct vor_flip_how {
    double doubt;  /**< share of the votes of its edges against the sign of a point, above which it
                        is between regions */
    double margin; /**< votes around a region against its sign less those for it, over all, above
                        which it is turned */
    double closed; /**< mean winding number, or less its sign, at which a component is closed, */
    double apart;  /**< and mean square of how far they are from it, below which it is well closed
                        (geom/winding.h), and stays so; */
    double clean;  /**< below this it has no noise, and nothing is turned: there a tree goes wrong
                        less often than edges across a gap, as between fingers side by side */
};

/** Turns regions.
 *
 *  @param[in,out] span    its signs
 *  @param[in]     edge    as of vor_span_make
 *
 *  @retval VOR_E_NOMEM 6 bytes a point, and 16 for each edge between regions, do not fit; signs
 *                      are lost
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; likewise
 *
 *  O(n most), n for each ring of points around a region that belong to none by themselves, and of
 *  the regions that are turned O(their edges to others); where any is, vor_winding_find. The same
 * signs for any number of threads. */
VOR_NODISCARD vor_status vor_flip_regions(struct vor_span *span, const struct vor_graph *graph,
                                          const unsigned char *edge,
                                          const struct vor_winding_points *points,
                                          const struct vor_flip_how *how, const struct vor_run *run,
                                          struct vor_error *err);

#endif
