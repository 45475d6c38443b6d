/** Wedges with noise, as in Huang et al. 2013, Fig. 12, and how well a resampling keeps their edge.
 *
 *  A wedge: two unit squares that meet along the y axis, 0 <= y <= 1, at an angle. The first lies
 *  in z = 0 towards +x; the second is the first turned about the y axis by that angle. */
#ifndef VT_WEDGE_H
#define VT_WEDGE_H

#include "tests/support/vt.h"

struct vt_wedge {
    double degrees; /**< between the squares: 180 is no edge */
    double noise;   /**< standard deviation along each axis */
    size_t n;       /**< points of the input */
};

/** wedge->n points, even by area, white noise, moved by Gaussian noise. */
void vt_wedge_make(struct vor_cloud *cloud, const struct vt_wedge *wedge, uint64_t seed);

/** Distance from x to square 0 or 1. */
double vt_wedge_off(const struct vt_wedge *wedge, int square, const double x[3]);

/** Figures of points near the edge, of any number of clouds. All zero before the first cloud. */
struct vt_wedge_seen {
    size_t n, room;
    double *angle;      /**< of each point's normal to its square's, degrees; within a noise of both
                             the smaller one. Allocated with malloc */
    double *off;        /**< to the nearer square. Allocated with malloc */
    size_t smeared;     /**< points whose normal is more than VT_SMEARED_DEGREES from both squares',
                             or that lie farther than two noises off */
    double reach_sum;   /**< from places on the edge to the nearest point */
    size_t reach_count; /**< such places */
};

/** Spacings from the edge within which a point is near it; so far from the edge's ends places and
 *  points are not looked at. */
#define VT_WEDGE_NEAR 2

/** Huang et al. 2013 have no such number: halfway between the normals of a wedge of 120 degrees. */
#define VT_SMEARED_DEGREES 30

/** Spacing of a hexagonal lattice of n points on both squares. */
double vt_wedge_spacing(size_t n);

/** Adds a cloud; a test fails with it where it has no normals. */
void vt_wedge_see(struct vt_wedge_seen *seen, const struct vt_wedge *wedge,
                  const struct vor_cloud *cloud);

/** The value below which a share of n > 0 values lie, 0 <= share < 1; sorts them. */
double vt_quantile(double *value, size_t n, double share);

void vt_wedge_seen_free(struct vt_wedge_seen *seen);

#endif
