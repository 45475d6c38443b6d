/** Where the seeds start.
 *
 *  Source: Xiao et al. 2024, Sec. IV-A: as many random input points as seeds are wanted, their
 * cells, and then as many random points in each cell as its share of the area asks for.
 *
 *  Departure: the first draw takes one point from each of n equal stretches of the Morton order,
 * which is more even than independent draws. Departure: the paper leaves the rounding of the shares
 * open; here cell i gets the whole numbers between its bounds in the running sum of area n /
 * sum(area), so that exactly n come out and no cell is off by one. Where n exceeds the input, every
 * input point is a first seed (Sec. V-C). Departure: the points of one cell are not independent of
 * each other. Of sixteen random ones for each the first is the one farthest from those before
 * (Mitchell 1991), and five times each goes to the middle of those that are nearest to it (MacQueen
 * 1967): four for each input point are as even after one iteration as independent ones after four.
 * One alone in its cell starts in the middle of three random ones. Departure: cells of the first
 * draw are cut off by their patches where the input is very uneven, which their areas tell by
 * varying by twice their mean or more; then the started seeds take the place of the draw, twice at
 * most. Departure: where the input has ten points a seed or more, no cells are made. How far the
 * neighbours of a point are tells the area of the stretch it comes from, and each of n equal parts
 * of the running sum of these areas gives one of its own points. That costs a tenth, and ends no
 * less even: for 5,000 of 110,000 points, half of them ten times as dense, delta after 20
 * iterations is 0.066 instead of 0.069 (mean of six seeds). */
#ifndef VOR_CVT_START_H
#define VOR_CVT_START_H

#include "core/seeds/seeds.h"
#include "core/spec.h"

/** Makes *out hold n started seeds, with no index yet.
 *
 *  @param[in] spec  read: seed, boundary
 *
 *  @retval VOR_E_DEGENERATE no seed has a cell with area
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED; a stop does not cut it short */
VOR_NODISCARD vor_status vor_start_seeds(struct vor_seeds *out, const struct vor_domain *domain,
                                         size_t n, const struct vor_spec *spec,
                                         const struct vor_run *run, struct vor_error *err);

#endif
