/** Openings beside a point: where an empty disc can touch it.
 *
 *  A disc of a given radius lies in the tangent plane of a point and touches it. Each neighbour
 *  forbids a range of directions in which the disc's centre may lie: 180 degrees if it is very
 *  near, 120 degrees at a distance of one radius, none at two. What is left over are openings; a
 *  disc that is turned around the point through an opening stops at a neighbour on either side.
 *  These two are the next points of the border.
 *
 *  Source: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi tessellation
 *  methods", Sec. 5.5: the largest angle between neighbours in the tangent plane.
 *  Departure: there each of the k nearest forbids the same angle, whatever its distance. So a hole
 *  must be much wider than the ball of the k nearest: at the border of one that is five spacings
 *  across, 30 neighbours reach around it, and no angle between them is wider than 90 degrees. Here
 *  the radius says how wide a hole must be. The border is that of alpha shapes (Edelsbrunner,
 *  Kirkpatrick, Seidel 1983, "On the shape of a set of points in the plane"), which comes as one
 *  row of points and not as a band to be thinned. */
#ifndef VOR_GEOM_OPENING_H
#define VOR_GEOM_OPENING_H

/** Most neighbours, and most openings of a point that are told. Three and more are those of a lone
 *  point. */
enum { VOR_OPENING_NEAR = 96, VOR_OPENINGS = 2 };

struct vor_opening {
    unsigned end[2]; /**< neighbours at which the disc stops; the same one if there is no other */
    double middle[2][3]; /**< where its centre is then */
    double outward[3];   /**< unit vector to the middle of the opening, in the plane */
};

/** Finds the widest openings beside x.
 *
 *  @param[in] near    k x 3 floats; those at x itself are passed over
 *  @param[in] k       at most VOR_OPENING_NEAR; nearer ones than two radii should be among them
 *  @param[in] normal  unit length, of either sign
 *  @param[in] radius  > 0
 *
 *  @return how many: 0 .. VOR_OPENINGS, the widest first; 0 if no neighbour is within two radii
 *
 *  O(k) inside the surface, O(k^2) at most. Cannot fail. Depends on nothing but its arguments; uses
 *  no function whose bits differ between machines. */
unsigned vor_openings_find(struct vor_opening out[VOR_OPENINGS], const float *near, unsigned k,
                           const double x[3], const double normal[3], double radius);

#endif
