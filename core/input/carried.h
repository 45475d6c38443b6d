/** The normals that an input carries. */
#ifndef VOR_INPUT_CARRIED_H
#define VOR_INPUT_CARRIED_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/spec.h"

/** The first NORMAL of three components or more; NULL when there is none. */
const struct vor_attribute *vor_carried(const struct vor_cloud *in);

/** Reads carried normal i. Returns whether it has a direction: it is finite and not zero. */
int vor_carried_normal(const struct vor_attribute *carried, size_t i, double normal[3]);

/** Counts the normals that have no direction.
 *
 *  @param[out] bad    how many of the n there are
 *  @param[out] first  index of the first one; n if there is none
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_carried_count(size_t *bad, size_t *first,
                                           const struct vor_attribute *carried, size_t n,
                                           const struct vor_run *run, struct vor_error *err);

/** If the request says inputNormals=use, checks that every point carries a normal with a direction.
 *
 *  @retval VOR_E_NORMALS otherwise; the message has the count and the first index
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED */
VOR_NODISCARD vor_status vor_carried_check(const struct vor_cloud *in, const struct vor_spec *spec,
                                           const struct vor_run *run, struct vor_error *err);

#endif
