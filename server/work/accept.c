/* Taking in new jobs. */
#include "proto/codec.h"
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/jobs/cost.h"
#include "server/jobs/need.h"
#include "server/work/counted.h"
#include "server/work/live.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* Likewise what could never run: row has its inputs. A run never has more memory than its cap. */
static vor_status check_need(const struct vor_worker *worker, struct vor_job_view *row,
                             struct vor_error *err)
{
    uint64_t need = vor_need_bytes(&row->spec, row->inputs, row->input),
             budget = worker->config.budget;

    row->memory = need < worker->config.memory ? need : worker->config.memory;
    if (need <= budget)
        return VOR_OK;
    (void)vor_fail(err, VOR_E_NOMEM,
                   "the job needs about %llu bytes of memory, but all jobs together may use "
                   "only %llu",
                   (unsigned long long)need, (unsigned long long)budget);
    return vor_fail_over(err, VOR_E_NOMEM, budget, need);
}

/* Likewise; row has its inputs and its format. */
static vor_status check_origin(const struct vor_job_view *row, const struct vor_admitted *admitted,
                               struct vor_error *err)
{
    const struct vor_process_info *process = row->spec.process;

    if (!vor_process_takes(process, VOR_PARAM_FORMAT))
        return VOR_OK;
    for (unsigned i = 0; i < admitted->count; i++)
        if (strcmp(admitted->item[i].name, process->inputs[0].name) == 0)
            return vor_write_check(vor_format((unsigned)row->spec.value[VOR_PARAM_FORMAT]),
                                   &row->spec, &admitted->item[i].extent, err);
    return VOR_OK;
}

static void first_row(struct vor_job_view *row, const struct vor_uuid *id,
                      const struct vor_spec *spec, const struct vor_job_label *label)
{
    *row = (struct vor_job_view){.id = *id,
                                 .status = VOR_JOB_ACCEPTED,
                                 .stage = VOR_STAGE_QUEUED,
                                 .attempt = 1,
                                 .queue_position = -1,
                                 .eta_seconds = -1,
                                 .spec = *spec,
                                 .build = vor_build_own(),
                                 .created = vor_clock_wall_ms()};
    (void)snprintf(row->process, sizeof row->process, "%s", spec->process->id);
    row->updated = row->created;
    row->problem.byte_offset = -1;
    if (label != NULL && label->name != NULL)
        (void)snprintf(row->name, sizeof row->name, "%s", label->name);
    if (label != NULL && label->key != NULL)
        row->key = *label->key;
    if (label != NULL && label->span != NULL)
        row->span = *label->span;
}

/* Puts the inputs into their places in the row. */
static vor_status take_inputs(struct vor_job_view *row, const struct vor_admitted *admitted,
                              struct vor_error *err)
{
    const struct vor_process_info *process = row->spec.process;
    vor_status status;

    for (unsigned i = 0; i < admitted->count; i++) {
        const char *name = admitted->item[i].name;
        const struct vor_artefact_info *info = vor_artefact_find(process->inputs, name);

        if (info == NULL)
            return vor_fail_param(err, VOR_E_PARAM, name, "the process %s has no input %s",
                                  process->id, name);
        row->inputs |= 1u << (info - process->inputs);
        row->input[info - process->inputs] = admitted->item[i].found;
        row->kept += admitted->item[i].is_kept ? admitted->item[i].found.bytes : 0;
    }
    status = vor_spec_check_inputs(&row->spec, row->inputs, err);
    if (status == VOR_OK && vor_process_takes(process, VOR_PARAM_FORMAT) &&
        !vor_spec_given(&row->spec, VOR_PARAM_FORMAT))
        row->spec.value[VOR_PARAM_FORMAT] = row->input[0].format;
    return status;
}

/* Bytes of decoded inputs that would never fit into the queue are no reason to come back later. */
static vor_status check_bytes(struct vor_worker *worker, const struct vor_admitted *admitted,
                              struct vor_job_view *row, struct vor_error *err)
{
    uint64_t most = worker->config.queue_bytes;

    for (unsigned i = 0; i < admitted->count; i++)
        row->decoded += admitted->item[i].decoded;
    if (row->decoded <= most)
        return VOR_OK;
    (void)vor_fail(err, VOR_E_BYTES, "the decoded inputs have %llu bytes, want at most %llu",
                   (unsigned long long)row->decoded, (unsigned long long)most);
    return vor_fail_over(err, VOR_E_BYTES, most, row->decoded);
}

/* For a job that has a place in the queue, and keeps it when VOR_DONE is returned. */
static enum vor_job_outcome submit(struct vor_worker *worker, struct vor_job_view *row,
                                   const struct vor_job_label *label, struct vor_error *err)
{
    struct vor_ledger ledger = {.jobs_max = label != NULL ? label->jobs_max : 0,
                                .bytes_max = label != NULL ? label->bytes_max : 0};
    const char *tenant = row->key.principal;
    enum vor_job_outcome outcome;

    if (atomic_load(&worker->is_late)) {
        (void)vor_fail_errno(err, ENOSPC, "recovering earlier jobs");
        return VOR_FAILED;
    }
    outcome = vor_capacity_insert(worker, row, &ledger, err);
    if (outcome != VOR_DONE)
        return outcome;
    vor_count_accepted(row);
    vor_log(VOR_LOG_INFO, "job accepted", VOR_OF_JOB(row),
            VOR_TEXT("tenant", tenant[0] != '\0' ? tenant : NULL),
            VOR_TEXT("process", row->process), VOR_COUNT("points", row->input[0].points),
            VOR_COUNT("bytes", row->input[0].bytes));
    return VOR_DONE;
}

enum vor_job_outcome vor_worker_submit(struct vor_worker *worker,
                                       const struct vor_admitted *admitted,
                                       const struct vor_spec *spec,
                                       const struct vor_job_label *label, struct vor_job_view *out,
                                       struct vor_error *err)
{
    enum vor_job_outcome outcome = VOR_FAILED;
    int booked = label != NULL && label->booked;
    struct vor_job_view row;

    first_row(&row, &admitted->id, spec, label);
    if (take_inputs(&row, admitted, err) == VOR_OK &&
        check_bytes(worker, admitted, &row, err) == VOR_OK &&
        (vor_spec_given(spec, VOR_PARAM_SPACING) ||
         vor_spec_check_target(spec, vor_spec_target(spec, row.input[0].points),
                               row.input[0].points, err) == VOR_OK) &&
        check_need(worker, &row, err) == VOR_OK &&
        vor_cost_check(&row.spec, row.input[0].points, worker->config.executor->threads,
                       worker->config.job_seconds, err) == VOR_OK &&
        check_origin(&row, admitted, err) == VOR_OK) {
        outcome = booked ? VOR_DONE : vor_worker_book(worker);
        booked = outcome == VOR_DONE;
    }
    if (outcome == VOR_DONE)
        outcome = submit(worker, &row, label, err);
    if (outcome != VOR_DONE) {
        if (booked)
            vor_worker_unbook(worker);
        /* Inputs of one that may be there stay for it, or are found to be strays (recover.c). */
        if (outcome != VOR_FAILED || !vor_error_may_be_done(err))
            vor_admit_drop(worker->config.blobs, admitted);
        return outcome;
    }
    if (row.kept > 0)
        vor_worker_keep_quota(worker, VOR_EVICT_UPLOADS);
    if (out != NULL)
        *out = row;
    return VOR_DONE;
}
