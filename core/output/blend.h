/** Colours of points that lie between those of an input: means of the colours around them.
 *
 *  Source: Shepard 1968, "A two-dimensional interpolation function for irregularly-spaced data",
 *  with six points. PSNR of the colours in dB (YUV, tests/by_hand/bench/codec.py) of a quarter of
 *  the points, coded by Draco at 7 / 9 bits and upsampled to all by method=insert. The quarter
 *  alone: scannet 22.4 / 22.6, office1 28.2 / 28.7, autzen 32.3 / 34.2. With the colour of the
 *  nearest point: 22.2 / 22.6, 27.5 / 28.6, 30.5 / 34.1. With means of 3 / 6 / 10 points at 9 bits:
 *  23.3 / 23.6 / 23.7, 29.1 / 29.3 / 29.4, 34.7 / 35.0 / 35.1; by method=cvt 23.3 / 23.6 / 23.6,
 *  28.2 / 28.4 / 28.5, 35.1 / 35.1 / 34.8. Where 60 % of the points coincide (autzen at 7 bits),
 *  those of each place's first point alone come to 32.1, their means to 33.4. */
#ifndef VOR_OUTPUT_BLEND_H
#define VOR_OUTPUT_BLEND_H

#include "core/seeds/seeds.h"

/** Gives seeds new colours; those of coincident input points count as their mean.
 *
 *  @param[in,out] out    the cloud of the seeds (vor_transfer), with all attributes
 *  @param[in]     first  points of out before those of the seeds, which keep their colours
 *  @param[in]     in     the cloud that the domain was made of
 *  @param[in]     seeds  each fitted where it is, unless the run is late
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  O(n), on the run's pool. Nothing where there are no colours. */
VOR_NODISCARD vor_status vor_blend(struct vor_cloud *out, size_t first, const struct vor_cloud *in,
                                   const struct vor_seeds *seeds, struct vor_error *err);

#endif
