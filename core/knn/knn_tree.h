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

/** A node, which has 1 to VOR_BOXES_LANES children. Up to VOR_BOXES_LANES floats may be read from
 *  any of its rows of so many. */
struct vor_boxes_node {
    unsigned lanes;
    float *low, *high;   /* of child j at [c * lanes + j] */
    uint32_t *child;     /* a node, or the first point of a leaf */
    unsigned char *kind; /* points of a leaf, or VOR_BOXES_LANES + lanes of a node */
};

/** Bytes of a child in its node, and of the units that nodes are counted in. */
enum { VOR_BOXES_LANE = 29, VOR_BOXES_UNIT = 32 };

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
    size_t n, units;
    unsigned char root; /* its kind; it is at 0 */
    unsigned char *node;
    const float *xyz;                    /* n x 3, borrowed */
    float tail[2 * 3 * VOR_BOXES_LANES]; /* the last VOR_BOXES_LANES points, then zeros */
};

VOR_INLINE struct vor_boxes_node vor_boxes_node_at(const struct vor_boxes *boxes, size_t at,
                                                   unsigned kind)
{
    unsigned lanes = kind - VOR_BOXES_LANES;
    float *low = (void *)(boxes->node + VOR_BOXES_UNIT * at);
    uint32_t *child = (void *)(low + 6 * (size_t)lanes);

    return (struct vor_boxes_node){lanes, low, low + 3 * (size_t)lanes, child,
                                   (void *)(child + lanes)};
}

/** The points from `at` on, of which VOR_BOXES_LANES may be read. */
VOR_INLINE const float *vor_boxes_leaf(const struct vor_boxes *boxes, size_t at)
{
    return at + VOR_BOXES_LANES <= boxes->n ? &boxes->xyz[3 * at]
                                            : &boxes->tail[3 * (at + VOR_BOXES_LANES - boxes->n)];
}

#endif
