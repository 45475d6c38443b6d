/** The tree of boxes itself, for the files that walk it: knn_boxes.c, which makes it, and
 *  knn_join.c.
 */
#ifndef VOR_KNN_TREE_H
#define VOR_KNN_TREE_H

#include "core/base/memory.h"

#include <stddef.h>
#include <stdint.h>

enum { VOR_BOXES_LANES = 8 };

/** Up to VOR_BOXES_LANES children, the used lanes first. The boxes of unused lanes are inside out,
 *  infinitely far from everything. */
struct vor_boxes_node {
    float low[3][VOR_BOXES_LANES], high[3][VOR_BOXES_LANES];
    uint32_t child[VOR_BOXES_LANES]; /* a node, or the first point of a leaf */
    uint32_t count[VOR_BOXES_LANES]; /* points of a leaf; 0: a node */
};

struct vor_boxes {
    struct vor_memory *memory;
    size_t n, nodes;
    struct vor_boxes_node *node; /* [0] is the root */
    float *leaf; /* n x 3: of each leaf all x, then all y, then all z; then VOR_BOXES_LANES zeros */
};

#endif
