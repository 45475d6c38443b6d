/** A flat cell: a convex polygon in a plane, whose sides know who cut them.
 *
 *  It begins as a regular patch (geom/patch.h) around the origin and is cut by lines, of which each
 *  has a number: mostly that of a seed, whose bisector with the cell's own meets the plane there.
 *  Clipping is that of Sutherland and Hodgman 1974. */
#ifndef VOR_GEOM_FLAT_H
#define VOR_GEOM_FLAT_H

#include "core/geom/cell.h"

#include <stdint.h>

/** Number of the first side of the patch; the others follow. Greater than that of any seed. */
#define VOR_FLAT_SIDE (UINT32_MAX - 15)

/** The cell; edge e leads from corner e to the next one, counter-clockwise. */
struct vor_flat {
    unsigned count;
    double x[VOR_POLYGON_MAX], y[VOR_POLYGON_MAX];
    double far2;                  /**< squared distance from the origin to the farthest corner */
    uint32_t id[VOR_POLYGON_MAX]; /**< who cut each edge, or VOR_FLAT_SIDE and following */
};

/** Begins a cell as the patch of these corners, `radius` times as large. O(sides). */
void vor_flat_begin(struct vor_flat *cell, const double (*corner)[2], unsigned sides,
                    double radius);

/** Keeps the part where x d[0] + y d[1] <= limit. Does nothing where `id` has cut it before:
 *  rounding must not cut twice. May leave no corner. O(corners). */
void vor_flat_clip(struct vor_flat *cell, const double d[2], double limit, uint32_t id);

#endif
