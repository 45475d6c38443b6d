/** A frame that holds two clouds alike, so that distances between them can be taken in float32. */
#ifndef VOR_CLOUD_FRAME_H
#define VOR_CLOUD_FRAME_H

#include "core/cloud/cloud.h"

/** Middle of a box around both clouds, and a power of two at least as large as both to each side of
 *  it: a position in the frame is (x - middle) / unit, and every |coordinate| <= 1. */
struct vor_frame {
    double middle[3];
    double unit; /**< 1 where all points coincide */
};

/** Clouds have at least one point; b may be NULL. O(n). */
void vor_frame_choose(struct vor_frame *out, const struct vor_cloud *a, const struct vor_cloud *b);

/** The positions of a cloud in a frame: cloud->n x 3 floats from `memory`, the caller frees them.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_frame_positions(float **out, const struct vor_cloud *cloud,
                                             const struct vor_frame *frame,
                                             struct vor_memory *memory, struct vor_error *err);

#endif
