/** Points that hang in the air are put beside the data.
 *
 *  Source: none of the papers. Between two points whose normals differ, insertion follows the plane
 *  of one of them, also past the end of its side: where the normal of that point is wrong, or the
 *  other one lies beyond a gap. A point of a side has data of that side around it, on its plane: it
 *  lies within their hull or near it, seen along its normal. One that does not goes to the nearest
 *  of the discs around the data, whatever their side, and gets its normal; one whose
 *  normal is less than 60 degrees from that keeps its own, and its plane. One past an edge has all
 *  data to one side of it, and goes back to their hull.
 *
 *  Measured, noise of 0.3 spacings, normals inward in 1,000 where only those moved that face away
 *  from the nearest datum, once, in the end, and as it is: gears 11.1 and 1.9, 3.9 and .9, 1.8 and
 *  0, 1.9 and .3; turned pieces 3.1 and 2.0, 5.3 and 6.7; polyhedra 8.2 and 3.2, 2.5 and 2.2; rms
 *  distance to the true surface .222 and .182, .201 and .175, .151 and .130, .148 and .133; .168
 *  and .159, .171 and .155; .110 and .094, .096 and .091 spacings. Once only, in the end: a box
 *  to 500, delta .073, as it is .053. Where points 30 degrees from the datum got its plane, too,
 *  3 % of those beside an edge of 150 degrees were two sigmas of noise off both sides. */
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

/** Puts a place onto the disc of the datum nearest to it: its plane, three quarters of a spacing of
 *  the data around it.
 *
 *  @param[in,out] x     the place
 *  @param[in,out] last  of a row of places near each other
 *
 *  @return the datum */
size_t vor_lop_beside_face(float *x, const struct vor_lop_beside *beside,
                           struct vor_knn_last *last);

/** Whether no data of its side are around a point: it is farther than three quarters of a spacing
 *  of the data from their hull, or from all of their planes. O(log n). Thread-safe. */
int vor_lop_beside_hangs(const float *x, const float *n, const struct vor_lop_beside *beside);

/** Puts a point that no data of its side are around onto the nearest disc, with its normal. Where
 *  the two normals are less than 60 degrees apart, a datum stays, and another point moves along its
 *  own plane to where the disc is.
 *
 *  @param[in,out] x, n  the point and its normal
 *  @param[in]     self  its number if it is a datum, which then does not count; else SIZE_MAX
 *  @param[in,out] last  of a row of points near each other
 *
 *  O(log n). Thread-safe. */
void vor_lop_beside_land(float *x, float *n, const struct vor_lop_beside *beside, size_t self,
                         struct vor_knn_last *last);

/** Lands the points from `first` on, and puts those that then lie past all data around them back.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log m), on the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_lop_beside_put(struct vor_lop_samples *samples, size_t first,
                                            const struct vor_lop_beside *beside,
                                            const struct vor_run *run, struct vor_error *err);

#endif
