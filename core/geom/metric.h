/** A metric on a surface: how long an offset counts, by its direction.
 *
 *  In space it is a symmetric positive definite tensor, six numbers xx xy xz yy yz zz; in a tangent
 *  plane, three numbers xx xy yy in its two axes. Here the tensors of a plane have determinant 1:
 *  they change shapes and leave areas. Such a tensor has eigenvalues aspect and 1 / aspect: a cell
 *  that is even in the metric is `aspect` times as long along the second eigenvector as along the
 *  first. The tensor in space that goes with it has eigenvalue 1 along the normal.
 *
 *  Source: Chen 2018, "Point cloud resampling using centroidal Voronoi tessellation methods", Sec.
 *  5.3, whose M is a root of the tensor. Departure: the paper averages roots, whose signs are
 *  arbitrary and cancel; tensors are averaged here, never roots nor eigenvectors. */
#ifndef VOR_GEOM_METRIC_H
#define VOR_GEOM_METRIC_H

#include "core/base/linalg.h"

/** d' g d for g in space. */
static inline double vor_metric_length2(const double g[6], const double d[3])
{
    return g[0] * d[0] * d[0] + g[3] * d[1] * d[1] + g[5] * d[2] * d[2] +
           2 * (g[1] * d[0] * d[1] + g[2] * d[0] * d[2] + g[4] * d[1] * d[2]);
}

/** Two unit vectors in the plane across a unit normal, right-handed with it. O(1). */
void vor_metric_axes(double axis[2][3], const double normal[3]);

/** What a tensor in space is in the plane of two orthonormal axes: its lengths along the plane. */
void vor_metric_restrict(double plane[3], const double g[6], const double axis[2][3]);

/** The tensor in space of one of a plane: 1 along the normal, which the axes are across. */
void vor_metric_raise(double g[6], const double plane[3], const double axis[2][3],
                      const double normal[3]);

/** Scales a tensor of a plane to determinant 1 and reduces its aspect to `most` >= 1.
 *
 *  @return false, and the tensor is that of all directions alike, when it is not positive definite
 */
int vor_metric_even(double plane[3], double most);

/** The metric that curvature asks for: eigenvalues in the ratio of the principal curvatures,
 *  without their signs and each at least `floor`; aspect is the root of that ratio, at most `most`.
 *
 *  @param[in]  bend   second fundamental form in orthonormal axes of the tangent plane: xx xy yy
 *
 *  Source: Chen 2018, Sec. 5.3; a curvature that is negative counts by its size. */
void vor_metric_of_bend(double plane[3], const double bend[3], double floor, double most);

/** Aspect of a tensor of determinant 1: its larger eigenvalue, >= 1. */
double vor_metric_aspect(const double plane[3]);

/** Unit vector, in the plane's axes, along which lengths count least: the long side of cells, the
 *  direction of least curvature. Its sign is arbitrary; so is all of it where the aspect is 1. */
void vor_metric_long_side(double direction[2], const double plane[3]);

/** The positive root of a tensor of determinant 1, xx xy yy, also of determinant 1: takes offsets
 *  in the plane to such whose Euclidean length is that of the metric. Its inverse is
 *  {yy, -xy, xx}. */
void vor_metric_root(double root[3], const double plane[3]);

#endif
