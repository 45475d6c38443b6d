/** Tensors that the input carries, one at each point. */
#ifndef VOR_INPUT_CARRIED_TENSORS_H
#define VOR_INPUT_CARRIED_TENSORS_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"

/** Where they are: one attribute of six components, or six of one, xx xy xz yy yz zz; borrowed from
 *  the cloud. */
struct vor_carried_tensors {
    const struct vor_attribute *attribute[6]; /**< all the same where it has six components */
};

/** Finds those of that name: an attribute NAME of six components, else scalars NAME_xx, NAME_xy,
 *  NAME_xz, NAME_yy, NAME_yz and NAME_zz. Returns whether they are there. */
int vor_carried_tensors_find(struct vor_carried_tensors *out, const struct vor_cloud *in,
                             const char *name);

/** The tensor at point i. */
void vor_carried_tensors_at(double tensor[6], const struct vor_carried_tensors *tensors, size_t i);

/** Checks that there are tensors of that name, and that they are finite and positive definite.
 *
 *  @retval VOR_E_METRIC  they are not; the message has the names of the tensors there, or the first
 *                        point at fault
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_carried_tensors_check(const struct vor_cloud *in, const char *name,
                                                   const struct vor_run *run,
                                                   struct vor_error *err);

#endif
