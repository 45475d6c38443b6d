/** Two sides of a surface that meet in an edge or in a fillet: planes that may bend along it, and
 * the radius that rounds off what lies between them, fitted to points.
 *
 *  Source: none of the papers; the surface is the usual one of a rounded wedge, all points at the
 *  distance r from the wedge that lies r below both sides. At radius 0 it is the edge itself, so
 * that how much less the best radius leaves than none says whether the points lie on a fillet. */
#ifndef VOR_GEOM_FILLET_H
#define VOR_GEOM_FILLET_H

#include "core/geom/surface.h"

/** Parameters of a side, which are height, slope, slope and bend along, and of all: the radius too.
 */
enum { VOR_FILLET_SIDE_TERMS = 4, VOR_FILLET_TERMS = 2 * VOR_FILLET_SIDE_TERMS + 1 };

/** Fewest points that one is fitted to. */
#define VOR_FILLET_MIN (2 * VOR_FILLET_TERMS)

/** A rounded wedge. Lengths are in the unit of the points. */
struct vor_fillet {
    double origin[3], axis[3][3]; /**< rows: along the edge, across it, and up, outwards */
    double side[2][2];            /**< unit normals of both sides, across and up */
    double height[2][3];          /**< of the origin over each side: h0 + h1 v + h2 v^2, v along */
    double cosine;                /**< between the normals of the sides */
    double radius;                /**< >= 0 */
    double off2;                  /**< mean square of the points' heights over it */
    double gain; /**< by how much the sum of these squares is less with the best radius than with
                      none, on the sides as given, in off2; 0: the best is none, and the sides are
                      those */
};

/** Fits one.
 *
 *  @param[in] near    k x 3 floats
 *  @param[in] k       VOR_FILLET_MIN .. VOR_NEIGHBORS_MAX
 *  @param[in] place   points on both sides, about
 *  @param[in] normal  unit normals of both, not parallel; the solid is on the other side of both
 *  @param[in] reach   > 0: of the points around the edge
 *
 *  Cannot fail. O(k). Depends on nothing but its arguments. */
void vor_fillet_fit(struct vor_fillet *out, const float *near, unsigned k, double place[2][3],
                    double normal[2][3], double reach);

/** The height of x over the surface and the surface's normal there. Returns whether that lies on
 *  the round part. O(1). */
int vor_fillet_at(const struct vor_fillet *fillet, const double x[3], double *height,
                  double normal[3]);

#endif
