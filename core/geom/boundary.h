/** Keeps points from leaving where the cloud ends.
 *
 *  Source: Xiao et al. 2024, Sec. IV-E. Departure: the paper holds a point still when it is farther
 *  from the input than a global threshold; measured, that freezes closed clouds, since nearly half
 * of a white-noise surface is farther than the mean spacing from every input point. Here a place is
 *  outside when it is more than two local spacings away from every input point (one place in
 * 300,000 of white noise is), or more than one and all its neighbours lie to one side of it; a
 * point that would go there stops at that distance instead of standing still. Holes narrower than
 * four spacings fill as in the paper, wider ones shrink. Departure: so that points hardly ever meet
 * that bound, a cell ends where the input ends; a seed near the border finds its centroid a
 * fraction of a spacing inside.
 *
 *  Departure: a hole is told from chance by what the input does around it. Seen from the input
 * point nearest to a place, its foot, the input goes on beyond the place or it does not; where it
 * does not, and is regular there, the place is in a hole or beyond an edge, however narrow, and a
 * point stays within a quarter of a spacing of the foot; unless so many do (seeds/attach) that
 * gaps are how the input was taken. */
#ifndef VOR_GEOM_BOUNDARY_H
#define VOR_GEOM_BOUNDARY_H

#include "core/geom/surface.h"

/** How far the cell of a seed may reach towards the side that its neighbours (k x 3 floats) leave
 * empty, and that side as a unit vector along the surface; infinite where they surround the seed.
 * The bound is 0.4 spacings beyond the last neighbour, and opens to the patch's radius as the
 * neighbours spread evenly. O(k). */
double vor_boundary_room(const struct vor_surface *surface, const float *near, unsigned k,
                         const double seed[3], double radius, double side[2]);

/** Distance from seed, along the unit vector side, to 0.4 spacings beyond the last of the points;
 * not less than those. side and seed in the local coordinates of `frame`, spacing that of
 * `there`, the surface fitted to the points. O(k). */
double vor_boundary_end(const struct vor_surface *frame, const double seed[3], const double side[2],
                        const struct vor_surface *there, const float *near, unsigned k);

/** True when one of the neighbours is at most so far from x. O(k). */
int vor_boundary_within(const float *near, unsigned k, const double x[3], double distance);

/** True when a place at x is surely not outside, judged by the surface and neighbours (k x 3
 * floats) at another place nearby: one of them is within one spacing of x. O(k). */
int vor_boundary_inside(const struct vor_surface *surface, const float *near, unsigned k,
                        const double x[3]);

/** The neighbour nearest to x in foot; returns how far x is from it. O(k). */
double vor_boundary_foot(const float *near, unsigned k, const double x[3], double foot[3]);

/** Distance from x to the farthest of its neighbours. O(k). */
double vor_boundary_reach(const float *near, unsigned k, const double x[3]);

#define VOR_BORDER_MARGIN 0.25 /**< spacings into a hole, or beyond an edge, of a regular input */

/** True when one of the neighbours (k x 3 floats) lies beyond x as seen from foot, within 37
 * degrees of that direction and at most so far from the foot. O(k). */
int vor_boundary_beyond(const float *near, unsigned k, const double foot[3], const double x[3],
                        double distance);

/** Mean distance of the k neighbours to the nearest other one of them, over what it is in white
 * noise of that spacing: 1 there, less on scan lines, 2 on a square lattice. At least two
 * neighbours. O(k^2). Source: Clark and Evans 1954. */
double vor_boundary_regularity(const float *near, unsigned k, double spacing);

/** What is known of the input around a place. */
struct vor_border {
    const struct vor_surface *surface; /**< fitted to near; kind is not NONE */
    const float *near;                 /**< k x 3, the input points nearest to the place */
    unsigned k;
    double spacing; /**< of the input at the nearest of them: not read off the place itself, whose
                         neighbours may lie around a hole */
};

/** Times the spacing that a point may lie away from the input: while it moves, and in the result.
 */
#define VOR_BORDER_MOVING 3.5
#define VOR_BORDER_SETTLED 1.5
#define VOR_BORDER_ONE_SIDED 0.6 /**< of that where all neighbours lie to one side */

/** Unit vector from the neighbour that is nearest to x towards x; zero where they coincide. O(k).
 */
void vor_boundary_outward(const float *near, unsigned k, const double x[3], double out[3]);

/** Spacing of the input at the neighbour that is nearest to x, by how far the third nearest of the
 * other neighbours is from it: about one spacing inside the input, 1.4 at its border. Unlike the
 * surface's own it does not grow with a hole that the neighbours lie around. At least three
 * neighbours. O(k). */
double vor_boundary_spacing(const float *near, unsigned k, const double x[3]);

/** True when x, the place that border is about, lies outside, given how many spacings away it may
 * be. O(k). */
int vor_boundary_outside(const struct vor_border *border, double spacings, const double x[3]);

/** True when a point that goes from one place, which border is about, to another one nearby ends
 * outside, and farther from the input than it began. O(k). */
int vor_boundary_leaves(const struct vor_border *border, double spacings, const double from[3],
                        const double to[3]);

/** As vor_boundary_outside, and then x is moved straight towards the nearest point, to the distance
 * allowed. */
int vor_boundary_restrict(const struct vor_border *border, double spacings, double x[3]);

#endif
