/** A bounded walk: which of the points around one can be reached along its surface.
 *
 *  Source: none of the papers; Lv et al. 2022, "Intrinsic and Isotropic Resampling for 3D Point
 *  Clouds", Sec. 4.1, asks of neighbours that they are near along the surface too. */
#ifndef VOR_GEOM_WALK_H
#define VOR_GEOM_WALK_H

#include "core/geom/surface.h"

/** Most points of a walk: three times those of a list, so that one of three sheets has enough. */
enum { VOR_WALK_MOST = 3 * VOR_NEIGHBORS_FEWEST };
_Static_assert(VOR_WALK_MOST < 64, "points are bits of a word");

/** A walk from the first of `most` points, the others its nearest in order. */
struct vor_walk {
    unsigned most;                  /**< 1 .. VOR_WALK_MOST */
    double arc;                     /**< largest sine of an edge over the surface between the
                                         normals at its ends */
    uint32_t index[VOR_WALK_MOST];  /**< the caller's */
    float distance2[VOR_WALK_MOST]; /**< squared, from the first */
    float x[3][VOR_WALK_MOST];      /**< positions */
    float normal[3][VOR_WALK_MOST]; /**< unit length */
    int is_signed;                  /**< normals face outward; else they are of any sign */
    unsigned enough;                /**< the walk ends when the first so many that can be reached,
                                         in the order of the points, are known */
    double far[VOR_WALK_MOST];      /**< set by the walk: length of the way; infinite without */
    unsigned char reached[VOR_WALK_MOST]; /**< set by the walk: 1 where the way is at most 1.5 times
                                               the straight distance */
    double limit[VOR_WALK_MOST];          /**< scratch of the walk */
};

/** Squared distances of all its points from point `of` of them. Returns a bit for each that is at
 *  most so far, but not for `of`. O(most). */
uint64_t vor_walk_near(const struct vor_walk *walk, unsigned of, double within2,
                       double d2[VOR_WALK_MOST]);

/** The first of some points, of which there is one: the number of the lowest bit. */
static inline unsigned vor_walk_first(uint64_t points)
{
    return (unsigned)__builtin_ctzll(points);
}

/** Finds the shortest ways (Dijkstra 1959) along edges that stay on the surface: at most 2.2
 *  spacings of the points long, between normals that agree, no steeper over the surface than arc.
 *  Sets far and reached. Cannot fail; O(most^2); depends on nothing but the walk. */
void vor_walk_go(struct vor_walk *walk);

#endif
