/** Evening out (the stage `polish` of a run): short-range repulsion between neighbours on the local
 * quadrics, after a method has spread the points. Nearest-neighbour distances even out far below
 * what a centroidal Voronoi tessellation leaves.
 *
 *  Source: none of the papers. Each step moves a point along the tangent plane by the sum of
 * (h/d)^(2S) over its neighbours at distance d, h the mean spacing, with momentum, at most 5 % of
 * h, and projects it onto the quadric. S rises from 4 to 14: soft repulsion grows regions of one
 * orientation, hard repulsion evens the distances out. Repulsion alone opens holes where regions
 * meet; so, every few steps, the farthest corner of each point's Voronoi cell is found, and where
 * that is farther than a hole among equal distances need be, the point is pulled towards it. Points
 * at the border are not pushed out, and where the input is more than 1.2 spacings away a point goes
 * along it or nearer, not on into the hole. In the second half of the steps the surfaces of an
 * exact input keep its edges (vor_surface_refine); points that were moved off a lattice are not
 * exact. */
#ifndef VOR_SEEDS_REPEL_H
#define VOR_SEEDS_REPEL_H

#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

/** Evens the seeds out and leaves the most even positions of all, those it began with included, in
 *  seeds->xyz. Ends after the steps that the request allows, or at its delta or seconds, or when
 * the watch says so. Does nothing where the request allows no steps or the caller stopped the run.
 *
 *  @param[in,out] told        of the method so far; takes in this stage, and stopped may change
 *  @param[in]     keep_holes  as vor_attach found it
 *  @param[in]     spec        read: polish, delta, seconds
 *  @param[in]     run         may be stopped
 *
 *  @retval VOR_E_CANCELLED the watch answered VOR_CANCEL
 *  @retval VOR_E_NOMEM  52 n bytes do not fit
 *
 *  O(steps n). The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_repel(struct vor_seeds *seeds, struct vor_outcome *told,
                                   int keep_holes, const struct vor_spec *spec,
                                   const struct vor_run *run, struct vor_error *err);

#endif
