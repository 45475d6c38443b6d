#include "server/work/job_metrics.h"

#include "server/base/clock.h"
#include "server/base/metrics.h"

void vor_count_begun(const struct vor_job_view *row, uint32_t attempt, size_t memory)
{
    double waited = (double)(vor_clock_wall_ms() - row->created) / 1000;

    vor_metric_add(VOR_METRIC_MEMORY_RESERVED, (double)memory, NULL);
    if (attempt == 1)
        vor_metric_observe(VOR_METRIC_QUEUE_WAIT, waited > 0 ? waited : 0, NULL);
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
    if (report->has_mesh)
        count_stage(row, "mesh", report->mesh_seconds);
    count_stage(row, "write", report->seconds_write);
    vor_metric_observe(VOR_METRIC_JOB_POINTS, (double)report->points_out, VOR_LABELS("out"));
    vor_metric_observe(VOR_METRIC_JOB_ITERATIONS, report->iterations, NULL);
    vor_metric_observe(VOR_METRIC_JOB_DELTA, report->delta, NULL);
    vor_metric_observe(VOR_METRIC_JOB_MEMORY, (double)report->memory_peak_bytes, NULL);
    vor_metric_add(VOR_METRIC_POINTS, (double)report->points_in, NULL);
}
