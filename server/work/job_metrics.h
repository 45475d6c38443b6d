/** What the life of jobs adds to /metrics (server/base/metrics.h). */
#ifndef VOR_SERVER_WORK_JOB_METRICS_H
#define VOR_SERVER_WORK_JOB_METRICS_H

#include "server/store/row.h"

/** An attempt begins, which may take that many bytes of memory. */
void vor_count_begun(const struct vor_job_view *row, uint32_t attempt, size_t memory);

/** It is over, however it ended, after that many seconds. report is NULL unless it was successful
 *  and its process makes one. */
void vor_count_ended(const struct vor_job_view *row, const struct vor_report *report, size_t memory,
                     double seconds);

#endif
