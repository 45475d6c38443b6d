/** Drops outliers: input points that belong to no surface.
 *
 *  Source: none of the papers; Lv 2022 Sec. 3.1 tests for neighbours that are not mutual. On a
 *  surface every point is among the 20 nearest of about 20 others, at a border of half as many. The
 *  20 nearest of a point off the surface have other points nearer to them. A point that is among
 *  the 20 nearest of fewer than six others is an outlier. What is left is searched again, at most
 *  twice, because outliers near each other hide one another. */
#ifndef VOR_INPUT_OUTLIERS_H
#define VOR_INPUT_OUTLIERS_H

#include "core/input/domain.h"

/** Drops the outliers from the domain, and indexes it again if there were any. A domain of fewer
 *  than 200 points has none. If more than a quarter of the points would go, they show no surface to
 *  judge them by, and all stay.
 *
 *  @param[out] dropped  how many points
 *
 *  @retval VOR_E_NOMEM 4 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the domain is as it was, or must be
 *          freed
 *
 *  O(n log n), 1.5 us a point and search, on the run's pool. The same points for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_outliers_drop(struct vor_domain *domain, size_t *dropped,
                                           const struct vor_run *run, struct vor_error *err);

#endif
