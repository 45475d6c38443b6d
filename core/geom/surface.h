/** The local surface that stands for the input around a seed: a quadric over the tangent plane at
 *  the nearest input point.
 *
 *  Source: Xiao et al. 2024, "Accelerated Lloyd's method for resampling 3D point clouds", Sec.
 *  III-B, Eq. 3 and 4, steps 1, 2 and 4.
 *
 *  Departure: the frame is any orthonormal one whose third axis is the normal; the matrix that the
 *  paper prints is not a rotation.
 *  Departure: beyond the neighbourhood the surface continues as the quadric's tangent plane. A
 *  patch wider than its data would otherwise leave the surface with the square of the distance;
 *  measured, such extrapolation throws points off closed clouds. */
#ifndef VOR_GEOM_SURFACE_H
#define VOR_GEOM_SURFACE_H

#include <stddef.h>
#include <stdint.h>

/** Fewest neighbours that a fit takes. With 10 / 20 / 40 neighbours everywhere, rms distance to the
 *  true surface in 1e-4 of its diagonal: igea 4.7 / 5.0 / 8.4, fandisk 6.7 / 5.7 / 9.4, bunny 5.1 /
 *  2.9 / 6.2, an upsampled cow 18.6 / 18.6 / 29.1 (inputs as in geom/boundary.h; means of three
 *  seeds, which differ by 3 %). */
#define VOR_NEIGHBORS_FEWEST 20

/** Cosine of 60 degrees. Directions that are less apart point the same way: normals are of one
 * face, a triangle has not turned over, an input ends the way that a place lies. At 90 / 60 / 32
 * degrees: border points of square 145 / 147 / 131, of autzen 366 / 342 / 268 (geom/boundary.h).
 * Normals that are more than 120 degrees apart face away from each other: the sides of an edge
 * sharper than 60 degrees do not see each other. */
#define VOR_SAME_WAY 0.5

/** Standard deviations that noise hardly ever goes beyond: 1 in 370 of a normal distribution. */
#define VOR_SURE 3.0

/** Coefficients of a quadric: a fit takes up so many of the points' deviations. */
enum { VOR_QUADRIC_TERMS = 6 };

enum vor_surface_kind {
    VOR_SURFACE_NONE,   /**< no tangent plane: too few distinct points, or all on a line */
    VOR_SURFACE_PLANE,  /**< a plane: the points do not determine a quadric */
    VOR_SURFACE_QUADRIC /**< w = c0 + c1 u + c2 v + c3 uu + c4 uv + c5 vv */
};

/** A fitted surface. Local coordinates are (u, v, w) = axis * (x - origin); lengths are in the unit
 *  of the points, which is the domain's normalised one in a run. */
struct vor_surface {
    enum vor_surface_kind kind;
    double origin[3];  /**< nearest input point */
    double axis[3][3]; /**< rows: two tangents and the normal */
    double c[6];       /**< coefficients of w(u, v) */
    double center[2];  /**< mean of the neighbours in (u, v) */
    double reach;      /**< largest tangential distance of a neighbour from center */
    double spacing;    /**< of the input here: that of a square lattice of the same density */
    double off2;       /**< mean square of the neighbours' heights over the surface */
};

/** Gauss-Newton steps of a projection. Each multiplies the error by the distance from the surface
 *  over the radius of curvature: from a tenth of the radius off, three leave 2e-5 of it, from a
 *  thirtieth 2e-7. */
enum { VOR_SURFACE_PROJECTIONS = 3 };

/** A share that counts as nothing: of a pivot, below which points determine a plane at most; added
 * to the diagonals of sums, so that what the points do not show stays; of a sum of squares, a
 * number or a gap that a step changes, after which none follows; squared, the sine between planes
 * that do not meet. Of pivots at 1e-4 / 1e-3 / 1e-2: points on planes on kitti 8 / 78 / 409 of
 * 3,000, its delta 0.24 / 0.24 / 0.22; igea, fandisk and bunny stay within the spread. */
#define VOR_NEGLIGIBLE 1e-3

/** Times less variance that a fit to fewer neighbours must have to replace the wide one, and times
 *  whose variance it may move x, squared. At 1 / 2 / 4: igea 4.8e-4 / 5.0e-4 / 5.3e-4, fandisk
 *  5.6e-4 / 5.7e-4 / 6.0e-4, largest distance on fandisk 5.4e-3 / 4.5e-3 / 4.5e-3; points on fine
 *  fits on igea 2609 / 1793 / 1005 of 3,000; with the second alone igea 5.3e-4 / 5.0e-4 / 5.0e-4,
 *  fandisk 5.9e-4 / 5.7e-4 / 5.7e-4. Figures as in surface.c. */
#define VOR_FINER 2.0

/** Rms height of points over the surface fitted to them, over the distance to the farthest, from
 *  which they fill space. Points at random in a cube have 0.18 to 0.37 (98 %), those at the crease
 *  of two planes or the corner of three up to 0.15. At 0.085 / 0.17 / 0.34, figures as of
 *  outliers.c: 2.1, 692 and 479 / 2.1, 318 and 349 / 616, 285 and 306; at 0.19 strays between two
 *  close bodies stay. */
#define VOR_SURFACE_THICK 0.17

/** Most points that a surface is fitted to: arrays on the stack have that size. The parameter
 *  `neighbors` goes up to 500. */
