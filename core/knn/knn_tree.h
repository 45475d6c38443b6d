/** The tree of boxes itself, for the files that walk it: knn_boxes.c, which makes it, and
 *  knn_join.c.
 */
#ifndef VOR_KNN_TREE_H
#define VOR_KNN_TREE_H

#include "core/base/memory.h"
#include "core/base/vector.h"

#include <math.h>
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

/** Adds, along one axis, to squared distances what lies between each of what goes from low[j] to
 *  high[j] and what goes from box_low to box_high. As the sum of two halves, one of which is 0: a
 *  maximum would be a branch, which keeps the loop from becoming vectors. */
VOR_INLINE void vor_boxes_add_gaps(float distance2[VOR_BOXES_LANES], const float *low,
                                   const float *high, float box_low, float box_high)
{
    for (size_t j = 0; j < VOR_BOXES_LANES; j++) {
        float below = low[j] - box_high, above = box_low - high[j];
        float gap = 0.5f * (below + fabsf(below)) + 0.5f * (above + fabsf(above));

        distance2[j] += gap * gap;
    }
}

struct vor_boxes {
    struct vor_memory *memory;
    size_t n, nodes;
    struct vor_boxes_node *node;         /* [0] is the root */
    const float *xyz;                    /* n x 3, borrowed */
    float tail[2 * 3 * VOR_BOXES_LANES]; /* the last VOR_BOXES_LANES points, then zeros */
};

/** The points from `at` on, of which VOR_BOXES_LANES may be read. */
VOR_INLINE const float *vor_boxes_leaf(const struct vor_boxes *boxes, size_t at)
{
    return at + VOR_BOXES_LANES <= boxes->n ? &boxes->xyz[3 * at]
                                            : &boxes->tail[3 * (at + VOR_BOXES_LANES - boxes->n)];
}

#endif
