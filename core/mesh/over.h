/** The triangles that may lie over an open edge, kept for the next time that it is looked at.
 *
 *  Whether a third point makes a triangle with an edge that is worth a try hangs on the points
 * alone and on the triangle that the edge has. What else there is changes while a front advances,
 * and that comes back to the same edges again and again: with other rules, and after triangles were
 *  taken away. So the best third points are kept, and of each what it was seen to have room beside.
 *
 *  Source: of what a triangle is worth, Cohen-Steiner and Da 2004, as in core/mesh/front.h. */
#ifndef VOR_MESH_OVER_H
#define VOR_MESH_OVER_H

#include "core/mesh/balls.h"

/** Mean of the cosines between the normals of a triangle and of the surface at its corners, at
 * least: of those that bridge two sheets it is about 0, over creases of 70 degrees .58. */
#define VOR_OVER_ALONG .25

enum { VOR_OVER_SLOTS = 4 };

/** A third point. */
struct vor_candidate {
    uint32_t point;
    float worth;                     /**< of its triangle: the greater the better */
    uint32_t seen : 31, crossed : 1; /**< triangle `seen` passes through it, or none before does */
};

/** Third points over the edge of a triangle. */
struct vor_over {
    uint32_t edge[3];                          /**< its corners, the third is off the edge */
    unsigned char around;                      /**< points that were looked at */
    unsigned char count, whole;                /**< how many are known, and whether these are all */
    struct vor_candidate best[VOR_OVER_SLOTS]; /**< the best first */
};

/** Those of edges that were looked at of late. */
struct vor_overs {
    struct vor_balls *balls;
    struct vor_over *slot; /**< `last` + 1, a power of two */
    size_t last;
};

/** Makes room to look at as many open edges again; forgets all where that needs more than there is.
 *
 *  @param[in,out] out  all zero at first; free with vor_overs_free, also on failure
 *
 *  @retval VOR_E_NOMEM 2 KB an edge do not fit, or 128 bytes a point where that is less
 *
 *  O(edges). */
VOR_NODISCARD vor_status vor_overs_make(struct vor_overs *out, struct vor_balls *balls,
                                        size_t edges, struct vor_error *err);

/** overs may be all zero. */
void vor_overs_free(struct vor_overs *overs);

/** The best third points of triangles (b, a, point) over the edge of the first two corners of
 *  a triangle (a, b, c), along the surface whatever its side: the first of them at least. They stay
 * until the next call. O(1). */
struct vor_over *vor_overs_look(struct vor_overs *overs, const uint32_t edge[3], unsigned around);

/** What is kept of the triangle (b, a, point) over that edge, or NULL. O(1). */
struct vor_candidate *vor_overs_find(const struct vor_overs *overs, const uint32_t edge[3],
                                     unsigned around, uint32_t point);

/** All third points over an edge, the best first; keeps the first of them. Returns how many there
 *  are. O(1). */
unsigned vor_overs_list(struct vor_overs *overs, struct vor_over *over,
                        struct vor_candidate out[VOR_BALLS_MANY]);

#endif
