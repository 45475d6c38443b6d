/** Orders points along a Morton curve, so that points near in space are near in memory. */
#ifndef VOR_BASE_MORTON_H
#define VOR_BASE_MORTON_H

#include "core/base/run.h"

#include <stddef.h>
#include <stdint.h>

/** order[] gets 0 .. n - 1 (n >= 1) sorted by the Morton code of the points (n x 3 floats, all
 *  finite) in a grid of 2^21 cells a side over their bounding cube; equal codes by x, y, z, then
 *  index, so that coincident points follow each other, first one first. Deterministic. O(n), on the
 *  run's pool; O(n log n) where many points share a cell.
 *
 *  @retval VOR_E_NOMEM 33 n bytes of scratch and a little do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED */
VOR_NODISCARD vor_status vor_morton_order(uint32_t *order, const float *xyz, size_t n,
                                          const struct vor_run *run, struct vor_error *err);

/** code[i] gets the Morton code of point i in that grid: 63 bits, ascending in that order. O(n), on
 *  the run's pool.
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED */
VOR_NODISCARD vor_status vor_morton_codes(uint64_t *code, const float *xyz, size_t n,
                                          const struct vor_run *run, struct vor_error *err);

#endif
