#include "core/knn/knn_join.h"

#include "core/base/union.h"
#include "core/knn/knn_tree.h"

#include <string.h>

/* Distances that a box is wide at most whose points are taken as one part without a look. Measured,
 * CPU of 5 million points, at a distance of twice the 99.9 % quantile of those to a sixth
 * neighbour: at 1 / 2 / 4 / 8 150 / 72 / 35 / 18 ms, looking at all pairs of points 210 to 260 ms.
 */
#define WIDTH 4.0

#define NONE UINT32_MAX

/* Points being joined. root[i] <= i leads to the smallest index of the part so far; NONE for the
 * points of a narrow box but the first. */
struct join {
    const struct vor_boxes *boxes;
    uint32_t *root;
    unsigned char *whole; /* for each lane of each node: 1 if it is known to be one part */
    float distance2, width2;
};

/* One lane of a node: the points in its box. */
struct part {
    struct vor_boxes_node in;
    unsigned lane;
    uint32_t count; /* points of a leaf; 0: a node */
    int narrow;     /* the box is no wider than the width */
    int whole;      /* its points are known to be one part */
    uint32_t from;  /* the first point of the narrow box that it was taken out of, or NONE */
};

static unsigned char *whole_of(const struct join *join, const struct vor_boxes_node *in,
                               unsigned lane)
{
    size_t byte = (size_t)((const unsigned char *)in->low - join->boxes->node);

    return &join->whole[byte / VOR_BOXES_LANE + lane];
}

static struct part part_of(const struct join *join, const struct vor_boxes_node *in, unsigned lane)
{
    float width2 = 0;
    int narrow;

    for (size_t c = 0; c < 3; c++) {
        float side = in->high[c * in->lanes + lane] - in->low[c * in->lanes + lane];

        width2 += side * side;
    }
    narrow = width2 <= join->width2;
    return (struct part){*in,
                         lane,
                         in->kind[lane] <= VOR_BOXES_LANES ? in->kind[lane] : 0,
                         narrow,
                         narrow || *whole_of(join, in, lane),
                         NONE};
}

static struct vor_boxes_node node_below(const struct join *join, struct part part)
{
    return vor_boxes_node_at(join->boxes, part.in.child[part.lane], part.in.kind[part.lane]);
}

static uint32_t first_point(const struct join *join, struct part part)
{
    struct vor_boxes_node in = part.in;
    unsigned lane = part.lane;

    if (part.from != NONE)
        return part.from;
    while (in.kind[lane] > VOR_BOXES_LANES) {
        in = vor_boxes_node_at(join->boxes, in.child[lane], in.kind[lane]);
        lane = 0;
    }
    return in.child[lane];
}

static int boxes_near(const struct join *join, struct part a, struct part b)
{
    float gap2 = 0;

    for (size_t c = 0; c < 3; c++) {
        float below = a.in.low[c * a.in.lanes + a.lane] - b.in.high[c * b.in.lanes + b.lane];
        float above = b.in.low[c * b.in.lanes + b.lane] - a.in.high[c * a.in.lanes + a.lane];
        float gap = below > above ? below : above;

        gap2 += gap > 0 ? gap * gap : 0;
    }
    return gap2 <= join->distance2;
}

/* Whether point i of leaf a is no farther than the distance from point j of leaf b. */
static int points_near(const struct join *join, struct part a, uint32_t i, struct part b,
                       uint32_t j)
{
    const float *p = &join->boxes->xyz[3 * ((size_t)a.in.child[a.lane] + i)];
    const float *q = &join->boxes->xyz[3 * ((size_t)b.in.child[b.lane] + j)];
    float distance2 = 0;

    for (size_t c = 0; c < 3; c++)
        distance2 += (p[c] - q[c]) * (p[c] - q[c]);
    return distance2 <= join->distance2;
}

static int same_part(const struct join *join, struct part a, struct part b)
{
    return a.whole && b.whole &&
           vor_union_root(join->root, first_point(join, a)) ==
               vor_union_root(join->root, first_point(join, b));
}

