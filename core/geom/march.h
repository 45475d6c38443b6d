/** Distances along a surface that is known by points and their neighbours, by fast marching.
 *
 *  Source: Kimmel and Sethian 1998, "Computing geodesic paths on manifolds", over lists of
 *  neighbours in place of triangles, as Lv et al. 2022, "Intrinsic and isotropic resampling for 3D
 *  point clouds", Sec. 3.2.
 *  Departure: a point is reached over any pair of its neighbours that are done, not over triangles
 *  alone. */
#ifndef VOR_GEOM_MARCH_H
#define VOR_GEOM_MARCH_H

#include "core/base/heap.h"
#include "core/geom/graph.h"

/** A graph, and the front of a march over it. */
struct vor_march {
    const struct vor_graph *graph; /**< borrowed */
    const float *xyz;              /**< n x 3; borrowed */
    struct vor_heap front;         /**< points that were reached, but not gone on from */
    float *far;                    /**< of the march that goes on; borrowed */
};

/** Makes ready to march over a graph of which each point is in the lists of those in its own
 *  (vor_graph_keep_mutual).
 *
 *  @param[out] out         free with vor_march_free; untouched on failure
 *  @param[in]  graph, xyz  must stay as they are while *out lives; xyz is n x 3
 *
 *  @retval VOR_E_NOMEM 8 bytes a point do not fit
 *
 *  O(1). */
VOR_NODISCARD vor_status vor_march_init(struct vor_march *out, const struct vor_graph *graph,
                                        const float *xyz, struct vor_error *err);

/** march may be all zero. */
void vor_march_free(struct vor_march *march);

/** Computes the distance along the surface from the nearest of some points to every point.
 *
 *  @param[out] far     n: in the unit of xyz; INFINITY where no chain of edges leads
 *  @param[in]  source  `sources` indices
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  Over lists of 20 among 20,000 points of white noise, on square, sphere, cylinder and fold beyond
 *  ten spacings: off by 0.3 % to 0.5 % in the mean, from 1.3 % too short to 9.6 % too long. O(n log
 *  n + n most^2), one thread. The same distances for any number of threads. */
VOR_NODISCARD vor_status vor_march_from(struct vor_march *march, float *far, const uint32_t *source,
                                        size_t sources, const struct vor_run *run,
                                        struct vor_error *err);

#endif
