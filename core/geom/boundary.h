/** Where the cloud ends: one question, and every number that decides about it.
 *
 *  The question: how far does the input go on from one of its points in one
 *  direction, until its last point? Four ask it. Lengths are in spacings of the input around the
 *  place (struct vor_surface, spacing) unless a constant says otherwise.
 *
 *  - OUTSIDE asks for a point that moves, away from the mean of the neighbours. It stops at an
 *     allowed distance from the nearest input point: less where it is beyond the end of the input
 *     than where that goes on, as across a gap. Source: Xiao et al. 2024, Sec. IV-E. Departure:
 *     the paper holds a point still that is farther from the input than a global threshold.
 *     Measured, that freezes closed clouds: nearly half of a white-noise surface is farther than
 *     the mean spacing from every input point. One place in 300,000 of white noise is farther than
 *     two spacings.
 *  - EDGE asks the same for a seed. Its cell ends a fraction of a spacing beyond the end, so its
 *     centroid stays inside and points hardly ever meet OUTSIDE.
 *  - HOLE asks, in an input that is sampled regularly, from the point nearest to a place, its
 *     foot, straight towards the place. Where the input does not go on, the place lies in a hole
 *     or beyond an edge, however narrow, and a point stays near the foot and the points next to
 *     it. Where many places are like that, the holes are GAPS OF THE SAMPLING, made by how the
 *     input was taken (a depth image in steps, scan lines, a rotating scanner); they are to be
 *     filled, and HOLE is not asked. Measured: bunny's points lie at most 0.0071 of the diagonal
 *     off the true mesh, in its holes, with HOLE, 0.011 without, rms 2.9e-4 and 6.5e-4. Asked of a
 *     scan, it raises delta (office1: 0.18 to 0.22).
 *  - RIM asks as EDGE does, for a point of a finished result that has none of the result's points
 *     on one side: at the input ahead of it. If that ends to the same side, it is a border point.
 *
 *  Holes narrower than VOR_OUTSIDE_MOVING either fill (OUTSIDE and EDGE alone, as in the paper)
 *  or, in a regular input, stay open (HOLE); wider ones shrink.
 *
 *  OUTSIDE, EDGE and RIM ask the VOR_NEIGHBORS_FEWEST nearest neighbours where the input ends. Fits
 * to more of them, where noise asks for that, reach around holes and corners. Asked of all / of
 * those: scans of a sheet with a hole, of three sheets and of a band (150, 45 and 100
 * neighbours) 3.6, 2.4 and 1.9 / 2.0, 1.5 and 1.2 of the input's distance to the surface.
 *
 *  Each makes something else of the answer, by constants of its own. One for all was tried: figures
 *  before / after, of three seeds, on the inputs below and on 80,000 points of half an armadillo
 *  to 8,000; * is a loss beyond the spread.
 *
 *  - All look within 45 degrees, and EDGE's ramp has one constant: delta of scannet 0.045 /
 *     0.048*, area of kitti 1471 / 1173 m2*, delta of square 0.024 / 0.021, rms on bunny 2.9e-4 /
 *     2.8e-4. Chance gaps of white noise are taken for ends, and rooms jump as points enter and
 *     leave the angle: the Anderson mix no longer converges on a sphere and a torus*, nor at 60
 *     degrees.
 *  - EDGE alone looks within 37 degrees: six on fandisk 0.81 / 0.75*, on the armadillo 0.75 /
 *     0.73*, delta of scannet 0.045 / 0.050*.
 *  - HOLE asks as RIM does: delta of bunny 0.0184 / 0.0194*, of cow 0.096 / 0.106*, rms on bunny
 *     2.9e-4 / 3.1e-4, searches on square 29 / 54 thousand*. The rim of a hole goes on at both of
 *     its sides.
 *  - EDGE's ramp alone has one constant, room growing as extent / (1 - extent / sight): delta of
 *     scannet 0.045 / 0.047*, of autzen 0.101 / 0.094, of the armadillo 0.0204 / 0.0201.
 *  - OUTSIDE asks from the foot as HOLE does, RIM towards the free side without VOR_SAME_WAY,
 *     VOR_OUTSIDE_EVENING is IN_RESULT: delta of autzen
 * 0.101 / 0.096, of kitti 0.24 / 0.25, of square 0.024 / 0.022, of scannet, bunny, fandisk, cow and
 *     the armadillo within 3 %; border of kitti 752 / 1008. Neither a loss nor a gain is certain.
 *
 *  Figures "at a / b / c" belong to the chosen value b, a lower a and a higher c. Inputs: bunny,
 *  autzen, kitti and scannet as they are, fandisk and igea as 12,000 points of white noise on the
 *  mesh, `square` 8,000 of them on a unit square, `cow` 2,903 vertices upsampled to 11,612.
 *  Results: 3,000 points (square 1,500, scannet 4,000), default request. rms and max are distances
 *  to the true surface over its diagonal; six is the share of points with six neighbours; far is
 *  the largest distance to the input in spacings of the result. Means of three seeds, of one for
 *  HOLE and RIM; other seeds move delta by 4 % (kitti 8 %), rms by 3 % (bunny 10 %), six by 1 %,
 *  border by 3 %. */
