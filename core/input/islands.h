/** Islands: parts of the input that lie clear of all others and have too few points to show a
 *  surface.
 *
 *  Source: none of the papers; Lv 2022 keeps to one component at a time. A fit around a lone
 *  cluster of a scan reaches over to the scan, so that its cells were as large as the gap is wide:
 *  8 points grew a disc of 159 results. An island gets at most its own points, in the places of
 *  its points; the others are spread on the rest of the input by area.
 *
 *  A part is clear of others by more than CLEAR times vor_domain.sparse (islands.c): gaps as wide
 *  as the input's own do not cut it, and what grows on both sides of such a gap cannot meet. Parts
 *  clear by nine times that are found for certain, nearer ones where the boxes of the index happen
 *  to part them (vor_knn_join). Measured: office1 has 2 parts, an armadillo cut in half 3, autzen,
 *  kitti, scannet, bunny and 20 made clouds 1, and none of them has an island.
 *
 *  A single point is an island, too, where its nearest other point is farther away than CLEAR times
 *  that one's sixth neighbour, and than a sixth neighbour is apart in input and result: the spacing
 *  of the sparsest places of a scan says nothing about the others. 60 lone points 6 to 14 result
 *  spacings from five scans: 7 of them held 3 to 125 results, now none more than itself. So are
 *  few points that are nearer to each other than to points as dense: of 12 lone points around each
 *  of five scans, in two of them one held 46 and 73 results, and of seven in kitti four 24 to 67.
 *
 *  Where all parts are that small there is no surface to spread points on. If no more points are
 *  asked for than the input has, each part gets its share by points, in the places of its points;
 *  else no part can be held to its own points, and all of those asked for are spread on the whole
 *  input, by the area that fits see: of 100 parts of 8 points and 1,600 asked for, 5 to 23 on each,
 *  at most as far from its points as these lie apart. Parts of fewer points than the sixth
 *  neighbour needs are not told apart if there are no others: their gaps are the spacing. */
#ifndef VOR_INPUT_ISLANDS_H
#define VOR_INPUT_ISLANDS_H

#include "core/input/domain.h"
#include "core/input/outliers.h"

/** Looks for islands, parts of fewer than 2 k points (known.neighbors.usual), and takes them out of
 *  the domain: domain->n counts the others, the islands' points come after them in xyz and source.
 *  Where all parts are islands, they stay in. Where the rest would be a line, nothing is taken.
 *  Lists of neighbours (domain->graph) are freed unless all points stay in.
 *
 *  @param[in] target  number of points of the result; NaN or 0: as many as the input has
 *
 *  @retval VOR_E_NOMEM 17 bytes a point, and 24 more for each point of an island, do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED; the domain must be freed after any failure
 *
 *  O(n), 7 ns of CPU a point, on the run's pool; as vor_domain_index if there are islands. The same
 *  islands for any number of threads. */
VOR_NODISCARD vor_status vor_islands_take(struct vor_domain *domain, double target,
                                          const struct vor_run *run, struct vor_error *err);

/** Whether gaps as wide as those around islands can be told in float32, in which the cells of
 * Morton order may be as large. If not, no islands are found. */
int vor_islands_can_be_told(const struct vor_domain *domain);

/** Makes each of one or more points that were taken out an island. vor_islands_take comes before.
 *
 *  @param[in] points  of the domain that it was
 *
 *  @retval VOR_E_NOMEM 24 bytes for each, and the domain's points once more, do not fit
 *  Else fails and costs as vor_domain_index; the domain must be freed after any failure. */
VOR_NODISCARD vor_status vor_islands_add(struct vor_domain *domain,
                                         const struct vor_outliers *points,
                                         const struct vor_run *run, struct vor_error *err);

/** Looks for islands as vor_islands_take, and leaves them in: only known says how many there are.
 *
 *  Fails and costs as vor_islands_take. */
VOR_NODISCARD vor_status vor_islands_count(struct vor_domain *domain, const struct vor_run *run,
                                           struct vor_error *err);

/** Drops parts of fewer than VOR_NEIGHBORS_FEWEST points from the domain, and counts their points
 *  among known.outliers. If more than a quarter of the points would go, all stay.
 *
 *  Fails and costs as vor_islands_take. */
VOR_NODISCARD vor_status vor_islands_drop(struct vor_domain *domain, const struct vor_run *run,
                                          struct vor_error *err);

/** How many of n points the islands get: their share by points, at most their own. Less than n
 *  unless all parts are islands. */
size_t vor_islands_share(const struct vor_domain *domain, size_t n);

/** How many points the islands get where n others are spread on the rest. */
size_t vor_islands_beside(const struct vor_domain *domain, size_t n);

/** Places an island's share of points at some of its own, the one nearest to their mean first, then
 *  the one farthest from those before, and so on.
 *
 *  @param[out] xyz    share x 3, normalised
 *  @param[in]  share  of vor_islands_share
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  On the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_islands_place(float *xyz, const struct vor_domain *domain,
                                           size_t share, const struct vor_run *run,
                                           struct vor_error *err);

/** Puts the islands' points back into the domain, after the others, and indexes it again.
 *  vor_islands_place does not work after that.
 *
 *  Fails and costs as vor_domain_index. */
VOR_NODISCARD vor_status vor_islands_return(struct vor_domain *domain, const struct vor_run *run,
                                            struct vor_error *err);

#endif
