/** An index of oriented points that takes points one by one: an octree over the cube [-1, 1]^3,
 *  whose leaves split where they are full. It follows the density of the points however uneven that
 *  becomes, and answers are those of the points, not of the order of their nodes.
 *
 *  Positions and normals are copied into the leaves by lanes, so that a question reads memory
 *  in order. About 120 bytes a point. */
#ifndef VOR_LOP_TREE_H
#define VOR_LOP_TREE_H

#include "core/base/run.h"
#include "core/geom/surface.h"
#include "core/lop/samples.h"

#include <stddef.h>
#include <stdint.h>

enum {
    /** Points of a leaf. With 4 / 8 / 16, 22,000 points to 300,000 take 17 / 16 / 13 us each (on a
     *  busy machine). */
    VOR_LOP_LANES = 16,
    /** Most points that vor_lop_tree_gather hands out; further ones are left out. */
    VOR_LOP_GATHERED_MAX = 256,
    /** Points that are indexed, some 0.5 us each, from one look at the watch to the next. */
    VOR_LOP_POLL_EVERY = 4096
};

struct vor_lop_leaf;

/** The index; owns everything. */
struct vor_lop_tree {
    struct vor_memory *memory;
    uint32_t *node; /* eight of each split cell: a leaf, or the first of its eight */
    size_t nodes, room_nodes;
    struct vor_lop_leaf *leaf;
    size_t leaves, room_leaves;
};

/** Points around a place, in no order. */
struct vor_lop_gathered {
    unsigned count;
    uint32_t index[VOR_LOP_GATHERED_MAX];
    float xyz[3][VOR_LOP_GATHERED_MAX], normal[3][VOR_LOP_GATHERED_MAX];
    float distance2[VOR_LOP_GATHERED_MAX]; /**< from the place */
};

/** @param[out] out  free with vor_lop_tree_free, whatever is returned
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_lop_tree_init(struct vor_lop_tree *out, struct vor_memory *memory,
                                           struct vor_error *err);

/** Frees the index; tree may be all zero. */
void vor_lop_tree_free(struct vor_lop_tree *tree);

/** Adds point `index` at xyz with a unit normal. Coordinates beyond 1 are taken as 1 to find the
 *  leaf, which only makes questions there slower.
 *
 *  @retval VOR_E_NOMEM  the index is as it was
 *
 *  O(log n). */
VOR_NODISCARD vor_status vor_lop_tree_add(struct vor_lop_tree *tree, uint32_t index,
                                          const float xyz[3], const float normal[3],
                                          struct vor_error *err);

/** Indexes all samples as they are now: point i is sample i.
 *
 *  @param[out] out  free with vor_lop_tree_free, whatever is returned
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  the watch is asked every VOR_LOP_POLL_EVERY points
 *
 *  O(n log n). */
VOR_NODISCARD vor_status vor_lop_tree_build(struct vor_lop_tree *out,
                                            const struct vor_lop_samples *samples,
                                            const struct vor_run *run, struct vor_error *err);

/** Finds the points within `radius` of x. Thread-safe beside other questions. */
void vor_lop_tree_gather(struct vor_lop_gathered *out, const struct vor_lop_tree *tree,
                         const float x[3], double radius);

/** A place whose clearance is asked for. */
struct vor_lop_base {
    float xyz[3];
    double radius2;      /**< points farther away than its root do not count */
    const float *end[2]; /**< normals of the two points that it lies between */
};

/** The square of the orthogonal clearance of a base: the smallest distance to the line through any
 *  point along its normal. Points that face away from both ends do not count: they lie on another
 *  sheet. At most `most`.
 *
 *  Source: Huang et al. 2013, Sec. 5, D(b, s). Thread-safe beside other questions. */
double vor_lop_tree_clearance2(const struct vor_lop_tree *tree, const struct vor_lop_base *base,
                               double most);

/** The same among points gathered. */
double vor_lop_gathered_clearance2(const struct vor_lop_gathered *gathered,
                                   const struct vor_lop_base *base, double most);

#endif
