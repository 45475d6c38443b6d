/** Area of the surface that an input describes, from the cells of some of its points.
 *
 *  Source: Xiao et al. 2024, Sec. IV-A, where the shares of these areas say how many points each
 * cell gets. Departure: the points are one from each of n equal stretches of the Morton order,
 * which is more even than independent draws. */
#ifndef VOR_SEEDS_AREA_H
#define VOR_SEEDS_AREA_H

#include "core/seeds/seeds.h"

/** Puts the seeds at points of their domain, one from each of seeds->n equal stretches of its
 *  order, all different; at most as many seeds as points.
 *
 *  @param[in] seed  of the random choices */
void vor_area_draw(struct vor_seeds *seeds, uint64_t seed);

/** Clips the cells of the seeds where they are.
 *
 *  @param[out] end  seeds->n numbers: end[i] is the sum of the areas (normalised) up to and with
 *                   cell i; a seed without a surface has none
 *
 *  @retval VOR_E_DEGENERATE no cell has an area
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED */
VOR_NODISCARD vor_status vor_area_cells(double *end, struct vor_seeds *seeds,
                                        struct vor_error *err);

/** Area of the surface, in squared normalised units: that of the cells of half of the points,
 *  20,000 at most. Fails as vor_area_cells.
 *
 *  @param[in] seed  of the random choices */
VOR_NODISCARD vor_status vor_area_of_surface(double *out, const struct vor_domain *domain,
                                             uint64_t seed, const struct vor_run *run,
                                             struct vor_error *err);

#endif
