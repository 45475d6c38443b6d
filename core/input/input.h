/** Everything that is known of the input before anything moves. */
#ifndef VOR_INPUT_INPUT_H
#define VOR_INPUT_INPUT_H

#include "core/input/domain.h"
#include "core/spec.h"

/** Makes a cloud ready, and finds out what it is like: outliers (dropped where the request says
 *  so), a lattice (its points moved within their cells where it matters), sheets, and how many
 *  points a fit takes (the request's number, or chosen region by region).
 *
 *  @param[out] out   to be freed with vor_domain_free; untouched on failure
 *  @param[in]  in    checked (vor_cloud_check); borrowed for the call
 *  @param[in]  spec  read: outliers, neighbors
 *  @param[in]  run   a stop must not cut this short: give it vor_run_unstoppable
 *
 *  @retval VOR_E_DEGENERATE fewer than four distinct points, or all on a line
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  O(n log n). The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_input_prepare(struct vor_domain *out, const struct vor_cloud *in,
                                           const struct vor_spec *spec, const struct vor_run *run,
                                           struct vor_error *err);

#endif
