/** Nearest neighbours among a fixed set of points. */
#ifndef VOR_KNN_KNN_H
#define VOR_KNN_KNN_H

#include "core/base/run.h"
#include "core/knn/knn_near.h"

#include <stddef.h>
#include <stdint.h>

struct vor_knn;

/** Indexes n points in any order, by FLANN's kd-tree.
 *
 *  @param[out] out  free with vor_knn_free
 *  @param[in]  xyz  n x 3 floats, each of magnitude at most 1e15; must stay as it is while the
 * index lives
 *
 *  @retval VOR_E_EMPTY     n is 0
 *  @retval VOR_E_NONFINITE a coordinate is not finite or too large
 *  @retval VOR_E_NOMEM     the index (about 40 n bytes) does not fit
 *
 *  O(n log n), one thread. The same points give the same answers. */
VOR_NODISCARD vor_status vor_knn_build(struct vor_knn **out, const float *xyz, size_t n,
                                       struct vor_memory *memory, struct vor_error *err);

/** Indexes n points in Morton order, by a tree of boxes; xyz is borrowed and must stay as it is.
 *  Another order gives the same distances, slowly.
 *
 *  Why an index of our own beside FLANN: the input is in Morton order anyway, and is searched for
 *  one seed at a time. Measured over 5 million such points on one core (medians of three): built in
 *  0.42 s, FLANN 1.14 s; one query 0.69 us against 1.62 (k = 1), 2.1 against 3.9 (k = 20), 3.1
 *  against 4.9 (k = 32), 16 against 20 (k = 150); in calls of 250 queries 2.2 against 2.6 (k = 20).
 *  Points in any order that are searched for once stay with FLANN, which needs no sorting.
 *
 *  @retval VOR_E_NOMEM the index (about 9 n bytes, and 8 n while it is built) does not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED, and those of vor_knn_build
 *
 *  O(n), on the run's pool. The same answers for any number of threads. */
VOR_NODISCARD vor_status vor_knn_build_sorted(struct vor_knn **out, const float *xyz, size_t n,
                                              const struct vor_run *run, struct vor_error *err);

/** The same for points in any order, which are sorted first. vor_knn_order then tells how: searches
 *  for the points themselves go along it.
 *
 *  @retval VOR_E_NOMEM what vor_morton_sort and vor_knn_build_sorted take, and 16 n bytes, do not
 *                      fit; 24 n stay
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED, and those of vor_knn_build */
VOR_NODISCARD vor_status vor_knn_build_along(struct vor_knn **out, const float *xyz, size_t n,
                                             const struct vor_run *run, struct vor_error *err);

/** The points in Morton order, n of them, of an index made by vor_knn_build_along. */
const uint32_t *vor_knn_order(const struct vor_knn *knn);

/** Frees an index; knn may be NULL. */
void vor_knn_free(struct vor_knn *knn);

/** Finds the k nearest points of each of count queries, nearest first. A query that is one of the
 *  points finds itself.
 *
 *  @param[in]  queries    count x 3 floats, each of magnitude at most 1e15
 *  @param[in]  k          1 .. n; anything else is the caller's bug
 *  @param[out] index      count x k
 *  @param[out] distance2  count x k, squared
 *
 *  Cannot fail; thread-safe. O(count k log n), however many points coincide, and more than twice as
 *  fast if queries near in space follow each other. Points at equal distance come in an order that
 *  is fixed but unspecified. */
void vor_knn_search(const struct vor_knn *knn, const float *queries, size_t count, unsigned k,
                    uint32_t *index, float *distance2);

/** What the last search of a row found. k is 0 before the first; one for each thread. */
struct vor_knn_last {
    float at[3]; /**< the query */
    float far;   /**< from there to the last of its k points */
    unsigned k;
};

/** vor_knn_search for the next query of a row, in the same index, near the last one. The points
 *  found for that are no farther from this one than from that and as far as the two are apart: no
 *  point beyond is looked at. The same answers, ties and all.
 *
 *  Of 20 nearest, in Morton order, 1.87 us where each alone takes 2.2 (222,543 points with noise),
 *  1.74 for 1.97 (scannet). Queries far from each other, or for more points than the last, take as
 *  long as alone. vor_knn_search of several queries does the same. */
void vor_knn_search_next(const struct vor_knn *knn, struct vor_knn_last *last, const float query[3],
                         unsigned k, uint32_t *index, float *distance2);

/** vor_knn_search for queries that are all near each other, as successive points in Morton order
 *  are: one walk of the boxes finds the points around all of them. Where there are too many of
 * these, halves of the queries are searched for; by FLANN each alone. Of points that are equally
 * far, as on a lattice, it takes the first ones in the index, where a search alone takes those it
 * meets first. */
void vor_knn_search_near(const struct vor_knn *knn, struct vor_knn_near *near, uint32_t *index,
                         float *distance2);

/** Finds the parts of a cloud that are clear of each other. Points within `distance` of each other
 *  are in one part. So are the points of a box of the tree at most four distances wide, and those
 *  of two such boxes within a distance: parts clear of all others by nine distances are told apart
 *  for certain, nearer ones where the boxes happen to. Only for an index of sorted points.
 *
 *  Source: "friends of friends" (Huchra and Geller 1982), by a walk over pairs of boxes. Departure:
 *  narrow boxes are taken as a whole, which takes a sixth of the time (WIDTH in knn_join.c).
 *
 *  @param[out] root      n: the smallest index of each point's part; unset if *parts is 1
 *  @param[out] parts     how many there are
 *  @param[in]  distance  > 0, and not small against the cells of Morton order: else it takes O(n^2)
 *
 *  @retval VOR_E_NOMEM a third of n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n); on the run's pool, the last step on one thread. The same parts for any number of threads.
 */
VOR_NODISCARD vor_status vor_knn_join(uint32_t *root, size_t *parts, const struct vor_knn *knn,
                                      double distance, const struct vor_run *run,
                                      struct vor_error *err);

#endif
