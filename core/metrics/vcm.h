/** Sharp edges of an input by the Voronoi covariance measure (VCM).
 *
 *  The part of a point's Voronoi cell that lies within a ball is long along the normal. Its second
 *  moments about the point, summed over the nearest points, have one large eigenvalue on a smooth
 *  surface, two at a sharp edge or a border, three at a corner. A point is marked where the second
 *  largest is at least VOR_VCM_EDGE of all three together.
 *
 *  Source: Merigot, Ovsjanikov, Guibas 2011, "Voronoi-based curvature and feature estimation from
 *  point clouds", which Lv et al. 2022, Sec. 4.2, take edges from. Lv have no radii; ball and sum
 *  are by numbers of points here, as the density of scans varies.
 *  Departure: each cell is measured in units of its own ball's radius, half the distance to the
 * last of its points: whatever cuts the cell within the ball is among them.
 *
 *  Precision and recall as in input/edges.h, of this and of vor_edges_find, 30,000 points: fandisk
 *  .884 .972 (.993 .974), with noise of .34 spacings .659 .973 (.920 .973), of .85 .32 .98 (.62
 *  .70); of igea 2.5 % of the points are marked (.1 %), of a sphere none. With cells of 60, 100,
 *  200 points and sums of a quarter of that: .772 .984, .668 .973, .503 .971 on fandisk.
 */
#ifndef VOR_METRICS_VCM_H
#define VOR_METRICS_VCM_H

#include "core/input/domain.h"

/** Points that a cell is cut by, which reach twice as far as the ball, and points of a sum, where
 *  fits take VOR_NEIGHBORS_FEWEST; with noise more, in proportion, at most VOR_VCM_MOST. */
enum { VOR_VCM_AROUND = 100, VOR_VCM_SUMMED = 12, VOR_VCM_MOST = 256 };

/** From CGAL's example of vcm_estimate_edges. At .16 / .2: .668 .973 / .759 .966 (cells of 100
 *  points, sums of 25). */
#define VOR_VCM_EDGE 0.16

/** Second moments of a point's Voronoi cell within a ball around it.
 *
 *  @param[out] out     upper triangle xx xy xz yy yz zz, in units of radius^5
 *  @param[in]  around  k x 3: the point, and then others, at other places
 *  @param[in]  radius  > 0; the ball is a polyhedron, up to VOR_VCM_BEYOND times as large
 *
 *  O(k), some 12 us for 100 points on a surface. Thread-safe. */
void vor_vcm_cell(double out[6], const float *around, size_t k, double radius);

/** The corners of what stands for the ball lie at most so many radii from its centre. */
#define VOR_VCM_BEYOND 1.03

/** Sets flag[0 .. domain->n - 1]: 1 for points at sharp edges, corners and borders, else 0.
 *
 *  @param[in] domain  indexed; read: xyz, knn, known.neighbors.usual
 *
 *  @retval VOR_E_NOMEM 24 bytes a point do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool: 14 us a point without noise, up to 45 with. The same marks for
 *  any number of threads. */
VOR_NODISCARD vor_status vor_vcm_mark(unsigned char *flag, const struct vor_domain *domain,
                                      const struct vor_run *run, struct vor_error *err);

#endif
