/** Signs for the points of a graph, such that as many edges as possible join those that they
 * should.
 *
 *  Source: Kruskal 1956, "On the shortest spanning subtree of a graph", with weights in levels in
 *  place of a sort. Departure: where an edge joins two trees it decides that they are joined, but
 *  all edges between them vote on the sign: a patch that hangs on one bad edge has good ones
 *  beside it. Measured, points on the wrong side, armadillo, 30,000 of white noise (three draws):
 *  with the vote 8, 14, 16, without 24, 13, 17. On open scans, with steps of depth, the vote does
 *  harm: of the depth scan office1 0.56 instead of 0.67 face alike. */
#ifndef VOR_GEOM_SPAN_H
#define VOR_GEOM_SPAN_H

#include "core/geom/graph.h"

/** What an edge is, in one byte: its weight, 0 .. VOR_SPAN_LEVELS - 1, and VOR_SPAN_TURNS added if
 *  its ends have different signs. */
enum { VOR_SPAN_LEVELS = 64, VOR_SPAN_TURNS = 128 };

/** Most patches that are remembered. Not measured at half and double. */
#define VOR_SPAN_JOINS 32

/** A tree when it was joined to a larger one. */
struct vor_span_join {
    uint32_t first; /**< its points are `count` of those from here on along `next` */
    uint32_t count;
    double support; /**< votes of the edges between both for its sign less those against it, over
                         all: 0 .. 1 */
};

/** The signs of n points. All zero: none. */
struct vor_span {
    struct vor_memory *memory;
    size_t n;
    size_t components;
    uint32_t *component; /**< n: numbers in the order of the components' first points */
    uint32_t *next;      /**< n: the points of a component, in a chain that keeps trees together */
    unsigned char *odd;  /**< n: 0 or 1, the sign */
    unsigned joins;
    struct vor_span_join
        join[VOR_SPAN_JOINS]; /**< the largest and least supported, in the order of joining */
};

/** The byte of an edge of a weight, 0 .. 1. */
static inline unsigned char vor_span_edge(double weight, int turns)
{
    double level = weight * VOR_SPAN_LEVELS;

    return (unsigned char)((level < VOR_SPAN_LEVELS - 1 ? level : VOR_SPAN_LEVELS - 1) +
                           (turns ? VOR_SPAN_TURNS : 0));
}

/** Votes of an edge: for its sign to be what it says if both signs are right, against it if not.
 * The heavier, the less. */
static inline double vor_span_vote(unsigned edge, unsigned differ)
{
    double vote = 1 - (edge % VOR_SPAN_TURNS + 0.5) / VOR_SPAN_LEVELS;

    return differ == edge / VOR_SPAN_TURNS ? vote : -vote;
}

/** Gives each component a spanning tree of least weight, and signs.
 *
 *  @param[out] out   free with vor_span_free; untouched on failure
 *  @param[in]  edge  n x most: edge[i most + a] is that to the a-th neighbour of point i
 *  @param[in]  vote  whether all edges between two trees vote, or the lightest one decides
 *
 *  @retval VOR_E_NOMEM 25 bytes a point do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n most (log n + VOR_SPAN_LEVELS)), most of it comparisons of bytes; measured 1.3 us a point
 *  with 20 neighbours, on one thread. The same signs for any number of threads. */
VOR_NODISCARD vor_status vor_span_make(struct vor_span *out, const struct vor_graph *graph,
                                       const unsigned char *edge, int vote,
                                       const struct vor_run *run, struct vor_error *err);

/** span may be all zero. */
void vor_span_free(struct vor_span *span);

#endif
