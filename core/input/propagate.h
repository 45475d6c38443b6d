/** Signs of the normals of an input's points, spread along their graph.
 *
 *  Source: Huang 2009, after Hoppe 1992: along a minimum spanning tree. What mends the signs is
 *  told in input/orient.h.
 *
 *  Departure: signs are spread twice, each time with all that mends them. An edge carries over the
 *  normal mirrored at the plane midway between its ends: right on an arc, and across a crease
 *  sharper than 90 degrees where both ends are about as far from it. Then where the planes of both
 *  ends meet between them, the edge says whether each end is below the other's plane, or above it:
 *  right at any crease and any distance, but wrong where normals near a crease are those of
 *  neither face. A component takes these signs where winding numbers say that they close it
 *  better by a quarter, or, where it is open, that they differ less by as much between the ends of
 *  the edges that the two have on different sides.
 *
 *  Departure: where planes contradict any edge, faces are turned then by what one sees of the other
 *  (geom/hinge.h), in components that are open or close better so. */
#ifndef VOR_INPUT_PROPAGATE_H
#define VOR_INPUT_PROPAGATE_H

#include "core/geom/winding.h"
#include "core/input/back.h"

/* Rounds in which neighbours vote on single points; and in one more those beside a rim are fitted
 * as it is. At 0 / 3: of armadillo (30,000 points of white noise) 27 / 19 points are wrong. With
 * 3 / 4 of those of a rim, of a blade's 10,000 11 / 8. */
enum { VOR_VOTES = 3 };
/* Times the root of the number of points: more sure edges than that between different sides make a
 * surface one-sided, and more points where it bends back a rim. They cross a seam, which is as long
 * as the surface is wide. Measured: vor_orient's SURE; and the cow, whose tail touches its body,
 * has 1.1 to 2.0, which is no seam. */
#define VOR_SEAM 3.0
/* Share of votes, for less those against, beyond which they decide: of edges around a region, and
 * of carried normals in a component. Not measured for those: of one scan they agree (1), random
 * signs do not (0). */
#define VOR_AGREE 0.5

/** What signs are spread over. */
struct vor_propagation {
    struct vor_back back;             /**< the points, their graph and normals */
    struct vor_winding_points points; /**< the same, and what area each stands for */
    int vote;                         /**< lists are as long as fits ask: no noise beyond them */
    unsigned char *edge;              /**< n x most: of vor_span_make */
    unsigned char *planes; /**< n: 1 where an edge that the planes of its ends contradict is by
                                these */
    int rough_last;        /**< edges of points that are rough weigh more; `back` says nothing */
    struct vor_span span;  /**< the signs */
};

/** The byte of vor_span_make for an edge from point i to j, of any two. O(1). */
unsigned char vor_propagation_edge(const struct vor_propagation *propagation, size_t i, size_t j);

/** Spreads signs.
 *
 *  @param[in,out] propagation  `back.at` says where the surface may bend back; edge, planes and
 *                              span, all zero before, are to be freed with vor_propagation_free,
 *                              also on failure
 *
 *  @retval VOR_E_NOMEM 19 bytes a point and one for each edge do not fit, or what is called says so
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n), some microseconds a point, twice that where planes contradict an edge; on the run's
 *  pool. The same signs for any number of threads. */
VOR_NODISCARD vor_status vor_propagate(struct vor_propagation *propagation,
                                       const struct vor_run *run, struct vor_error *err);

void vor_propagation_free(struct vor_propagation *propagation, struct vor_memory *memory);

#endif
