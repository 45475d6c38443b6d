/** How long a job will run, before it is accepted. */
#ifndef VOR_SERVER_JOBS_TIME_ESTIMATE_H
#define VOR_SERVER_JOBS_TIME_ESTIMATE_H

#include "core/base/status.h"
#include "core/spec.h"

/** Seconds that a run takes which stops no earlier than the request says, by `threads` threads of
 *  the machine that time_estimate.c was measured on; at most as many as the request allows. 0 where
 * that is not known: for processes without a method, and where only the run knows how many points
 * it is to make.
 *
 *  @param[in] points  of the input */
double vor_time_estimate(const struct vor_spec *spec, uint64_t points, unsigned threads);

/** Refuses a job that would run far longer than `limit` seconds: VOR_TIME_ESTIMATE_FAR times as
 * long, because the estimate may be wrong by half of that, and runs often stop earlier.
 *
 *  @param[in] limit  seconds; 0 for none
 *
 *  Refuses likewise a request whose own time is over by VOR_TIME_ESTIMATE_FAR times, and
 * VOR_TIME_ESTIMATE_SPARE seconds, before so many points are placed alone.
 *
 *  @retval VOR_E_WORK  err: the estimate, the limit, and what takes so long */
#define VOR_TIME_ESTIMATE_FAR 4.0
#define VOR_TIME_ESTIMATE_SPARE 10.0
VOR_NODISCARD vor_status vor_time_estimate_check(const struct vor_spec *spec, uint64_t points,
                                                 unsigned threads, double limit,
                                                 struct vor_error *err);

#endif
