/** Lists of neighbours of a made surface, beside the ways along it. */
#ifndef VT_LISTS_H
#define VT_LISTS_H

#include "core/input/domain.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

/** A cloud of a surface, ready for lists to be made into graph. */
struct vt_lists {
    struct vt_engine engine;
    const struct vt_metric *metric;
    double gap;
    struct vor_cloud cloud;
    struct vor_domain domain;
    struct vor_graph graph;
};

/** n points of vt_metrics[shape], on an engine of that many threads; end with vt_lists_end. */
void vt_lists_start(struct vt_lists *lists, unsigned threads, int shape, int seed, size_t n,
                    double gap);

/** The same of two wavy sheets .4 spacings apart, so many waves to a side, and lists made of them:
 *  the points of a sheet have odd numbers, those of the other even ones. */
void vt_lists_start_waves(struct vt_lists *lists, unsigned threads, int seed, size_t n,
                          double waves);

/** Pairs of a point and one of its list that lie on two of those sheets. */
size_t vt_lists_astray(const struct vt_lists *lists);

/** Frees all, also the graph, and asserts that nothing is left. */
void vt_lists_end(struct vt_lists *lists);

/** Pairs of neighbours between which the way along the surface is more than twice the straight one.
 *  Round an edge of a plate or along a fold's bend it is at most 1.6 times that. */
size_t vt_lists_across(const struct vt_lists *lists);

/** How far the way along the lists from a point of the seed's to all others is off the one along
 *  the surface, in shares of that. */
struct vt_way {
    double mean, worst; /**< those nearer than ten spacings are not among them */
};

struct vt_way vt_lists_way(const struct vt_lists *lists, int seed);

/** Hash of lists and normals. */
uint64_t vt_lists_hash(const struct vor_graph *graph);

#endif
