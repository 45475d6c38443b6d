/** What a triangle is like, and axes to look at one from its corners. */
#ifndef VOR_MESH_QUALITY_H
#define VOR_MESH_QUALITY_H

#include "core/geom/surface.h"

#include <stdint.h>

/** Axes at a point: two in its tangent plane, and its normal. */
struct vor_frame {
    double axis[3][3];
};

/** Axes for a unit normal; the first two point anywhere. */
void vor_frame_of(struct vor_frame *out, const float normal[3]);

/** Q_t = 6 / sqrt(3) S / (p h) of a triangle of area S, half the perimeter p and longest edge h: 1
 *  where it is equilateral, 0 where it has no area. Frey and Borouchaki 1999, "Surface mesh quality
 *  evaluation". */
double vor_triangle_quality(const float *xyz, const uint32_t corner[3]);

/** How far a triangle is from equilateral: the sum of its squared edges over that of an equilateral
 *  one of its area. 1 or more; infinite without area. Smooth, unlike Q_t. Field 2000, "Qualitative
 *  measures for initial meshes". */
double vor_triangle_strain(const float *xyz, const uint32_t corner[3]);

/** The normal of a triangle, twice as long as its area is large. */
void vor_triangle_normal(double out[3], const float *xyz, const uint32_t corner[3]);

/** The same of unit length. Returns whether it has an area. */
int vor_triangle_unit_normal(double out[3], const float *xyz, const uint32_t corner[3]);

/** Cosine of the smallest angle of a triangle; 1 where two corners coincide. */
double vor_triangle_sharpest(const float *xyz, const uint32_t corner[3]);

#endif
