/** A graph over points: for each, the neighbours that lie on its sheet, and a normal.
 *
 *  Plain arrays; who makes them says what an edge means (input/adjacency.h). */
#ifndef VOR_GEOM_GRAPH_H
#define VOR_GEOM_GRAPH_H

#include "core/base/run.h"
#include "core/geom/surface.h"
#include "core/knn/knn.h"

#include <stdint.h>

/** The lists of n points. All zero: no graph. */
struct vor_graph {
    struct vor_memory *memory;
    size_t n;
    unsigned most;        /**< most neighbours of a point */
    uint32_t *list;       /**< n x most: neighbours of each point, the nearest first */
    unsigned char *count; /**< n: how many it has */
    unsigned char *own;   /**< n: 1 where fits are made to the list, not to the nearest points */
    float *normal;        /**< n x 3, unit length */
    struct vor_surface *surface; /**< n: vor_surface_fit to each point and the first of its
                                      list, VOR_ADJACENT in all; or NULL */
};

/** Makes n points with no neighbours and normals of zero; most is 1 .. 255.
 *
 *  @param[out] out  free with vor_graph_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM (4 most + 14) n bytes do not fit */
VOR_NODISCARD vor_status vor_graph_init(struct vor_graph *out, size_t n, unsigned most,
                                        struct vor_memory *memory, struct vor_error *err);

/** graph may be all zero. */
void vor_graph_free(struct vor_graph *graph);

/** True when there is a graph. */
static inline int vor_graph_is(const struct vor_graph *graph)
{
    return graph->list != NULL;
}

/** True when its lists came with normals, as those of input/adjacency.h do. */
static inline int vor_graph_has_normals(const struct vor_graph *graph)
{
    const float *first = graph->normal;

    return vor_graph_is(graph) && (first[0] != 0 || first[1] != 0 || first[2] != 0);
}

/** Makes the list of each point of the points nearest to it, at most k; own and normal stay as they
 *  are.
 *
 *  @param[in,out] graph  of the points that knn is over
 *  @param[in]     xyz    n x 3
 *  @param[in]     k      1 .. graph->most, less than n
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n k log n), on the run's pool. The same lists for any number of threads. */
VOR_NODISCARD vor_status vor_graph_nearest(struct vor_graph *graph, const struct vor_knn *knn,
                                           const float *xyz, unsigned k, const struct vor_run *run,
                                           struct vor_error *err);

/** Drops the entries of lists that are one-sided: j stays in the list of i if i is in that of j.
 *
 *  @param[in,out] graph  most is at most 32
 *
 *  @retval VOR_E_NOMEM 4 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; some lists are done
 *
 *  O(n most^2), on the run's pool. The same lists for any number of threads. */
VOR_NODISCARD vor_status vor_graph_keep_mutual(struct vor_graph *graph, const struct vor_run *run,
                                               struct vor_error *err);

/** True when j is in the list of i. O(most). */
int vor_graph_has(const struct vor_graph *graph, uint32_t i, uint32_t j);

/** True when one of two points is in the list of the other. O(most). */
int vor_graph_joins(const struct vor_graph *graph, uint32_t i, uint32_t j);

/** True when lists lead from a point to another over two others at most, as around a rim. Those of
 *  the latter are not searched for points that list it, but for the last step. O(most^3). */
int vor_graph_leads(const struct vor_graph *graph, uint32_t from, uint32_t to);

/** Points around one, in rings: itself, those of its list, those of theirs that are new, and so on,
 *  until there are enough.
 *
 *  @param[out] out  wanted: the points that were found, i first
 *  @param[in] wanted  1 .. VOR_GRAPH_AROUND
 *
 *  @return how many were found: fewer if no more can be reached
 *
 *  O(wanted most). Cannot fail. Depends on nothing but its arguments. */
unsigned vor_graph_around(const struct vor_graph *graph, uint32_t i, uint32_t *out,
                          unsigned wanted);

/** Most points that vor_graph_around finds. */
#define VOR_GRAPH_AROUND VOR_NEIGHBORS_MAX

/** Connected components: two points are in one component if a chain of edges, taken in either
 *  direction, joins them.
 *
 *  @param[out] component  n: 0 .. *count - 1, numbered in the order of their first points
 *  @param[out] count      how many there are
 *
 *  @retval VOR_E_NOMEM 4 n bytes do not fit
 *
 *  O(n most), one thread. */
VOR_NODISCARD vor_status vor_graph_components(uint32_t *component, size_t *count,
                                              const struct vor_graph *graph, struct vor_error *err);

#endif
