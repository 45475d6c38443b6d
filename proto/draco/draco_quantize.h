/** How many bits a column of floats needs in a Draco file. */
#ifndef VOR_PROTO_DRACO_QUANTIZE_H
#define VOR_PROTO_DRACO_QUANTIZE_H

#include "core/cloud/cloud.h"
#include "proto/draco/draco_shim.h"

/** Bits of a coordinate of a float normal, and of any other float attribute, where the caller asks
 *  for quantisation at all. */
#define VOR_DRACO_NORMAL_BITS 12
#define VOR_DRACO_SCALAR_BITS 16

/** Auto keeps cells this many times finer than the spacing. */
#define VOR_DRACO_CELLS_PER_SPACING 200

/** Sets low and range of a FLOAT32 column of n points from its values. False, and bits 0, when a
 *  value is not finite or their range is not: such a column can only be stored as it is. */
int vor_draco_bound(struct vor_draco_column *column, size_t n);

/** Chooses bits for an attribute whose low and range are set: where every value is a multiple of
 *  one power of two and few bits reach it (labels stored as floats, say), exactly those, and the
 *  values survive; else VOR_DRACO_NORMAL_BITS or VOR_DRACO_SCALAR_BITS. */
void vor_draco_fit_attribute(struct vor_draco_column *column, size_t n);

/** Chooses bits for the positions of a cloud, a column whose low and range are set: the smallest
 * number whose cells are at most spacing / VOR_DRACO_CELLS_PER_SPACING, and more until no two
 * points that differ fall onto one; 0 (lossless) when 30 bits do not reach that. spacing 0 (not
 * known) counts as range / sqrt(n), the spacing of a plane sheet.
 *
 *  @retval VOR_E_NOMEM the table of points, at most 11 bytes a point, does not fit under the cap
 *
 *  Expected O(n) time for each number of bits tried; the first nearly always does. */
VOR_NODISCARD vor_status vor_draco_fit_positions(struct vor_draco_column *column,
                                                 const struct vor_cloud *cloud, double spacing,
                                                 struct vor_error *err);

#endif
