/** Where the seeds start.
 *
 *  Source: Xiao et al. 2024, Sec. IV-A: draw as many random input points as seeds are wanted, clip
 *  their cells, and place as many random points in each cell as its share of the area asks for.
 *
 *  Departure: the first draw takes one point from each of n equal stretches of the Morton order,
 *  which is more even than independent draws. Where n exceeds the input, every input point is drawn
 *  (Sec. V-C).
 *  Departure: the paper leaves the rounding of the shares open. Here cell i gets the whole numbers
 *  between its bounds in the running sum of area n / sum(area): exactly n come out, and no cell is
 *  off by one.
 *  Departure: the seeds of one cell are not independent of each other. For each, sixteen random
 *  points of the cell are drawn; it begins at the one farthest from the seeds before it (Mitchell
 *  1991, "Spectrally optimal sampling for distribution ray tracing"), and then moves five times to
 *  the mean of the random points nearest to it (MacQueen 1967). Measured, igea 30,000 to 120,000:
 *  delta after one iteration is 0.110, with independent seeds 0.107 after four; it costs 2 us of
 *  CPU a seed. So `upsample` takes one iteration.
 *  Departure: a seed alone in its cell begins at the mean of three random points, not at the
 *  middle, which would leave the rims of gaps empty (office1: delta 0.176, from the middle 0.185).
 *  Departure: where the input is very uneven, patches cut the cells of the first draw off. Their
 *  areas then vary by more than twice their mean, and the started seeds replace the draw, at most
 *  twice.
 *  With a density rho a cell's share goes with its area times sqrt(rho).
 *  Source: Chen 2018, Sec. 4.1. Departure: it says rho; the spacing of a tessellation goes with
 *  rho^(-1/4), and Lloyd's method does not correct a start that is too dense over wide regions (2D,
 *  4,000 seeds, rho 16 : 1: from rho the slope of log spacing over log rho is -0.53 after 35 and
 *  after 200 iterations, from sqrt(rho) -0.26).
 *  Departure: where the input has ten points a seed or more, no cells are made. The distance from a
 *  point to its neighbours gives the area of its stretch, and each of n equal parts of the running
 *  sum of these areas gives one of its own points. That takes a tenth of the time and ends no less
 *  even: for 5,000 of 110,000 points, half of them ten times as dense, delta after 20 iterations is
 *  0.066, with cells 0.069 (mean of six seeds).
 *
 *  With an earlier result the seeds start where its points were (seeds/warm_start.h). */
#ifndef VOR_SEEDS_START_H
#define VOR_SEEDS_START_H

#include "core/seeds/seeds.h"
#include "core/spec.h"

/** Makes n seeds at their first positions, not indexed yet; out->area is the area of the surface.
 *
 *  @param[out] out   free with vor_seeds_free; untouched on failure
 *  @param[in]  spec  read: seed, boundary, coherence
 *
 *  @retval VOR_E_DEGENERATE no seed has a cell with area
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED; a stop does not interrupt it
 *
 *  O(n log n), on the run's pool. The same positions for any number of threads, unless the run is
 *  late: then the seeds that are left start between input points (seeds/hurried.h). */
VOR_NODISCARD vor_status vor_start_seeds(struct vor_seeds *out, const struct vor_domain *domain,
                                         size_t n, const struct vor_spec *spec,
                                         const struct vor_run *run, struct vor_error *err);

/** Makes n >= 1 seeds between the points of the domain, which are to stay: as many in the cell of
 *  each as in those of others, or one less. There are none where there is no surface, or in cells
 *  3.5 times as far across as those near them (VOR_OUTSIDE_MOVING). They keep away from the
 *  point of their cell as from each other, and lie where the points around them have the surface:
 *  these count by the inverse fourth power of their distances.
 *
 *  Of kitti, quarters of three draws in 7 to 10 bits to all points, at equal D2 17, 24, 36 % of the
 *  bytes are saved with seeds in wide cells too, 36, 36, 38 % with these; 38, 40, 29 % if what is
 *  wide is judged by all cells, but then sparse parts get none.
 *
 *  Equal shares keep the input's density, and put few points where it shows little: hippo1, a
 *  quarter of 6,000 points in 10 bits to all of them, D1 / D2 with shares by area 18.7 / 28.0, by
 *  its root 19.3 / 29.4, equal 20.1 / 30.8, with one iteration and eight steps of polish; without
 *  these 20.8 / 31.1. A cell ends halfway to the six points around: the corners of wide cells reach
 *  into gaps and over borders. At 0.4 / 0.5 / 0.7 / 1 of the way: fandisk 13.4 / 29.3, 14.3 / 29.1,
 *  15.9 / 28.7, 15.6 / 28.4; b9_training 22.6 / 31.2, 23.2 / 31.2, 24.1 / 30.8, 24.5 / 30.7.
 *
 *  Parameters, failures and cost as vor_start_seeds. */
VOR_NODISCARD vor_status vor_start_between(struct vor_seeds *out, const struct vor_domain *domain,
                                           size_t n, const struct vor_spec *spec,
                                           const struct vor_run *run, struct vor_error *err);

#endif
