/** A common frame of two clouds, in which distances between them are computed in float32. */
#ifndef VOR_CLOUD_FRAME_H
#define VOR_CLOUD_FRAME_H

#include "core/cloud/cloud.h"

/** A position in the frame is (x - middle) / unit: middle is that of a box around both clouds, unit
 *  a power of two such that every |coordinate| <= 1. */
struct vor_frame {
    double middle[3];
    double unit; /**< 1 where all points coincide */
};

/** Chooses the frame of clouds with at least one point each; b may be NULL. Cannot fail. O(n). */
void vor_frame_choose(struct vor_frame *out, const struct vor_cloud *a, const struct vor_cloud *b);

/** Computes the positions of a cloud in a frame.
 *
 *  @param[out] out  cloud->n x 3 floats from `memory`; the caller frees them
 *
 *  @retval VOR_E_NOMEM
 *
 *  O(n). */
VOR_NODISCARD vor_status vor_frame_positions(float **out, const struct vor_cloud *cloud,
                                             const struct vor_frame *frame,
                                             struct vor_memory *memory, struct vor_error *err);

#endif
