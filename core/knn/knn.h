/** Nearest neighbours among a fixed set of points. */
#ifndef VOR_KNN_KNN_H
#define VOR_KNN_KNN_H

#include "core/base/run.h"

#include <stddef.h>
#include <stdint.h>

struct vor_knn;

/** Indexes n points.
 *
 *  @param[out] out  free with vor_knn_free
 *  @param[in]  xyz  n x 3 floats, each of magnitude at most 1e6; must stay as it is while the index
 *                   lives
 *
 *  @retval VOR_E_EMPTY     n is 0
 *  @retval VOR_E_NONFINITE a coordinate is not finite or too large
 *  @retval VOR_E_NOMEM     the index (about 40 n bytes) does not fit
 *
 *  O(n log n), one thread. Searches are thread-safe. The same points give the same answers. */
VOR_NODISCARD vor_status vor_knn_build(struct vor_knn **out, const float *xyz, size_t n,
                                       struct vor_memory *memory, struct vor_error *err);

/** The same for points in Morton order, by a tree of boxes: built several times as fast and by all
 *  threads of the run's pool, and one query at a time is 1.2 to 2 times as fast. Any other order
 * gives the same distances, slowly. xyz is copied. The same answers for any number of threads.
 *
 *  @retval VOR_E_NOMEM the index (about 20 n bytes, and 8 n while it is built) does not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED, and those of vor_knn_build */
VOR_NODISCARD vor_status vor_knn_build_sorted(struct vor_knn **out, const float *xyz, size_t n,
                                              const struct vor_run *run, struct vor_error *err);

/** knn may be NULL. */
void vor_knn_free(struct vor_knn *knn);

/** The k nearest points of each of count queries, nearest first; a query that is itself one of the
 *  points finds itself. k is 1 .. n (more is the caller's bug), queries are at most 1e15.
 *
 *  @param[out] index      count x k
 *  @param[out] distance2  count x k, squared
 *
 *  O(count k log n), however many points coincide. Points at equal distance come in an order that
 * is fixed but unspecified. Where queries near in space follow each other (Morton order) it is more
 *  than twice as fast. */
void vor_knn_search(const struct vor_knn *knn, const float *queries, size_t count, unsigned k,
                    uint32_t *index, float *distance2);

/** The same by looking at every point, equal distances by index: the oracle of the tests. */
void vor_knn_brute(const float *xyz, size_t n, const float *queries, size_t count, unsigned k,
                   uint32_t *index, float *distance2);

#endif
