/** Points that hang in the air are put beside the data.
 *
 *  Source: none of the papers. Between two points whose normals differ, insertion follows the plane
 *  of one of them, also past the end of its side: where the normal of that point is wrong, or the
 *  other one lies beyond a gap. A point of a side has data of that side near it.
 *
 *  Measured, noise of 0.3 spacings, normals inward in 1,000 without this and with it: gears 15.5
 *  and 6.7, 7.4 and 3.9, a block with bores 3.6 and 0.9, turned pieces 6.2 and 3.1, 8.4 and 6.7,
 *  screws 7.6 and 3.3, 6.4 and 3.0; rms distance to the true surface .230 and .217, .214 and .207,
 *  .139 and .136, .176 and .171, .177 and .172, .158 and .155, .158 and .157 spacings. Where those
 *  were put there, too, that differ from the data by 60 to 90 degrees: gears 3.4 and 3.1, but 3.5 %
 *  of the points beside an edge of 120 degrees had normals of neither side. */
#ifndef VOR_LOP_BESIDE_H
#define VOR_LOP_BESIDE_H

#include "core/input/domain.h"
#include "core/lop/samples.h"

/** What points are put beside. */
struct vor_lop_beside {
    const struct vor_lop_samples *data; /**< with their areas; NULL: nothing is put anywhere */
    const struct vor_domain *domain;    /**< whose points, in their order, the data are */
    double sigma_n; /**< radians, up to pi / 2: as of insertion (lop/insert.h) */
};

/** Puts a place onto the plane of the datum nearest to it, no farther from that datum than half of
 *  the spacing of the data.
 *
 *  @param[in,out] x     the place
 *  @param[in,out] last  of a row of places near each other
 *
 *  @return the datum */
size_t vor_lop_beside_face(float *x, const struct vor_lop_beside *beside,
                           struct vor_knn_last *last);

/** Moves those of the points from `first` on that have no datum of their side within a spacing of
 *  the data, and face away from the datum nearest to them: they are put beside that datum, and get
 *  its normal.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log m), on the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_lop_beside_put(struct vor_lop_samples *samples, size_t first,
                                            const struct vor_lop_beside *beside,
                                            const struct vor_run *run, struct vor_error *err);

#endif
