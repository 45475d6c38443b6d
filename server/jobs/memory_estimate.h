/** How much memory a job will take, before it runs. */
#ifndef VOR_SERVER_JOBS_MEMORY_ESTIMATE_H
#define VOR_SERVER_JOBS_MEMORY_ESTIMATE_H

#include "server/store/row.h"

/** Neighbours of a fit where the request leaves them to the input: 12 to 24 on clean ones, up to
 *  150 where there is noise, as in many scans, which only the run sees. */
enum vor_fit_neighbors { VOR_FIT_CLEAN = 20, VOR_FIT_NOISY = 144 };

/** Bytes at the peak of a run, as estimated from the points of its inputs, those it is to make, and
 *  the method. Where the request gives a spacing, the number of points is known only to the run: as
 *  many as the input has are taken.
 *
 *  @param[in] inputs, input  as struct vor_job_view has them
 *
 *  With VOR_FIT_NOISY, beside what runs took: 1 to 2.6 times as much; up to 3.6 times for ear on
 *  wide noise, and for clean inputs of ten times the result's points. With VOR_FIT_CLEAN what a
 *  run takes at least, nearly: .4 to 1.4 times as much. */
uint64_t vor_memory_estimate(const struct vor_spec *spec, unsigned inputs,
                             const struct vor_job_input input[VOR_INPUTS_MAX],
                             enum vor_fit_neighbors neighbors);

#endif