/* Joins points of two disjoint boxes that are near each other. */
static void join_across(const struct join *join, struct part a, struct part b)
{
    struct part open = a, other = b;
    struct vor_boxes_node below;

    if (same_part(join, a, b))
        return;
    if (a.narrow && b.narrow) {
        vor_union_join(join->root, first_point(join, a), first_point(join, b));
        return;
    }
    if (a.count > 0 && b.count > 0) {
        uint32_t first_a = first_point(join, a), first_b = first_point(join, b);

        for (uint32_t i = 0; i < a.count; i++)
            for (uint32_t j = 0; j < b.count; j++)
                if (points_near(join, a, i, b, j))
                    vor_union_join(join->root, first_a + (a.narrow ? 0 : i),
                                   first_b + (b.narrow ? 0 : j));
        return;
    }
    if (a.count > 0 || (b.count == 0 && a.narrow)) {
        open = b;
        other = a;
    }
    below = node_below(join, open);
    for (unsigned j = 0; j < below.lanes && !same_part(join, a, b); j++) {
        struct part child = part_of(join, &below, j);

        if (open.narrow)
            child.from = first_point(join, open);
        if (boxes_near(join, child, other))
            join_across(join, child, other);
    }
}

/* Joins the points of a leaf. Returns whether they are one part. */
static int join_leaf(const struct join *join, struct part part)
{
    uint32_t first = part.in.child[part.lane], i;

    for (i = 0; i < part.count; i++) {
        join->root[first + i] = first + i;
        for (uint32_t j = 0; j < i; j++)
            if (points_near(join, part, i, part, j))
                vor_union_join(join->root, first + i, first + j);
    }
    for (i = 0; i < part.count && vor_union_root(join->root, first + i) == first; i++)
        ;
    return i == part.count;
}

/* Joins the children of a node, in which points are joined already. Returns whether the node is now
 * one part. */
static int join_children(const struct join *join, const struct vor_boxes_node *node)
{
    unsigned count = node->lanes;
    struct part part[VOR_BOXES_LANES];
    int whole = 1;

    for (unsigned j = 0; j < count; j++) {
        part[j] = part_of(join, node, j);
        for (unsigned i = 0; i < j; i++)
            if (boxes_near(join, part[i], part[j]))
                join_across(join, part[i], part[j]);
    }
    for (unsigned j = 0; j < count; j++)
        whole = whole && same_part(join, part[0], part[j]);
    return whole;
}

/* Joins the points of a box with each other. */
static void join_inside(const struct join *join, const struct vor_boxes_node *in, unsigned lane)
{
    struct part part = part_of(join, in, lane);
    int whole = 1;

    if (part.narrow) {
        uint32_t first = first_point(join, part);

        join->root[first] = first;
    } else if (part.count > 0) {
        whole = join_leaf(join, part);
    } else {
        struct vor_boxes_node node = node_below(join, part);

        for (unsigned j = 0; j < node.lanes; j++)
            join_inside(join, &node, j);
        whole = join_children(join, &node);
    }
    *whole_of(join, in, lane) = (unsigned char)whole;
}

static void join_lanes(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct join *join = ctx;
    struct vor_boxes_node top = vor_boxes_node_at(join->boxes, 0, join->boxes->root);

    for (size_t j = begin; j < end; j++)
        join_inside(join, &top, (unsigned)j);
}

/* Sets the root of each point; those of smaller indices are final. Returns how many parts there
 * are. */
static size_t finish_roots(uint32_t *root, size_t n)
{
    size_t parts = 0;

    for (size_t i = 0; i < n; i++) {
        root[i] = root[i] == NONE ? root[i - 1] : root[root[i]];
        parts += root[i] == i;
    }
    return parts;
}

vor_status vor_boxes_join(uint32_t *root, size_t *parts, const struct vor_boxes *boxes,
                          double distance, const struct vor_run *run, struct vor_error *err)
{
    struct vor_boxes_node top = vor_boxes_node_at(boxes, 0, boxes->root);
    struct join join = {.boxes = boxes,
                        .root = root,
                        .distance2 = (float)(distance * distance),
                        .width2 = (float)(WIDTH * WIDTH * distance * distance)};
    vor_status status;

    join.whole = vor_calloc(run->memory,
                            boxes->units * VOR_BOXES_UNIT / VOR_BOXES_LANE + VOR_BOXES_LANES, 1);
    if (join.whole == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", boxes->n);
    memset(root, 0xff, boxes->n * sizeof *root);
    status = vor_run_for(run, top.lanes, 1, join_lanes, &join, err);
    if (status == VOR_OK)
        *parts = join_children(&join, &top) ? 1 : finish_roots(root, boxes->n);
    vor_free(run->memory, join.whole);
    return status;
}
