/** The one door to the engine: a function of (cloud, request, seed). No files, sockets, logs or
 *  globals behind it, nor a clock of its own. */
#ifndef VOR_ENGINE_H
#define VOR_ENGINE_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/report.h"
#include "core/spec.h"

/** Resamples a cloud.
 *
 *  @param[out] out     an initialised, empty cloud; filled only when VOR_OK is returned
 *  @param[out] report  filled only when VOR_OK is returned
 *  @param[in]  in      checked (vor_cloud_check); borrowed for the call
 *  @param[in]  spec    checked (vor_spec_check)
 *  @param[out] err     may be NULL
 *
 *  @retval VOR_E_TARGET     the number of points asked for, or what ratio or spacing come to, is
 * out of range (vor_spec_check_target)
 *  @retval VOR_E_DEGENERATE the cloud has no surface: fewer than four distinct points, or all on a
 * line
 *  @retval VOR_E_NOMEM      the job does not fit under its cap
 *  @retval VOR_E_CANCELLED  the watch answered VOR_CANCEL
 *
 *  Departure: where the input has ten times as many points as asked for, and 40,000, it is thinned
 *  for all but the last iterations or steps: to about five points a seed, 20,000 at least.
 *
 *  Departure: where the input's coordinates were rounded to cells that are not small against its
 *  spacing, its points are first moved within them (input/lattice.h).
 *
 *  Memory: at most 61 bytes for each input point (position, order, index), and for each point of
 *  the result 6 k + 383 (surface, lists, index; k neighbors), twice that while the start is drawn
 *  from cells, that is unless the input has ten times as many points; then 6 k + 492 while
 *  iterating. A progressive order takes 34 instead, after the polish, and a copy of the widest
 *  column. 200 KiB a thread. After the first iteration nothing is allocated but the points' index
 *  when it is made anew, and that order.
 *
 *  Cost: O(N log N) for the index, O(n) an iteration, O(n log n) a progressive order. Thread-safe.
 *  The same bytes for any number of threads, unless a time budget or the caller ended the run. */
VOR_NODISCARD vor_status vor_engine_run(struct vor_cloud *out, struct vor_report *report,
                                        const struct vor_cloud *in, const struct vor_spec *spec,
                                        const struct vor_run *run, struct vor_error *err);

/** Range of a peak that is given. */
#define VOR_PEAK_MIN 1e-30
#define VOR_PEAK_MAX 1e30

/** Measures a cloud, and its distances to a reference where one is given (else NULL). Different
 *  origins are honoured; positions are float32 about the middle of both clouds. D2 needs the
 * reference's normals; those it does not carry are fitted.
 *
 *  @param[in] peak VOR_PEAK_MIN .. VOR_PEAK_MAX, or 0 for the largest distance of a reference point
 *                  to its nearest other one
 *  @retval VOR_E_DEGENERATE fewer than two points, or every point coincides; a reference of fewer
 *                           than seven points or of no extent
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED  as vor_engine_run
 *
 *  Cost: O(n log n). Deterministic for any number of threads. */
VOR_NODISCARD vor_status vor_engine_measure(struct vor_measure *out, const struct vor_cloud *cloud,
                                            const struct vor_cloud *reference, double peak,
                                            const struct vor_run *run, struct vor_error *err);

#endif
