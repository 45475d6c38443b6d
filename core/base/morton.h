/** Orders points along a Morton curve, so that points near in space are near in memory. */
#ifndef VOR_BASE_MORTON_H
#define VOR_BASE_MORTON_H

#include "core/base/run.h"

#include <stddef.h>
#include <stdint.h>

/** What is sorted: n >= 1 points (n x 3 floats, all finite), each as (x - shift) * scale, computed
 *  in double precision; scale > 0. */
struct vor_morton_input {
    const float *xyz;
    size_t n;
    double shift[3], scale;
};

/** Sorts points by their Morton codes in a grid of 2^21 cells a side over their bounding cube.
 *  Points with equal codes are sorted by x, y, z, then index, so that coincident points follow each
 *  other, the first one first.
 *
 *  @param[out] sorted  n x 3: the points
 *  @param[out] order   n: where each was, a permutation of 0 .. n - 1
 *
 *  @retval VOR_E_NOMEM 4.5 n bytes of scratch and some do not fit; 36 n up to 16,384 points; up to
 *                      52 n where most points are close together against the extent
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool; O(n log n) where many points share a cell. The same order for any
 *  number of threads. */
VOR_NODISCARD vor_status vor_morton_sort(float *sorted, uint32_t *order,
                                         const struct vor_morton_input *in,
                                         const struct vor_run *run, struct vor_error *err);

/** Only the order, with 12 n bytes more. */
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
