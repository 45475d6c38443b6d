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

/** Two square sheets, `gap` apart, n points in all. */
void vt_cloud_sheets(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap);

/** Mean distance of a cloud's points to the surface. */
double vt_off_mean(const struct vt_shape *shape, const struct vor_cloud *cloud);

#endif
