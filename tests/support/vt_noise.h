/** Noise and outliers along the normals of a cloud, to try denoising with.
 *
 *  Source: Lv et al. 2022, "Intrinsic and isotropic resampling for 3D point clouds", Sec. 6.1:
 *  points moved along their normals by 0 .. 0.33 l and 0 .. 0.66 l, outliers by 3 l .. 6 l, where
 *  l is a point's mean distance to its 6 nearest.
 *  Departure: noise is normally distributed about the surface, with a standard deviation of 0.33 l
 *  or 0.66 l, and outliers lie on both sides. Noise to one side alone is an offset of the surface,
 *  which no smoother can take back. */
#ifndef VT_NOISE_H
#define VT_NOISE_H

#include "tests/support/vt.h"

/** The paper's two levels of noise, in l, and its share of outliers. */
#define VT_NOISE_LOW 0.33
#define VT_NOISE_HIGH 0.66
#define VT_NOISE_OUTLIERS 0.05

/** A normal for each point, n x 3, from the plane through its 20 nearest; the signs are arbitrary.
 */
void vt_noise_normals(double *normal, const struct vor_cloud *cloud);

/** Moves each point along its normal by a normally distributed length of mean 0 and standard
 *  deviation `deviation` l, l and the normals being those of the cloud before. */
void vt_noise_add(struct vor_cloud *cloud, uint64_t seed, double deviation);

/** Moves floor(share n) points, chosen at random, along their normals by 3 l .. 6 l to one side or
 *  the other. moved, n, gets 1 for those and 0 for the others. */
void vt_noise_outliers(unsigned char *moved, struct vor_cloud *cloud, uint64_t seed, double share);

#endif
