/** Where the cloud ends: the one place that says it, and every number that decides about it.
 *
 *  Three rules, each judged from the input points around a place. Lengths are in spacings of the
 *  input there (struct vor_surface, spacing) unless a constant says otherwise.
 *
 *  1. OUTSIDE: too far from every input point. A point that would go there stops at that distance.
 *     Source: Xiao et al. 2024, Sec. IV-E. Departure: the paper holds a point still that is farther
 *     from the input than a global threshold. Measured, that freezes closed clouds: nearly half of
 *     a white-noise surface is farther than the mean spacing from every input point. One place in
 *     300,000 of white noise is farther than two spacings.
 *  2. EDGE: the neighbours leave one side of a seed empty; its cell ends a fraction of a spacing
 *     beyond the last of them, so that its centroid stays inside and points hardly ever meet
 * rule 1.
 *  3. HOLE: the place is off the input, and the input, which is regular there, does not go on
 *     beyond it as seen from the nearest input point, its foot. The place lies in a hole or beyond
 *     an edge, however narrow, and a point stays within a quarter of a spacing of the foot. Where
 *     many places are so, they are GAPS OF THE SAMPLING, how the input was taken (scan lines, a
 *     rotating scanner): then no place is a hole.
 *
 *  A point of a finished result is counted as a border point by a test of its own (the RIM below),
 *  which looks at the result's points first and asks rule 2 of the input ahead.
 *
 *  Holes narrower than VOR_OUTSIDE_MOVING either fill (rules 1 and 2 alone, as in the paper) or, in
 *  a regular input, stay open (rule 3); wider ones shrink. */
#ifndef VOR_GEOM_BOUNDARY_H
#define VOR_GEOM_BOUNDARY_H

#include "core/geom/surface.h"

/* --- rule 1: outside; in spacings of the input --------------------------------------------- */

/** A point that a method moves may be so far from the nearest input point: it may cross a gap. */
#define VOR_OUTSIDE_MOVING 3.5
/** Where it comes to rest. */
#define VOR_OUTSIDE_IN_RESULT 1.5
/** Where evening out would take it farther away. */
#define VOR_OUTSIDE_EVENING 1.2
/** Share of these where all neighbours lie to one side of the place. */
#define VOR_OUTSIDE_ONE_SIDED 0.6

/* --- rule 2: edge ---------------------------------------------------------------------------- */

/** Spacings of the input that a cell may reach beyond the last neighbour. */
#define VOR_EDGE_ROOM 0.4
/** Reaches of the neighbourhood: neighbours that end this near mean an edge ... */
#define VOR_EDGE_SURE_BORDER 0.2
/** ... and those that go on so far mean none. */
#define VOR_EDGE_SURE_INSIDE 0.5
/** Spacings of the result: with less room than that, a point is not pushed on towards the edge. */
#define VOR_EDGE_EVENING 0.6
/** Spacings of the result around a point without an edge: none is looked for until it has moved. */
#define VOR_EDGE_INTERIOR 1.5

/* --- rule 3: hole ---------------------------------------------------------------------------- */

/** Spacings of the input from the foot that a point may go into a hole. */
#define VOR_HOLE_MARGIN 0.25
/** Spacings from the input: farther, a place may be in a hole. */
#define VOR_HOLE_INSIDE 0.7
/** Cosine of 37 degrees: a point beyond a place lies within that angle of the way from the foot. */
#define VOR_HOLE_BEYOND 0.8
/** Regularity (vor_boundary_regularity) from which on a gap is a hole: white noise has 1, a square
 *  lattice 2. */
#define VOR_HOLE_REGULAR 1.4
/** Fewer neighbours tell no hole. */
#define VOR_HOLE_NEIGHBORS_MIN 12
/** Share of the points in holes, above which these are gaps of the sampling. Measured on 5,000
 *  points without polish: igea 0.001, fandisk 0.004, bunny and armadillo 0.007 (regular, with holes
 *  or none); autzen 0.09, scannet 0.10, kitti 0.21, office1 0.23 (scans). */
#define VOR_GAPS_SHARE 0.03
/** Points looked at for that share, at least half of them, where there are more. */
#define VOR_GAPS_COUNTED 60000

/* --- the rim: points of a finished result at the border ----------------------------------------
 * Source: none of the papers. A point lies at the border when the points around it leave an angle
 * free (a missing neighbour leaves 120 degrees, a straight border 180) and the input ends that way.
 */

/** Times the distance of its third nearest: the first ring around a point, not the next. */
#define VOR_RIM_RING 1.6
/** Cosine of 130 degrees, the angle left free. */
#define VOR_RIM_FREE_COSINE (-0.64278760968653936)
/** Spacings of the result, and of the input, from the point to the place ahead that is asked. */
#define VOR_RIM_AHEAD 0.75
#define VOR_RIM_AHEAD_INPUT 0.5
/** Cosine of 60 degrees, between the way to that place and the one in which the input ends there.
 */
#define VOR_RIM_SAME_WAY 0.5

/** How far the cell of a seed may reach towards the side that its neighbours (k x 3 floats) leave
 * empty, and that side as a unit vector along the surface; infinite where they surround the seed.
 * The bound is VOR_EDGE_ROOM spacings beyond the last neighbour, and opens to the patch's radius as
 * the neighbours spread evenly. O(k). */
double vor_boundary_room(const struct vor_surface *surface, const float *near, unsigned k,
                         const double seed[3], double radius, double side[2]);

/** Distance from seed, along the unit vector side, to VOR_EDGE_ROOM spacings beyond the last of the
 * points; not less than those. side and seed in the local coordinates of `frame`, spacing that of
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

/** Rule 3. True when one of the neighbours (k x 3 floats) lies beyond x as seen from foot, within
 * the angle of VOR_HOLE_BEYOND of that direction and at most so far from the foot. O(k). */
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
