/** Made surfaces of which the truth is known, and how far a cloud is from them. */
#ifndef VT_SHAPE_H
#define VT_SHAPE_H

#include "tests/support/vt.h"

struct vt_shape {
    const char *name;
    void (*make)(struct vor_cloud *cloud, uint64_t seed, size_t n); /**< even by area */
    double (*off)(const double x[3]); /**< distance from x to the surface */
    double area;
};

#define VT_TORUS_TUBE 0.4 /* radius of the tube, around a circle of radius 1 */

enum { VT_SPHERE, VT_TORUS, VT_SMOOTH }; /* VT_SMOOTH: how many */

/** The closed smooth ones. */
extern const struct vt_shape vt_shapes[VT_SMOOTH];

/** n points, even by area, on a torus about the z axis. */
void vt_cloud_torus(struct vor_cloud *cloud, uint64_t seed, size_t n);

/** n points, even by area, on an ellipsoid of half axes `half`, 1 and 1. */
void vt_cloud_ellipsoid(struct vor_cloud *cloud, uint64_t seed, size_t n, double half);

/** Radius of the tube around the trefoil knot, which lies on a torus of radii 2 and 1. */
#define VT_KNOT_TUBE 0.4

/** n points on a tube around a trefoil knot, even up to the bend of the tube. normal (n x 3, or
 *  NULL) receives the outward normals. */
void vt_cloud_knot(struct vor_cloud *cloud, float *normal, uint64_t seed, size_t n);

/** n points, nearly even, on a Moebius band of that width around a circle of radius 1. */
void vt_cloud_moebius(struct vor_cloud *cloud, uint64_t seed, size_t n, double width);

/** Two square sheets, `gap` apart, n points in all. */
void vt_cloud_sheets(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap);

/** Surfaces on which the distance along them is known, some with sheets near to each other. */
struct vt_metric {
    const char *name;
    /** n points, even by area; sheets are `gap` apart. */
    void (*make)(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap);
    /** Distance along the surface between two of its points; INFINITY if no way leads. */
    double (*along)(const double a[3], const double b[3], double gap);
    double area; /**< for small gaps */
};

/** The first VT_ONE_SHEET have no sheets. FOLD: two unit squares joined by half a cylinder; PLATE:
 * a closed box of 1 x 1 x gap, whose exact distances are those from one large face to the other. */
enum { VT_SQUARE, VT_BALL, VT_CYLINDER, VT_FOLD, VT_PLATE, VT_SHEETS, VT_SPHERES, VT_METRICS };
enum { VT_ONE_SHEET = VT_FOLD };
extern const struct vt_metric vt_metrics[VT_METRICS];

/** Distance between neighbours of n points on a lattice over the surface. */
double vt_spacing(const struct vt_metric *metric, size_t n);

/** Mean distance of a cloud's points to the surface. */
double vt_off_mean(const struct vt_shape *shape, const struct vor_cloud *cloud);

#endif
