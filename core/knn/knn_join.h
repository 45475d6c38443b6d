/** Parts of the points of a tree of boxes. Behind knn.h only. */
#ifndef VOR_KNN_JOIN_H
#define VOR_KNN_JOIN_H

#include "core/base/run.h"

#include <stddef.h>
#include <stdint.h>

struct vor_boxes;

/** vor_knn_join for a tree. */
VOR_NODISCARD vor_status vor_boxes_join(uint32_t *root, size_t *parts,
                                        const struct vor_boxes *boxes, double distance,
                                        const struct vor_run *run, struct vor_error *err);

#endif
