/** The best way to cut a loop of a mesh into triangles.
 *
 *  Source: Klincsek 1980, "Minimal triangulations of polygonal domains". */
#ifndef VOR_MESH_CUT_H
#define VOR_MESH_CUT_H

#include "core/mesh/balls.h"
#include "core/mesh/complex.h"
#include "core/mesh/rims.h"

/** Most edges of a loop that is cut. On closed shapes they have 4 to 12, at tips up to 20. */
enum { VOR_CUT_MOST = 48 };

/** A loop, and the best ways to cut parts of it into triangles: cost[a][b] of the part from point a
 *  to b, which begins with the triangle (a, by[a][b], b). */
struct vor_cut {
    const struct vor_complex *complex;
    const struct vor_balls *balls; /**< of the points, where they are */
    const uint32_t *loop;
    unsigned count;
    const signed char *side; /**< n: so many times its normal triangles face at a point, 0: not
                                  known; NULL: of none */
    int blind;               /**< triangles may pass through those that there are */
    double cost[VOR_CUT_MOST][VOR_CUT_MOST];
    unsigned char by[VOR_CUT_MOST][VOR_CUT_MOST];
    unsigned taken; /**< triangles that were found */
    uint32_t triangle[VOR_CUT_MOST][3];
};

/** Takes loop l of those there are. One of more edges than VOR_CUT_MOST is not cut. */
void vor_cut_set_loop(struct vor_cut *cut, const struct vor_rims *rims, size_t l);

/** Finds the triangles that are best together, over all ways to cut the loop. Returns 0 where
 *  none closes it over points of the input, on one sheet, without passing through another.
 *  O(edges^3). */
int vor_cut_find(struct vor_cut *cut);

/** What a triangle costs: the worse and the more upright on the tangent planes of its corners, the
 *  more. */
double vor_cut_cost(const struct vor_cut *cut, const uint32_t corner[3]);

#endif
