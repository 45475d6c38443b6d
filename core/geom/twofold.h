/** Two sheets that look alike, over one plane: which of n points lie on which of them.
 *
 *  Both are w = q(u, v) + s h(u, v) with s = 1 and -1, q a cubic and h a quadratic. What the sheets
 *  have in common, their bends, is known from all of the points, and what parts them is smooth; so
 *  they are told apart nearer to each other than two surfaces of their own would be, and on both
 *  sides of where they cross. Over one sheet alone h is as large as the noise.
 *
 *  Source: none of the papers; sides and surfaces in turn, as Lloyd's algorithm does for places and
 *  means. */
#ifndef VOR_GEOM_TWOFOLD_H
#define VOR_GEOM_TWOFOLD_H

#include "core/geom/surface.h"

/** Points that fits to both sheets of an input take: its labels (input/votes.h), and where they
 *  meet (mesh/meeting.h). */
enum { VOR_TWOFOLD_USUAL = 62 };

/** Coefficients of q, of which the first are those of h, a quadratic. */
enum { VOR_TWOFOLD_COMMON = 10, VOR_TWOFOLD_APART = VOR_QUADRIC_TERMS };

/** Most points, whole vectors of them, and fewest: as many as two sheets have coefficients. */
enum {
    VOR_TWOFOLD_MOST = (VOR_TWOFOLD_USUAL + 7) / 8 * 8,
    VOR_TWOFOLD_LEAST = VOR_TWOFOLD_COMMON + VOR_TWOFOLD_APART
};

/** Two sheets. Lengths are in the unit of the points. */
struct vor_twofold {
    double origin[3], axis[3][3];       /**< rows: two directions along the sheets, and across */
    double radius;                      /**< distance of the farthest point */
    double common[VOR_TWOFOLD_COMMON];  /**< of q; u, v and w are over the radius */
    double apart[VOR_TWOFOLD_APART];    /**< of h */
    double off;                         /**< weighted rms of the points off their sheets */
    signed char side[VOR_TWOFOLD_MOST]; /**< of each point: 1 or -1; which is which means nothing */
};

/** Fits to the points nearest to a place. They count the less the farther they are.
 *
 *  @param[out] out   untouched where it returns 0
 *  @param[in]  near  n x 3, of which none is far from x
 *  @param[in]  n     VOR_TWOFOLD_LEAST .. VOR_TWOFOLD_MOST
 *  @param[in]  x     the place: the origin, from which weights fall
 *
 *  @return 0 where the points do not determine a cubic over a plane
 *
 *  O(n), 17 us for VOR_TWOFOLD_USUAL points. Thread-safe. Depends on nothing but its arguments. */
int vor_twofold_fit(struct vor_twofold *out, const float *near, unsigned n, const double x[3]);

/** How far place x is above the middle between both sheets, measured across.
 *
 *  @param[out] half  half of the distance of the two sheets there: of the sign of the result on
 *                    side 1, of the other on side -1
 *
 *  O(1). Cannot fail. */
double vor_twofold_above(const struct vor_twofold *twofold, const double x[3], double *half);

#endif
