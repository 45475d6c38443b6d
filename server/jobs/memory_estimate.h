/** How much memory a job will take, before it runs. */
#ifndef VOR_SERVER_JOBS_MEMORY_ESTIMATE_H
#define VOR_SERVER_JOBS_MEMORY_ESTIMATE_H

#include "server/store/row.h"

/** Bytes at the peak of a run, as estimated from the points of its inputs, those it is to make, and
 *  the method. Where the request gives a spacing, the number of points is known only to the run: as
 *  many as the input has are taken.
 *
 *  @param[in] inputs, input  as struct vor_job_view has them
 *
 *  Beside what runs took: 1 to 2.6 times as much, as noise, which is not seen here, makes fits take
 *  seven times the neighbours; up to 3.5 times for ear on wide noise, and for clean inputs of ten
 *  times the result's points. */
uint64_t vor_memory_estimate(const struct vor_spec *spec, unsigned inputs,
                             const struct vor_job_input input[VOR_INPUTS_MAX]);

#endif
