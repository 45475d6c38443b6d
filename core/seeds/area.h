/** Area of the surface that an input describes, from the cells of some of its points.
 *
 *  Source: Xiao et al. 2024, Sec. IV-A: each cell's share of the area says how many points it gets.
 *  Departure: the draw takes one point from each of n equal stretches of the Morton order, which is
 *  more even than independent draws. */
#ifndef VOR_SEEDS_AREA_H
#define VOR_SEEDS_AREA_H

#include "core/geom/integrate.h"
#include "core/seeds/seeds.h"

/** Moments of scratch->cell, the cell of seed i, with the density where there is one.
 *
 *  @return as vor_cell_moments
 *
 *  O(corners of the cell). */
int vor_area_moments(struct vor_moments *out, const struct vor_seeds *seeds,
                     const struct vor_scratch *scratch, size_t i);

/** Puts the seeds at points of their domain, all different: a random one from each of seeds->n
 *  equal stretches of its order. seeds->n is at most the number of points.
 *
 *  @param[in] seed  of the random choices
 *
 *  Cannot fail. O(n). */
void vor_area_draw(struct vor_seeds *seeds, uint64_t seed);

/** Clips the cell of each seed where it is, and sums their areas. Indexes the seeds first.
 *
 *  @param[out] end  seeds->n numbers: end[i] is the sum of the areas of cells 0 .. i, in squared
 *                   normalised units; a seed without a surface has area 0
 *
 *  @retval VOR_E_DEGENERATE no cell has an area
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool. The same bits for any number of threads. A run that is late takes
 *  the areas of discs (seeds/hurried.h) instead of cells. */
VOR_NODISCARD vor_status vor_area_cells(double *end, struct vor_seeds *seeds,
                                        struct vor_error *err);

/** Computes the area of the surface as that of the cells of half of the points, at most
 *  SURFACE_SEEDS (area.c) of them.
 *
 *  @param[out] out   in squared normalised units
 *  @param[in]  seed  of the random choices
 *
 *  Fails as vor_area_cells. O(n log n) in the cells. */
VOR_NODISCARD vor_status vor_area_of_surface(double *out, const struct vor_domain *domain,
                                             uint64_t seed, const struct vor_run *run,
                                             struct vor_error *err);

#endif
