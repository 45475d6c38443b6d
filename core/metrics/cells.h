/** How far points on a surface are from the best that is possible, from their Voronoi cells, each
 *  in the tangent plane of its point.
 *
 *  The energy of a tessellation of area A by n cells is least where all are regular hexagons: n 5 /
 *  (18 sqrt 3) (A / n)^2. Source: Fejes Toth 1959; Gersho 1979, "Asymptotically optimal block
 *  quantization".
 *  Departure: cells that do not close among the neighbours looked at, as at a border, are left out,
 *  of A and n too. */
#ifndef VOR_METRICS_CELLS_H
#define VOR_METRICS_CELLS_H

#include "core/base/run.h"

/** Most neighbours that a cell is cut by. */
#define VOR_CELLS_NEAR 20

/** The figures; all 0 where no cell closes. */
struct vor_cells {
    double eta;  /**< energy over the least there can be, minus 1; 0 is the limit */
    double six;  /**< share of the cells with six sides */
    double gap;  /**< farthest that a place is from its nearest point, over the spacing of the
                      hexagonal lattice of the same area and count: 1 / sqrt(3) is the limit */
    size_t wide; /**< places, each shared by three cells, farther than 0.64 of that spacing */
    size_t open; /**< cells that are left out */
};

/** Where the neighbours of a point lie.
 *
 *  @param[in]  ctx     of the source
 *  @param[in]  worker  of the run's pool
 *  @param[out] offset  from point i to at most VOR_CELLS_NEAR others, the nearest first; any unit
 *  @param[out] metric  xx xy xz yy yz zz of the metric that the cell is in; set to that of equal
 *                      lengths by the caller
 *
 *  @return how many */
typedef unsigned (*vor_cells_near)(void *ctx, size_t i, unsigned worker, float *offset,
                                   double metric[6]);

/** Measures the cells of n points.
 *
 *  @retval VOR_E_NOMEM            48 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n), on the run's pool. The same bits for any number of threads. */
VOR_NODISCARD vor_status vor_cells_of(struct vor_cells *out, size_t n, vor_cells_near near,
                                      void *ctx, const struct vor_run *run, struct vor_error *err);

struct vor_knn;

/** Measures the cells of n points (n x 3), by an index of them. Fails as vor_cells_of; O(n log n).
 */
VOR_NODISCARD vor_status vor_cells_measure(struct vor_cells *out, const float *xyz, size_t n,
                                           const struct vor_knn *knn, const struct vor_run *run,
                                           struct vor_error *err);

#endif
