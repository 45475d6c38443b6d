/** A tree of boxes over points whose order is local, best Morton order. Behind knn.h only. */
#ifndef VOR_KNN_KNN_BOXES_H
#define VOR_KNN_KNN_BOXES_H

#include "core/base/run.h"

#include <stddef.h>
#include <stdint.h>

struct vor_boxes;

/** Builds a tree over n >= 1 points (n x 3 floats, all finite), which it borrows.
 *
 *  @retval VOR_E_NOMEM what stays (about 9 n bytes, at worst 37 n) and 8 n more do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n) in Morton order, O(n log n) in any other, on the run's pool. The same tree for any number
 *  of threads. */
VOR_NODISCARD vor_status vor_boxes_build(struct vor_boxes **out, const float *xyz, size_t n,
                                         const struct vor_run *run, struct vor_error *err);

/** Frees a tree; boxes may be NULL. */
void vor_boxes_free(struct vor_boxes *boxes);

/** The squared distance that bounds a search within a distance: wider by more than rounding in
 * float32 takes, and above 0, so that coincident points are within 0. */
static inline float vor_boxes_wider(float within)
{
    float wide = 1.0001F * within;

    return wide * wide + 1e-37F;
}

/** vor_knn_search for one query that has k points no farther than `within`: too small a distance
 *  costs time, not correctness. For what rounding makes of it some is added. INFINITY: any. */
void vor_boxes_search(const struct vor_boxes *boxes, const float query[3], unsigned k, float within,
                      uint32_t *index, float *distance2);

#endif
