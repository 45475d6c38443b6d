/** Prepares an input: finds out everything that is known of it before anything moves. */
#ifndef VOR_INPUT_INPUT_H
#define VOR_INPUT_INPUT_H

#include "core/input/domain.h"
#include "core/spec.h"

/** Makes a domain of a cloud. In this order it checks carried normals that the request says to use
 * and the attribute that it names as density, takes outliers out if the request says so, looks for
 * a lattice and moves the points within its cells if it matters, looks for sheets, chooses the
 * number of neighbours per region unless the request gives one, moves points out of wide noise,
 * puts outliers back that are to be pulled, fills holes if the request says so (input/holes.h),
 * makes lists of neighbours if the request asks for satellites, applies the other filters, and
 * takes islands out, where points are to be spread; then it makes the lists again.
 *
 *  @param[out] out   to be freed with vor_domain_free; untouched on failure
 *  @param[in]  in    checked (vor_cloud_check); borrowed for the call
 *  @param[in]  spec  read: outliers, filters, inputNormals, density, intrinsic, neighbors,
 *                    boundary, holes, holeMax
 *  @param[in]  run   a stop must not interrupt this: pass vor_run_unstoppable
 *
 *  @retval VOR_E_NORMALS    as vor_carried_check
 *  @retval VOR_E_DENSITY, VOR_E_METRIC  as vor_followed_check
 *  @retval VOR_E_HOLES      as vor_holes_fill
 *  @retval VOR_E_DEGENERATE fewer than four distinct points, or all on a line
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *
 *  O(n log n), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_input_prepare(struct vor_domain *out, const struct vor_cloud *in,
                                           const struct vor_spec *spec, const struct vor_run *run,
                                           struct vor_error *err);

#endif
