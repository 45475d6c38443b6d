/** Puts the points of a result onto the lattice that the input's coordinates were rounded to, no
 * two into one cell: voxels in, voxels out.
 *
 *  Each point goes into the cell that it lies in. Of several in one cell the one nearest to the
 *  middle stays; each other one, in their order, goes to the nearest free cell that the surface
 *  passes through, at most four from its own.
 *
 *  Source: none of the papers; they place points anywhere. */
#ifndef VOR_OUTPUT_SNAP_H
#define VOR_OUTPUT_SNAP_H

#include "core/cloud/cloud.h"
#include "core/seeds/seeds.h"

/** A lattice in the relative coordinates of the cloud that is on it: along axis c the levels are
 *  first[c] + cell[c] * i, i from 0 to last[c]. */
struct vor_levels {
    double first[3], cell[3];
    int64_t last[3];
};

/** Finds the levels of a cloud from what the domain that was made of it knows of its lattice. Whole
 *  numbers are levels exactly, others up to rounding to float32. An axis with too few levels to
 * show a cell has that of the others.
 *
 *  @retval VOR_E_PARAM the cloud is on no lattice, or an axis has more than 2^30 levels; the
 *                      parameter is "lattice"
 *
 *  O(n). */
VOR_NODISCARD vor_status vor_levels_find(struct vor_levels *out, const struct vor_cloud *in,
                                         const struct vor_domain *domain, struct vor_error *err);

/** Moves each seed to the middle of a cell of its own, within the box of the levels.
 *
 *  @retval VOR_E_TARGET a seed finds no free cell: the surface passes through too few
 *  @retval VOR_E_NOMEM  48 bytes a point do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_seeds_index
 *
 *  O(n log n), on one thread but for the last step. */
VOR_NODISCARD vor_status vor_snap_seeds(struct vor_seeds *seeds, const struct vor_levels *levels,
                                        struct vor_error *err);

/** Gives the points of a result, which lie on the levels of `in` up to the rounding of the domain,
 *  the coordinates of the levels. O(n). */
void vor_snap_cloud(struct vor_cloud *out, const struct vor_levels *levels,
                    const struct vor_cloud *in);

#endif
