/** Oriented samples of simple shapes, as the insertion takes them. */
#ifndef VT_LOP_H
#define VT_LOP_H

#include "core/lop/samples.h"
#include "tests/support/vt.h"

/** Two rectangles of side 1 by 1/2 that meet at an edge along y, at x = z = 0, with `degrees`
 *  between them: about n samples, jittered, none within half a spacing of the edge. *spacing gets
 *  their mean distance. */
void vt_lop_wedge(struct vor_lop_samples *out, double degrees, size_t n, uint64_t seed,
                  double *spacing);

/** The unit normals of the two sides. */
void vt_lop_wedge_normals(double degrees, double out[2][3]);

/** The surface of a cube of side 1.2, with samples that keep away from its edges. */
void vt_lop_cube(struct vor_lop_samples *out, size_t n, uint64_t seed, double *spacing);

/** n samples of a sphere of radius 0.9, about evenly spread. */
void vt_lop_sphere(struct vor_lop_samples *out, size_t n, double *spacing);

/** A square of side 1 at height z that faces up or down (1, -1), without the samples within
 *  `hole` of its middle; appended to samples that vor_lop_samples_init made. */
void vt_lop_square(struct vor_lop_samples *out, size_t side, double z, double facing, double hole,
                   uint64_t seed);

#endif
