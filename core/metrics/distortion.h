/** What MPEG calls the geometry distortion of a point cloud: D1 (point to point) and D2 (point to
 *  plane), as mpeg-pcc-dmetric 0.14 computes them by default.
 *
 *  For each point of one cloud its nearest point of the other is found. The square of the distance
 *  counts for D1, the square of the distance along the normal there for D2; the mean over a cloud's
 *  points is the error of that direction, the larger of both directions the error. Points that
 *  coincide count once, with the first one's normal. Where several points are equally near, up to
 *  30 of them, D2 takes the mean of their squares. The normals are those of the reference. A point
 *  of the cloud gets the mean, not scaled to unit length, of the normals of the reference points
 *  whose nearest it is; if there are none, its normal is never used.
 *
 *  Departure: a reference point that carries no normal, or one that is zero or not finite, gets
 *  that of the quadric through its 20 nearest; dmetric leaves D2 out. Such a normal has no side, so
 *  it enters a mean with the sign that agrees with what is summed before it.
 *  Departure: carried normals are scaled to unit length first; dmetric takes them as they are.
 *  Departure: equally near means equal squares of distances; dmetric lets them differ by 1e-8,
 *  whatever the unit.
 *  Departure: where there is no normal, or a mean of normals is zero, the whole distance counts.
 *
 *  Source: D. Tian et al. 2017, "Geometric distortion metrics for point cloud compression", ICIP;
 *  what mpeg-pcc-dmetric does was read in its source (github.com/MPEGGroup/mpeg-pcc-dmetric, which
 *  calls itself 0.14.1), of which nothing is taken. */
#ifndef VOR_METRICS_DISTORTION_H
#define VOR_METRICS_DISTORTION_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"

/** Two clouds in one frame, n x 3 and m x 3 floats, each of magnitude at most 1e6; all borrowed. */
struct vor_distortion_pair {
    const float *xyz, *reference;
    size_t n, m;
    const struct vor_attribute *normals; /**< the reference's, m of them; NULL: all are fitted */
};

/** Errors; squares of lengths in the frame's unit. */
struct vor_distortion {
    double d1_mse, d2_mse; /**< of the worse direction; d2_mse is at most d1_mse */
    double peak;           /**< largest distance of a reference point to its nearest other one, a
                                length: dmetric's peak unless another is given */
};

/** Measures the distortion.
 *
 *  @param[out] out written only when VOR_OK is returned
 *  @retval VOR_E_DEGENERATE no point, or fewer than two distinct ones in the reference
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log m + m log n + m log m) time, on the run's pool; at most 70 bytes for each point. The
 *  same bits for any number of threads. */
VOR_NODISCARD vor_status vor_distortion_measure(struct vor_distortion *out,
                                                const struct vor_distortion_pair *pair,
                                                const struct vor_run *run, struct vor_error *err);

/** 10 log10(3 peak^2 / mse) in dB, higher is better; infinite where mse is 0. peak > 0. */
double vor_distortion_psnr(double mse, double peak);

#endif
