/** Orders points along a Morton curve, so that points near in space are near in memory. */
#ifndef VOR_BASE_MORTON_H
#define VOR_BASE_MORTON_H

#include "core/base/run.h"

#include <stddef.h>
#include <stdint.h>

/** Sorts n >= 1 points (n x 3 floats, all finite) by their Morton codes in a grid of 2^21 cells a
 *  side over their bounding cube. Points with equal codes are sorted by x, y, z, then index, so
 *  that coincident points follow each other, the first one first.
 *
 *  @param[out] order  n: a permutation of 0 .. n - 1
 *
 *  @retval VOR_E_NOMEM 33 n bytes of scratch and a little do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool; O(n log n) where many points share a cell. The same order for any
 *  number of threads. */
VOR_NODISCARD vor_status vor_morton_order(uint32_t *order, const float *xyz, size_t n,
                                          const struct vor_run *run, struct vor_error *err);

/** Computes the Morton code of each point in that grid: code[i] has 63 bits.
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_morton_codes(uint64_t *code, const float *xyz, size_t n,
                                          const struct vor_run *run, struct vor_error *err);

#endif
