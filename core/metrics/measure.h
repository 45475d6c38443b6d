/** How even a cloud is, and how far from another one: what the process `measure` hands out. */
#ifndef VOR_METRICS_MEASURE_H
#define VOR_METRICS_MEASURE_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/report.h"

/** Measures a cloud, and its distances to a reference where one is given (else NULL). Different
 *  origins are honoured; positions are float32 about the middle of both clouds. D2 needs the
 *  reference's normals; those it does not carry are fitted.
 *
 *  @param[in] peak in the cloud's unit, > 0; or 0 for the largest distance of a reference point to
 *                  its nearest other one
 *  @retval VOR_E_DEGENERATE fewer than two points, or every point coincides; a reference of fewer
 *                           than seven points or of no extent
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED
 *  @retval VOR_E_STOPPED as vor_run_for
 *
 *  Cost: O(n log n). Deterministic for any number of threads. */
VOR_NODISCARD vor_status vor_measure_clouds(struct vor_measure *out, const struct vor_cloud *cloud,
                                            const struct vor_cloud *reference, double peak,
                                            const struct vor_run *run, struct vor_error *err);

#endif