#ifndef VOR_GEOM_BOUNDARY_H
#define VOR_GEOM_BOUNDARY_H

#include "core/geom/surface.h"

/* --- the question ---------------------------------------------------------------------------- */

/** How wide to look: least cosine between the way and what is ahead. EDGE, RIM and OUTSIDE take all
 *  neighbours, HOLE those within 37 degrees. At cosines of 0.5 / 0.8 / 0.95: rms on bunny 4.2e-4 /
 *  2.8e-4 / 5.5e-4, max 8.8e-3 / 5.4e-3 / 9.9e-3. */
#define VOR_AHEAD_NARROW 0.8

/* --- outside; in spacings of the input ------------------------------------------------------- */

/** How far a point may be from the nearest input point while a method moves it: it may cross a gap.
 *  Source: none; the paper's threshold is 0.5 to 1.5. At 1.75 / 3.5 / 7: points ever held on kitti
 *  1399 / 878 / 408, on autzen 203 / 68 / 32, on square 11 / 1 / 0; delta of kitti 0.22 / 0.24 /
 *  0.30. */
#define VOR_OUTSIDE_MOVING 3.5
/** How far it may be in the result. At 0.75 / 1.5 / 3: far on autzen 0.70 / 1.39 / 2.36, on kitti
 *  4.0 / 6.8 / 8.6, delta of autzen 0.116 / 0.103 / 0.096; white noise keeps within 0.8. */
#define VOR_OUTSIDE_IN_RESULT 1.5
/** How far it may be while evening out without being turned back. At 0.6 / 1.2 / 2.4: delta of
 *  square 0.0279 / 0.0227 / 0.0218, of kitti 0.26 / 0.24 / 0.22, searches on kitti 0.30 / 0.33 /
 *  0.47 million. */
#define VOR_OUTSIDE_EVENING 1.2
/** Share of these distances that is allowed beyond the end of the input. At 0.3 / 0.6 / 1.2: far on
 *  autzen 1.39 / 1.39 / 1.63, points ever held on kitti 1171 / 878 / 539, on square 9 / 1 / 0. */
#define VOR_OUTSIDE_BEYOND 0.6

/* --- edge ------------------------------------------------------------------------------------ */

/** Spacings of the input that a cell may extend beyond the last neighbour. At 0.2 / 0.4 / 0.8: area
 *  of square 1.029 / 1.031 / 1.049, of kitti 1330 / 1458 / 1689 m2, points ever held on square 0 /
 *  1 / 7, on kitti 804 / 878 / 1070. */
#define VOR_EDGE_ROOM 0.4
/** Reaches of the neighbourhood: neighbours that end this near mean an edge ... At 0.1 / 0.2 / 0.4:
 *  area of square 1.035 / 1.031 / 1.021, of kitti 1496 / 1458 / 1451 m2. */
#define VOR_EDGE_SURE_BORDER 0.2
/** ... and those that extend this far mean none. At 0.25 / 0.5 / 1: border points of square 129 /
 *  147 / 145 (four sides of 38), delta of square 0.0223 / 0.0227 / 0.0244, of autzen 0.099 / 0.103
 *  / 0.112. */
