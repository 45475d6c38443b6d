/** The voxel grid: one point for each cell of a grid that has some of the input, at their mean.
 *
 *  Source: common practice, as VoxelGrid of PCL and voxel_down_sample of Open3D have it. These take
 *  the edge of a cell; here it is searched for, by halving, so that about as many points come of it
 *  as are wanted. */
#ifndef VOR_BASELINES_VOXELS_H
#define VOR_BASELINES_VOXELS_H

#include "core/base/run.h"

/** Makes about `count` points of n.
 *
 *  @param[out] out    n x 3 at least, or 2 count + VOR_VOXELS_SLACK if that is less; in the order
 * of the first point of each cell
 *  @param[out] made   how many: of the grids tried, the number nearest to count
 *  @param[in]  xyz    n x 3, each of magnitude at most 1; quick where they are in Morton order
 *  @param[in]  count  1 .. n
 *
 *  @retval VOR_E_NOMEM  8 bytes for each point, and 160 to 320 for each wanted, do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n) for each of 32 grids; the cells' numbers on the run's pool, the rest on one thread. The
 *  same points for any number of threads. */
VOR_NODISCARD vor_status vor_voxel_points(float *out, size_t *made, const float *xyz, size_t n,
                                          size_t count, const struct vor_run *run,
                                          struct vor_error *err);

/** Points that may come besides twice as many as are wanted: a grid with more is not looked at. */
#define VOR_VOXELS_SLACK 16

#endif
