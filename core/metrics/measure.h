/** Measures how even a cloud is, and how far from another one: what the process `measure` hands
 *  out. */
#ifndef VOR_METRICS_MEASURE_H
#define VOR_METRICS_MEASURE_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/report.h"

/** Measures a cloud, and its distances to a reference unless that is NULL. The clouds may have
 *  different origins; positions are compared in float32 about the middle of both. D2 uses the
 *  reference's normals; those that it does not carry are fitted.
 *
 *  @param[out] out written only when VOR_OK is returned
 *  @param[in] peak in the cloud's unit, > 0; or 0 for the largest distance of a reference point to
 *                  its nearest other one
 *  @retval VOR_E_DEGENERATE fewer than two points, or every point coincides; a reference of fewer
 *                           than seven points or of no extent
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *  @retval VOR_E_STOPPED as vor_run_for
 *
 *  O(n log n), on the run's pool. The same bits for any number of threads. */
VOR_NODISCARD vor_status vor_measure_clouds(struct vor_measure *out, const struct vor_cloud *cloud,
                                            const struct vor_cloud *reference, double peak,
                                            const struct vor_run *run, struct vor_error *err);

#endif