#define VOR_NEIGHBORS_MAX 512

/** Fits a surface to k points by least squares.
 *
 *  @param[in] near  k x 3 floats, nearest to the seed first; origin is near[0]
 *  @param[in] k     1 .. VOR_NEIGHBORS_MAX
 *
 *  Cannot fail: kind says what was found. O(k). Thread-safe; depends on nothing but its arguments.
 */
void vor_surface_fit(struct vor_surface *out, const float *near, unsigned k);

/** vor_surface_fit to the points index[0 .. k - 1] of xyz. Returns the kind. */
enum vor_surface_kind vor_surface_fit_to(struct vor_surface *out, const float *xyz,
                                         const uint32_t *index, unsigned k);

/** vor_surface_fit, where the surface may be of no higher kind than `highest`: as VOR_SURFACE_PLANE
 * it never bends, c[3] .. c[5] are 0. highest is not VOR_SURFACE_NONE.
 *
 *  Source of fits of planes: Chen et al. 2018, "Point cloud resampling using centroidal Voronoi
 *  tessellation methods", Sec. 3. */
void vor_surface_fit_as(struct vor_surface *out, const float *near, unsigned k,
                        enum vor_surface_kind highest);

/** vor_surface_fit with weights: neighbour i counts weight[i] times. The first six weights are
 * positive, the others may be 0. Equal weights give the surface of vor_surface_fit up to rounding.
 * spacing is set to 0, because it cannot be computed from weighted points. */
void vor_surface_fit_weighted(struct vor_surface *out, const float *near, const float *weight,
                              unsigned k);

/** Height w over (u, v). gradient, unless NULL, receives dw/du and dw/dv. kind is not NONE. O(1).
 */
double vor_surface_height(const struct vor_surface *surface, double u, double v,
                          double gradient[2]);

/** Ways of k points to their feet on a surface, to first order: a row of k for each axis, and one
 * of the squares of their lengths. kind is not NONE. O(k). */
void vor_surface_feet(const struct vor_surface *surface, const float *near, unsigned k,
                      double *restrict way);

/** Transforms world coordinates into local ones, and back. O(1). */
void vor_surface_to_local(const struct vor_surface *surface, const double x[3], double local[3]);
void vor_surface_to_world(const struct vor_surface *surface, const double local[3], double x[3]);

/** Height of x, in world coordinates, over the surface. kind is not NONE. O(1). */
double vor_surface_above(const struct vor_surface *surface, const double x[3]);

/** The same of a point in floats. */
double vor_surface_abovef(const struct vor_surface *surface, const float x[3]);

/** Moves a local point to the nearest point of the surface, by three Gauss-Newton steps along the
 *  normal, fewer where it is near enough. kind is not NONE. O(1).
 *
 *  Source: Xiao 2024, Sec. IV-D. Departure: it projects onto the quadric itself, not onto the
 *  nearest triangle of its mesh, so that the result does not depend on how finely the patch is
 *  meshed. */
void vor_surface_project(const struct vor_surface *surface, double local[3]);

/** vor_surface_project for x in world coordinates. */
void vor_surface_put(const struct vor_surface *surface, double x[3]);

/** Unit normal, in world axes, over local (u, v); which of the two sides is arbitrary. O(1). */
void vor_surface_normal(const struct vor_surface *surface, const double local[3], double normal[3]);

/** Variance about a surface of the k points, more than 6, that it was fitted to; 0 where kind is
 *  NONE. O(k). */
double vor_surface_variance(const struct vor_surface *surface, const float *near, unsigned k);

/** Replaces the surface by one fitted to the VOR_REFINED_TO neighbours nearest to x, where their
 *  variance about it is at most half of that of all k neighbours about the wide fit: at an edge or
 *  a crease that the wide fit rounds off. Keeps the wide fit where the neighbourhood is thick, and
 *  where the finer one would move x farther than the wide fit's own error.
 *
 *  Source: none of the papers; they fit to the same number of neighbours everywhere. Measured:
 *  igea, 30,000 points of white noise to 10,000, rms distance to the true surface over the diagonal
 *  2.2e-4 with it, 2.7e-4 without.
 *
 *  @param[in] near  the k x 3 points that the surface was fitted to
 *  @param[in] k     VOR_REFINED_MIN .. VOR_REFINED_MAX
 *  @param[in] x     world coordinates
 *
 *  @return whether it replaced the surface
 *
 *  O(k). Depends on nothing but its arguments. */
int vor_surface_refine(struct vor_surface *surface, const float *near, unsigned k,
                       const float x[3]);

/** Neighbours of the finer fit: twice the coefficients of a quadric. At 8 / 12 / 16: rms distance
 *  to the true surface over its diagonal on fandisk 5.9e-4 / 5.7e-4 / 6.3e-4, on igea 5.0e-4 /
 *  5.0e-4 / 5.5e-4, delta of fandisk 0.022 / 0.020 / 0.018. */
#define VOR_REFINED_TO (2 * VOR_QUADRIC_TERMS)
/** Fewest and most neighbours of a wide fit that may be refined: more than 20 are for noise. */
#define VOR_REFINED_MIN (VOR_REFINED_TO + 1)
#define VOR_REFINED_MAX VOR_NEIGHBORS_FEWEST

#endif