#define VOR_EDGE_SURE_INSIDE 0.5
/** Spacings of the result: with less room than this, a point is not pushed towards the edge. At 0.3
 *  / 0.6 / 1.2: delta of square 0.0212 / 0.0227 / 0.0236, its border points 142 / 147 / 145. */
#define VOR_EDGE_EVENING 0.6

/* --- hole ------------------------------------------------------------------------------------ */

/** Spacings of the input that a point may be from the foot, into a hole, where the input surrounds
 *  the point, or unless more points are made than it has; else from the lines between the foot and
 *  the points of its first ring (VOR_RIM_RING). From the foot alone, points beyond a border end on
 *  circles around the input's points: delta of four times as many points as a saddle with a hole, a
 *  square one and folds have 0.131, 0.121, 0.135, from the lines 0.088, 0.083, 0.099. Of fewer
 *  points none shows the circles, and beside thin ridges of closed shapes the lines lead off: a
 *  screw's mesh has 9 open edges with them. At 0.125 / 0.25 / 0.5: rms on bunny 2.6e-4 / 2.8e-4 /
 *  3.4e-4; less draws points onto the rim. Also how far a point that the input surrounds may lie
 *  off the surface around its foot, in half spacings of the result (seeds/attach.h). */
#define VOR_HOLE_MARGIN 0.25
/** Spacings from the input: a place that is farther may be in a hole. At 0.35 / 0.7 / 1.4: rms on
 *  bunny 2.9e-4 / 2.8e-4 / 3.6e-4, max 5.9e-3 / 5.4e-3 / 10.8e-3, searches on square 32 / 27 / 23
 *  thousand. */
#define VOR_HOLE_INSIDE 0.7
/** Least regularity (vor_boundary_regularity) at which a gap is a hole: white noise has 1, a square
 *  lattice 2. At 1.2 / 1.4 / 1.7: rms on bunny 3.0e-4 / 2.8e-4 / 5.3e-4, delta of fandisk 0.0210 /
 *  0.0197 / 0.0192. */
#define VOR_HOLE_REGULAR 1.4
/** Fewer neighbours do not show a hole: as many as a refined fit has. At 6 / 12 / 24: rms on bunny
 *  3.1e-4 / 2.8e-4 / 5.3e-4; 24 is more than an exact input's fits have, and turns the rule off. */
#define VOR_HOLE_NEIGHBORS_MIN VOR_REFINED_TO
/** Share of the points in holes above which these are gaps of the sampling. Points beyond the end
 * of the input do not count: a small open sheet has many (6 % of 6,400 on a grid of 40 x 40).
 * Shares measured on 5,000 points without polish: the grid 0.002, fandisk 0.004, bunny 0.006, cow
 * 0.013 (regular, with or without holes); scannet 0.031, autzen 0.075, kitti 0.14, office1 0.15
 * (scans). At 0.01 / 0.02 / 0.04 cow and scannet change sides. */
#define VOR_GAPS_SHARE 0.02

/* --- the rim: points of a finished result at the border ----------------------------------------
 * Source: none of the papers. A point lies at the border when the points around it leave an angle
 * free (a missing neighbour leaves 120 degrees, a straight border 180) and the input ends that way.
 * A square of 1,500 points has 152 on its border, a closed surface none. */

/** Times the distance of its third nearest: points within that are the first ring around a point.
 *  At 1.3 / 1.6 / 2.2: border points of bunny 42 / 28 / 10, of fandisk 1 / 0 / 0, of square 147
 *  each. */
#define VOR_RIM_RING 1.6

/* The functions below take neighbours as k x 3 floats, in the same coordinates as the place. They
 * cannot fail, and depend on nothing but their arguments. */

/** True when the input goes on from its point at foot along `way`: a neighbour within `within` is
 *  ahead, VOR_AHEAD_NARROW. O(k). */
int vor_boundary_goes_on(const float *near, unsigned k, const double foot[3], const double way[3],
                         double within);

/** Distance from seed, along the unit vector side, to where the points near it end;
 *  negative if it lies beyond. side and seed are in the local coordinates of `frame`. O(k). */
