/** Planes through a few points each, to find which of them stands for the surface at a point. */
#ifndef VOR_GEOM_PLANE_H
#define VOR_GEOM_PLANE_H

#include <stdint.h>

/** Points that show the surface around one, itself among them: the first ring and a little of the
 *  second. At 5 / 9 / 18 normals of a sphere with noise of a fifth of the spacing are off by 30 /
 * 10 / 4 degrees (rms), and 3.8 / 5.4 / 7.6 % of those of a cube of 20,000 points by more than 15,
 * at its edges. */
enum { VOR_PLANE_POINTS = 9 };

struct vor_plane {
    float middle[3], normal[3]; /**< a point of it, and a unit vector of either sign */
    float flatness;             /**< variance across it over that in all: 0 .. 1 */
};

/** Fits a plane to the points xyz[3 index[j]], j < k, k >= 1. Cannot fail: points at one place have
 *  a flatness of 1. O(k). */
void vor_plane_fit(struct vor_plane *out, const float *xyz, const uint32_t *index, unsigned k);

/** How badly a plane stands for the surface at x: its flatness, and the square of its distance from
 *  x over r2. O(1). */
double vor_plane_cost(const struct vor_plane *plane, const float x[3], double r2);

#endif
