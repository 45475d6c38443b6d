/** Even samples of two clouds, with oriented normals, for their registration.
 *
 *  Source: Lv et al. 2022, "Intrinsic and isotropic resampling for 3D point clouds", Sec. 5: clouds
 *  are resampled to equal numbers of even density before they are aligned. Departure: samples are
 *  the means of the points in cubes, which costs 1 us a point and takes noise off; both clouds have
 *  the same cubes where the scale is known. */
#ifndef VOR_ALIGN_SAMPLES_H
#define VOR_ALIGN_SAMPLES_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/knn/knn.h"

/** Samples of a cloud: they stand for its points at middle + unit * xyz. Owns its arrays. */
struct vor_align_samples {
    struct vor_memory *memory;
    size_t n;
    float *xyz, *normal; /**< n x 3; of length 1 */
    size_t few;          /**< of them a few, far from each other */
    uint32_t *chosen;    /**< few */
    struct vor_knn *knn; /**< over xyz */
    double middle[3];    /**< in the cloud's coordinates */
    double unit;         /**< rms distance of the samples from their centroid; where the scale is
                              fixed, the larger one of both clouds */
    double gap, apart;   /**< distance between neighbours, of all and of the few; normalised */
    int carried;         /**< normals are those of the cloud */
};

/** Fewest points of a cloud, and largest ratio of the diagonals of two. */
#define VOR_ALIGN_POINTS_MIN 100
#define VOR_ALIGN_RATIO_MAX 1e6

/** Samples cloud and reference, in this order.
 *
 *  @param[out] out   both free with vor_align_samples_free, also on failure
 *  @param[in]  fixed the scale is known: cubes and unit are the same
 *
 *  @retval VOR_E_DEGENERATE  a cloud has fewer points, one place or all on a line, or the diagonals
 *                            have a larger ratio
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  O(n) and O(1) for the samples, of which there are at most some ten thousand. The same bits for
 *  any number of threads. */
VOR_NODISCARD vor_status vor_align_samples_make(struct vor_align_samples out[2],
                                                const struct vor_cloud *const cloud[2], int fixed,
                                                const struct vor_run *run, struct vor_error *err);

/** samples may be all zero. */
void vor_align_samples_free(struct vor_align_samples *samples);

#endif
