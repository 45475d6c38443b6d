/** The box around many points. */
#ifndef VOR_BASE_BOUNDS_H
#define VOR_BASE_BOUNDS_H

#include "core/base/run.h"

#include <stddef.h>

/** A box along the axes: both bounds belong to it. */
struct vor_box {
    float low[3], high[3];
};

/** Computes the smallest box that holds n >= 1 points (n x 3 floats, all finite).
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_bounds(struct vor_box *out, const float *xyz, size_t n,
                                    const struct vor_run *run, struct vor_error *err);

#endif
