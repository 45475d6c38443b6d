/** The twin of core/knn/knn.h that computes every distance. */
#ifndef VT_KNN_H
#define VT_KNN_H

#include <stddef.h>
#include <stdint.h>

/** As vor_knn_search over the n points xyz, 1 <= k <= n; points at equal distance come by index.
 *  O(count n k). */
void vt_knn_brute(const float *xyz, size_t n, const float *queries, size_t count, unsigned k,
                  uint32_t *index, float *distance2);

#endif
