/** The local surface that stands for the input around a seed: a quadric over the tangent plane at
 * the nearest input point.
 *
 *  Source: Xiao et al. 2024, "Accelerated Lloyd's method for resampling 3D point clouds", Sec.
 * III-B, Eq. 3 and 4, steps 1, 2 and 4.
 *
 *  Departure: the frame is any orthonormal one whose third axis is the normal (the printed rotation
 *  is not one). Departure: beyond the neighbourhood the quadric goes on as its tangent plane, so
 * that no patch that is wider than its data runs away with the square of the distance; measured,
 * such extrapolation throws points off closed clouds. */
#ifndef VOR_GEOM_SURFACE_H
#define VOR_GEOM_SURFACE_H

#include <stddef.h>
#include <stdint.h>

enum vor_surface_kind {
    VOR_SURFACE_NONE,   /**< no tangent plane: too few distinct points, or all on a line */
    VOR_SURFACE_PLANE,  /**< a plane: the points do not determine a quadric */
    VOR_SURFACE_QUADRIC /**< w = c0 + c1 u + c2 v + c3 uu + c4 uv + c5 vv */
};

/** Local coordinates (u, v, w) = axis * (x - origin); lengths in the cloud's unit. */
struct vor_surface {
    enum vor_surface_kind kind;
    double origin[3];  /**< nearest input point */
    double axis[3][3]; /**< rows: two tangents and the normal */
    double c[6];       /**< coefficients of w(u, v) */
    double center[2];  /**< mean of the neighbours in (u, v) */
    double reach;      /**< largest tangential distance of a neighbour from center */
    double spacing;    /**< of the input here: what a square lattice of the same density has */
    double off2;       /**< mean square of the neighbours' heights over the surface */
};

#define VOR_NEIGHBORS_MAX 512

/** Fits a surface to k points.
 *
 *  @param[in] near  k x 3 floats, nearest to the seed first; origin is near[0]
 *  @param[in] k     1 .. VOR_NEIGHBORS_MAX
 *
 *  Total: never fails, kind says what was found. O(k). Depends on nothing but its arguments. */
void vor_surface_fit(struct vor_surface *out, const float *near, unsigned k);

/** The same where neighbour i counts weight[i] > 0 times (the first six weights at least, the
 * others may be 0); with equal weights the same surface up to rounding. spacing is 0: weights hide
 * it. */
void vor_surface_fit_weighted(struct vor_surface *out, const float *near, const float *weight,
                              unsigned k);

/** Height w and (where gradient is not NULL) slopes dw/du, dw/dv over (u, v). */
double vor_surface_height(const struct vor_surface *surface, double u, double v,
                          double gradient[2]);

/** Into and out of local coordinates. */
void vor_surface_to_local(const struct vor_surface *surface, const double x[3], double local[3]);
void vor_surface_to_world(const struct vor_surface *surface, const double local[3], double x[3]);

/** Moves a local point to the nearest point of the surface, by Gauss-Newton along the normal.
 *
 *  Source: Xiao 2024, Sec. IV-D. Departure: onto the quadric itself, not onto the nearest triangle
 * of its mesh, so that the result does not depend on how finely the patch is meshed. */
void vor_surface_project(const struct vor_surface *surface, double local[3]);

/** Moves x, in world coordinates, to the nearest point of the surface. */
void vor_surface_put(const struct vor_surface *surface, double x[3]);

/** Unit normal of the surface at local (u, v), in world axes. */
void vor_surface_normal(const struct vor_surface *surface, const double local[3], double normal[3]);

/** Fits anew to the twelve of the k neighbours that are nearest to x, where those lie half as far
 * about their quadric, in variance, as all of them about theirs: at an edge or a crease that the
 * wider fit rounds off. Not where the neighbourhood is thick, nor where x would move farther along
 * with it than the wider fit is off. Source: none of the papers; they fit to one number of
 * neighbours everywhere. 13 <= k <= VOR_REFINED_MAX: more are for inputs with noise. O(k).
 *
 *  @return whether it did */
int vor_surface_refine(struct vor_surface *surface, const float *near, unsigned k,
                       const float x[3]);

#define VOR_REFINED_TO 12 /**< neighbours */
#define VOR_REFINED_MIN 13
#define VOR_REFINED_MAX 20

#endif