double vor_boundary_end(const struct vor_surface *frame, const double seed[3], const double side[2],
                        const float *near, unsigned k);

/** EDGE. How far the cell of a seed may extend towards the side that its neighbours leave empty:
 *  VOR_EDGE_ROOM spacings beyond the end, and more, up to the patch's radius, the farther that is.
 *  Infinite where they surround the seed.
 *
 *  @param[in]  seed  in the surface's local coordinates
 *  @param[out] side  that side, a unit vector along the surface; unset where they surround the seed
 *                    exactly
 *
 *  O(k). */
double vor_boundary_room(const struct vor_surface *surface, const float *near, unsigned k,
                         const double seed[3], double radius, double side[2]);

/** RIM. True when `count` unit vectors along a surface leave an angle of such a cosine free.
 *
 *  @param[out] side  the unit vector to its middle; unset where none is free
 *
 *  O(count^2). */
int vor_boundary_free_side(const double direction[][2], unsigned count, double cosine,
                           double side[2]);

/** True when a neighbour is within `distance` of x. O(k). */
int vor_boundary_within(const float *near, unsigned k, const double x[3], double distance);

/** Copies the neighbour nearest to x to foot, and to `way` the unit vector from there to x; zero if
 *  they coincide. Returns the distance between them. O(k). */
double vor_boundary_foot(const float *near, unsigned k, const double x[3], double foot[3],
                         double way[3]);

/** HOLE. Moves x straight towards the lines from foot, its nearest point, to those of the k points
 *  that are in its first ring (VOR_RIM_RING; of none, towards foot), to VOR_HOLE_MARGIN spacings
 *  from them. Returns whether it was farther away. `spacing` is vor_boundary_spacing. O(k). */
int vor_boundary_pull(const float *near, unsigned k, const double foot[3], double spacing,
                      double x[3]);

/** Distance from x to the farthest of the neighbours. O(k). */
double vor_boundary_reach(const float *near, unsigned k, const double x[3]);

/** Mean distance of the k >= 2 neighbours to the nearest other one of them, over that of white
 *  noise of the same spacing: 1 in white noise, less on scan lines, 2 on a square lattice. O(k^2).
 *
 *  Source: Clark and Evans 1954, "Distance to nearest neighbor as a measure of spatial
 *  relationships in populations". */
double vor_boundary_regularity(const float *near, unsigned k, double spacing);

/** The input around a place. Owns nothing. */
struct vor_border {
    const struct vor_surface *surface; /**< fitted to near; kind is not NONE */
    const float *near;                 /**< k x 3, the input points nearest to the place */
    unsigned k;
    double spacing; /**< of the input at the nearest of them; not at the place itself, whose
                         neighbours may surround a hole */
};

/** Spacing of the input at the neighbour nearest to x: the distance from it to the third nearest
 *  other one, which is about one spacing inside the input and 1.4 at its border. Unlike the
 *  surface's own spacing it does not grow with a hole that the neighbours surround. k >= 4. O(k).
 */
double vor_boundary_spacing(const float *near, unsigned k, const double x[3]);

/** True when x lies beyond the end of the input: no neighbour reaches as far towards the side that
 *  the neighbours leave empty. O(k). */
int vor_boundary_beyond(const struct vor_surface *surface, const float *near, unsigned k,
                        const double x[3]);

/** OUTSIDE. True when x, the place that border is about, is farther from the nearest input point
 *  than `spacings` allow. O(k). */
int vor_boundary_outside(const struct vor_border *border, double spacings, const double x[3]);

/** OUTSIDE. True when a point that moves from the place that border is about to another one nearby
 *  ends farther from the input than it began, and outside, by the spacing of the border or of the
 *  input around that place, the smaller. O(k). */
int vor_boundary_leaves(const struct vor_border *border, double spacings, const double from[3],
                        const double to[3]);

/** OUTSIDE. If x is outside, moves it straight towards the nearest input point, to the distance
 * that is allowed. Returns whether it was outside. O(k). */
int vor_boundary_restrict(const struct vor_border *border, double spacings, double x[3]);

#endif
