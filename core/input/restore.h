/** Moves the points of a decoded cloud back towards the surface that a codec's rounding moved them
 *  off, each within the cell of the lattice that it was rounded to.
 *
 *  A point of a cell is off its old place by at most half a cell along each axis, by nearly the
 *  same law everywhere: of variance h^2 / 12. The part of it along the surface cannot be seen; the
 *  part across is seen beside the point's neighbours. Quadrics are fitted to the neighbours of some
 *  of the points, each place with the weight of all the points that were rounded to it, or cells
 *  that the surface just touches would count as much as those it runs through. Along an axis that a
 *  surface crosses less than a cell of, a wall straight before a depth camera, rounding moves all
 *  points alike, and what differs is mostly their own. A way beyond the one that rounding can have
 *  moved a point is not believed either. Each fit tells all its points how far off it they are,
 * less where they are farther off than rounding explains: what is left is the cloud's own noise, or
 * a detail that the quadric misses, and of the sum of two errors the best linear estimate of one is
 *  its share of the variance (Wiener). A point goes to the mean of what it is told, weighted by the
 *  inverse of the variance of each fit's error. At an edge the fits across it have a large one, so
 *  those of the point's own side decide.
 *
 *  Source: moving least squares with quadrics (Lv et al. 2022, "Intrinsic and isotropic resampling
 *  for 3D point clouds", Sec. 3.1). Departure: one fit serves all the points of its neighbourhood,
 *  and a point takes the mean of a dozen fits. Measured on bunny in 7 bits, gain in D1 and D2: the
 *  point's own fit to 24 neighbours .55 and 1.8 dB, the mean of the fits to 24 around it 1.1 and
 *  4.8, to 60 1.2 and 5.7, for less time, as one point in five has a fit. Each fit takes as many
 *  neighbours as predict a further point best (Akaike 1969, "Fitting autoregressive models for
 *  prediction"): with 120, 60 or 30 of them files of equal D2 are 18.3 % smaller, with 60 or 30,
 * the one with the smaller error, 17.4 % (mean of nine clouds, tests/by_hand/bench/codec.pl). On a
 * depth image of a room in 6 bits D2 loses .65 dB without the two limits above, .14 with the first
 * alone, .03 with both.
 *
 *  Not done: a decoder that puts points into the corners of cells instead of their middle shifts
 *  the cloud by half a cell, which the points do not show. */
#ifndef VOR_INPUT_RESTORE_H
#define VOR_INPUT_RESTORE_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/report.h"

/** Moves the points of a cloud. Their number, order and attributes stay; points that share a place
 *  move together. A point that does not move stays as it is, bit for bit. None moves where the
 *  cloud has no lattice, or cells that are small against its spacing, or too few points to tell:
 *  the report has a warning then. A cloud of several lattices is looked at by regions of 256
 *  points, and one counts where the next has the same.
 *
 *  The report gets the lattice, and how many points were moved off it.
 *
 *  @param[in] spec  of the process restore
 *
 *  @retval VOR_E_SPLATS as vor_splats_check
 *  @retval VOR_E_NOMEM 101 bytes a point do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the cloud is as it was
 *
 *  O(n log n), on the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_restore_cloud(struct vor_cloud *cloud, struct vor_report *report,
                                           const struct vor_spec *spec, const struct vor_run *run,
                                           struct vor_error *err);

#endif
