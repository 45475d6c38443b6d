#include "server/work/counted.h"

#include "server/base/clock.h"
#include "server/base/metrics.h"

#include <unistd.h>

void vor_count_accepted(const struct vor_job_view *row)
{
    vor_metric_add(VOR_METRIC_JOBS_ACCEPTED, 1, VOR_LABELS(row->process));
    vor_metric_observe(VOR_METRIC_JOB_POINTS, (double)row->input[0].points, VOR_LABELS("in"));
}

void vor_count_begun(const struct vor_job_view *row, uint32_t attempt, size_t memory)
{
    double waited = (double)(vor_clock_wall_ms() - row->created) / 1000;

    vor_metric_add(VOR_METRIC_MEMORY_RESERVED, (double)memory, NULL);
    if (attempt == 1)
        vor_metric_observe(VOR_METRIC_QUEUE_WAIT, waited > 0 ? waited : 0, NULL);
}

void vor_count_again(void)
{
    vor_metric_add(VOR_METRIC_JOBS_AGAIN, 1, VOR_LABELS("worker"));
}

static void count_stage(const struct vor_job_view *row, const char *stage, double seconds)
{
    vor_metric_observe(VOR_METRIC_JOB_SECONDS, seconds, VOR_LABELS(row->process, stage));
}

void vor_count_ended(const struct vor_job_view *row, const struct vor_report *report, size_t memory,
                     double seconds)
{
    vor_metric_add(VOR_METRIC_MEMORY_RESERVED, -(double)memory, NULL);
    count_stage(row, "all", seconds);
    if (report == NULL)
        return;
    count_stage(row, "read", report->seconds_read);
    count_stage(row, "index", report->seconds_index);
    count_stage(row, "init", report->seconds_init);
    for (unsigned i = 0; i < report->stages_count; i++)
        count_stage(row, vor_run_stage_info(report->stages[i].stage)->name,
                    report->stages[i].seconds);
    count_stage(row, "write", report->seconds_write);
    vor_metric_observe(VOR_METRIC_JOB_POINTS, (double)report->points_out, VOR_LABELS("out"));
    vor_metric_observe(VOR_METRIC_JOB_ITERATIONS, report->iterations, NULL);
    vor_metric_observe(VOR_METRIC_JOB_DELTA, report->delta, NULL);
    vor_metric_observe(VOR_METRIC_JOB_MEMORY, (double)report->memory_peak_bytes, NULL);
    vor_metric_add(VOR_METRIC_POINTS, (double)report->points_in, NULL);
}

void vor_count_undecodable(int fd, vor_status status)
{
    uint8_t magic[16];
    ssize_t size = pread(fd, magic, sizeof magic, 0);
    const struct vor_format *format = size > 0 ? vor_format_sniff(magic, (size_t)size) : NULL;

    vor_metric_add(VOR_METRIC_DECODE_ERRORS, 1,
                   VOR_LABELS(format != NULL ? format->name : "none", vor_status_slug(status)));
}
