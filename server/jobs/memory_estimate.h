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
 *  Beside what runs took (memory_estimate.c): 0.9 to 2 times as much, 1.5 at most where the input
 * is not much larger than the result; inspect and denoise, which noise makes dearer, 0.9 to 2.4.
 * Other runs on noise may take twice as much. */
uint64_t vor_memory_estimate(const struct vor_spec *spec, unsigned inputs,
                             const struct vor_job_input input[VOR_INPUTS_MAX]);

#endif
