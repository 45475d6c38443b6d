/** The tree of boxes itself, for the files that walk it: knn_boxes.c, which makes it,
 *  knn_near.c and knn_join.c.
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

/** As many floats, or what comparing them gives, and those that stand anywhere in arrays. */
typedef float vor_lanes __attribute__((vector_size(4 * VOR_BOXES_LANES)));
typedef int32_t vor_marks __attribute__((vector_size(4 * VOR_BOXES_LANES)));
typedef vor_lanes vor_lanes_at __attribute__((aligned(4), may_alias));
typedef vor_marks vor_marks_at __attribute__((aligned(4), may_alias));

/** What lies, along one axis, between each of what goes from low[j] to high[j] and what goes from
 *  box_low to box_high. */
VOR_INLINE void vor_boxes_gaps(vor_lanes *out, const float *low, const float *high, float box_low,
                               float box_high)
{
    vor_lanes below = *(const vor_lanes_at *)low - box_high;
    vor_lanes above = box_low - *(const vor_lanes_at *)high;

    /* both are above 0 only where they are infinite */
    *out = (vor_lanes)(((vor_marks)below & (below > 0)) | ((vor_marks)above & (above > 0)));
}

/** Squared distances from a box to VOR_BOXES_LANES others: from low to high, of which the next axis
 *  is `row` floats on. */
VOR_INLINE void vor_boxes_distances(float distance2[VOR_BOXES_LANES], const float *low,
                                    const float *high, size_t row, const float box_low[3],
                                    const float box_high[3])
{
    vor_lanes x, y, z;

    vor_boxes_gaps(&x, low, high, box_low[0], box_high[0]);
    vor_boxes_gaps(&y, low + row, high + row, box_low[1], box_high[1]);
    vor_boxes_gaps(&z, low + 2 * row, high + 2 * row, box_low[2], box_high[2]);
    *(vor_lanes_at *)distance2 = x * x + y * y + z * z;
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
