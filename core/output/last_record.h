/** The record of what a run hands back. */
#ifndef VOR_OUTPUT_LAST_RECORD_H
#define VOR_OUTPUT_LAST_RECORD_H

#include "core/base/run.h"
#include "core/seeds/outcome.h"

/** Tells the watch of a run what is handed back, where the last record does not say so: points that
 *  were outside the input have moved since, islands have joined them, or a stop came between two
 *  records. After this, best of the last record is what the report says. Tells nothing where the
 *  method told nothing, or filters alone made the result.
 *
 *  @param[in] told    by the method
 *  @param[in] report  of the result: delta, sigma, epsilon, iterations, polish_steps
 *  @param[in] run     may be stopped: there is nothing left to stop
 *
 *  @retval VOR_E_CANCELLED the watch answered VOR_CANCEL */
VOR_NODISCARD vor_status vor_last_record_tell(const struct vor_outcome *told,
                                              const struct vor_report *report,
                                              const struct vor_run *run, struct vor_error *err);

/** That record, but for its seconds, which are those of the method's last one. */
struct vor_record vor_last_record(const struct vor_outcome *told, const struct vor_report *report);

#endif
