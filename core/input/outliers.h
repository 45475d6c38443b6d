/** Points of the input that belong to no surface: nothing near them points back to them.
 *
 *  Source: none of the papers. On a surface every point is among the 20 nearest of about 20 others,
 *  at a border of half as many. A point off the surface has 20 nearest too, but they have nearer
 *  ones than it: one that fewer than six others count among theirs is an outlier. What it hid from
 *  is looked at again, twice at most. */
#ifndef VOR_INPUT_OUTLIERS_H
#define VOR_INPUT_OUTLIERS_H

#include "core/input/domain.h"

/** Drops them from the domain; its index is made anew where there were any. Domains of fewer than
 * 200 points have none, and where a quarter of the points would go, no surface is there to judge
 * them by: they stay.
 *
 *  @param[out] dropped  how many
 *
 *  @retval VOR_E_NOMEM 4 n bytes do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the domain is whole or to be freed
 *
 *  O(n log n), 1.5 us a point and look. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_outliers_drop(struct vor_domain *domain, size_t *dropped,
                                           const struct vor_run *run, struct vor_error *err);

#endif
