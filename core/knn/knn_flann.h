/** FLANN's kd-tree, over points in any order. Behind knn.h only. */
#ifndef VOR_KNN_KNN_FLANN_H
#define VOR_KNN_KNN_FLANN_H

#include "core/base/memory.h"
#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

struct vor_flann;

/** Indexes 1 .. INT32_MAX points (n x 3 floats that square without overflow), which are borrowed.
 *
 *  @retval VOR_E_NOMEM    about 40 n bytes do not fit
 *  @retval VOR_E_INTERNAL the library failed
 *
 *  O(n log n), one thread. Where many points share a place, each place is indexed once. */
VOR_NODISCARD vor_status vor_flann_build(struct vor_flann **out, const float *xyz, size_t n,
                                         struct vor_memory *memory, struct vor_error *err);

/** Frees an index; flann may be NULL. */
void vor_flann_free(struct vor_flann *flann);

/** vor_knn_search, with count k at most INT32_MAX. */
void vor_flann_search(const struct vor_flann *flann, const float *queries, size_t count, unsigned k,
                      uint32_t *index, float *distance2);

#endif
