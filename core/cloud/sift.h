/** Points that are not finite: refused, or left out. */
#ifndef VOR_CLOUD_SIFT_H
#define VOR_CLOUD_SIFT_H

#include "core/cloud/cloud.h"

/** Looks for points with a coordinate that is not finite, once all their values are read. If they
 *  are to be dropped, the others close up, with their attributes and in their order, triangles that
 *  have such a corner go, and the cloud's notes count the points.
 *
 *  @param[in,out] cloud    positions and attributes; the positions are not looked at if wide is not
 *                          NULL
 *  @param[in,out] wide     NULL, or the cloud's n x 3 coordinates that vor_cloud_set_double will
 *                          get; they close up as well
 *  @param[in]     is_drop  drop them
 *
 *  @retval VOR_E_NONFINITE there are some, and is_drop is 0: the message says how many, which one
 * is the first, and the parameter that drops them
 *  @retval VOR_E_EMPTY     all would be dropped
 *  @retval VOR_E_NOMEM     4 bytes a point do not fit; only of a cloud with triangles
 *
 *  O(n); memory only for triangles. */
VOR_NODISCARD vor_status vor_cloud_sift(struct vor_cloud *cloud, double *wide, int is_drop,
                                        struct vor_error *err);

#endif
