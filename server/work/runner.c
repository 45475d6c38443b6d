/* One run of one job: its files, where it runs, its outputs, its last row. */
#include "server/work/active_jobs.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/metrics.h"
#include "server/work/ipc_codec.h"
#include "server/work/keeper.h"

#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const double store_seconds = 2; /* between two pieces of events for the store (lease.c) */
static const double retry_seconds = 1; /* while the disk is full */
static const double retry_seconds_max = 16; /* at most, as encoding costs cores */
/* For the last checkpoint of a run that is lost, and of one that the daemon gives back as it ends.
 */
static const double lost_seconds = 30, leaving_seconds = 5;

struct run {
    struct vor_job_service *service;
    struct vor_runner *runner;
    struct vor_job *job;
    struct vor_job_view view; /* when it began */
    struct vor_lease lease;
    int is_lost;      /* the lease is: the job is another owner's, or nobody's */
    double stored;    /* when the store got the last events */
    double deadline;  /* when it must be over; infinite for never */
    atomic_int late;  /* it was not */
    atomic_int stops; /* those who follow it were told that it is to stop */
    struct vor_order order;
    struct vor_blob_writer *writer[VOR_OUTPUTS_MAX]; /* of the files of the order; NULL for none */
    struct vor_keeper keeper;
    int is_resumed; /* the run went on from a checkpoint, and its first record is yet to come */
    int has_kept;   /* there is a checkpoint of the job */
    int has_shown;  /* there is a preview of it in the store */
    struct vor_run_result result;
    struct vor_text kept; /* the output that is kept in the row, as JSON; empty for none */
};

/* --- what the run asks and tells -------------------------------------------------------------- */

static void tell_wait(const struct run *run, const struct vor_error *err)
{
    vor_log(VOR_LOG_WARN,
            vor_error_storage_absent(err) ? "a job waits for its files"
                                          : "a result waits for room on the disk",
            VOR_OF_JOB(&run->view), VOR_TEXT("error", err->message));
}

/* A run that is late ends as one that is cancelled. */
static enum vor_answer asked(void *ctx)
{
    struct run *run = ctx;
    enum vor_answer answer = vor_job_asked(run->job);

    if (answer == VOR_STOP && !atomic_exchange(&run->stops, 1))
        vor_job_tell_stop(run->job, vor_clock_wall_ms());
    if (answer == VOR_CANCEL || vor_clock_seconds() < run->deadline)
        return answer;
    atomic_store(&run->late, 1);
    return VOR_CANCEL;
}

static void take_record(struct run *run, const struct vor_record *record)
{
    double now = vor_clock_seconds();

    if (run->is_resumed)
        vor_log(VOR_LOG_INFO, "job resumed from a checkpoint", VOR_OF_JOB(&run->view),
                VOR_COUNT("attempt", run->lease.attempt), VOR_COUNT("iteration", record->iteration),
                VOR_COUNT("polish", record->polish));
    run->is_resumed = 0;
    vor_job_progress(run->job, record, vor_clock_wall_ms());
    if (now - run->stored >= store_seconds && !vor_store_is_shared(run->service->config.store)) {
        struct vor_error err;
        int changed;

        run->stored = now;
        if (vor_job_service_store_events(run->service, run->job, &run->lease, &changed, &err) !=
            VOR_OK)
            vor_log(VOR_LOG_WARN, "progress not stored", VOR_OF_JOB(&run->view),
                    VOR_TEXT("error", err.message));
        else if (!changed)
            vor_job_ask(run->job, VOR_CANCEL);
    }
}

static int is_looked_at(void *ctx)
{
    return vor_preview_is_looked_at(vor_job_preview(((struct run *)ctx)->job));
}

/* Puts the preview into the store, or takes it away. If that fails, clients of other daemons see no
 * preview, and the run goes on. */
static void show_elsewhere(struct run *run, int is_running)
{
    struct vor_event_piece piece = {.size = 0};
    uint64_t version = 0;
    uint8_t *bytes =
        is_running ? vor_preview_pack(vor_job_preview(run->job), &piece.size, &version) : NULL;
    struct vor_error err;

    piece.data = bytes;
    piece.last = (uint32_t)version;
    if (vor_store_show(run->service->config.store, &run->view.id, &run->lease, &piece, &err) !=
        VOR_OK)
        vor_log(VOR_LOG_DEBUG, "preview not stored", VOR_OF_JOB(&run->view),
                VOR_TEXT("error", err.message));
    run->has_shown = 1;
    free(bytes);
}

static void take(void *ctx, enum vor_said what, const void *of)
{
    struct run *run = ctx;

    switch (what) {
    case VOR_SAID_STAGE:
        vor_job_stage(run->job, *(const enum vor_stage *)of, vor_clock_wall_ms());
        break;
    case VOR_SAID_RECORD:
        take_record(run, of);
        break;
    case VOR_SAID_RESUMED:
        run->is_resumed = 1;
        break;
    case VOR_SAID_CHECKPOINT:
        vor_keeper_take(&run->keeper, of);
        break;
    case VOR_SAID_WAITS:
        tell_wait(run, of);
        break;
    case VOR_SAID_POINTS:
        vor_job_show(run->job, of);
        if (vor_preview_is_looked_at_elsewhere(vor_job_preview(run->job), 0))
            show_elsewhere(run, 1);
        break;
    default:
        break;
    }
}

static int is_not_cancelled(void *ctx)
{
    return vor_job_asked(((struct run *)ctx)->job) != VOR_CANCEL;
}

static int file_of(void *ctx)
{
    return vor_keeper_file(&((struct run *)ctx)->keeper);
}

/* --- the order and its files ------------------------------------------------------------------ */

/* Bytes of an output, as many a point as the inputs have; UINT32_MAX where nothing tells how many
 * points. */
static uint64_t likely_bytes(const struct vor_job_view *row)
{
    double in = fmax(1, (double)row->input[0].points);
    double out = vor_spec_target(&row->spec, (uint64_t)in);

    if (vor_spec_keeps_points(&row->spec))
        out = fmax(in, out);
    if (out < 0)
        return UINT32_MAX;
    return (uint64_t)fmin(UINT32_MAX, out / in * (double)row->decoded);
}

static vor_status place_order(struct run *run, struct vor_error *err)
{
    const struct vor_artefact_info *inputs = run->view.spec.process->inputs;
    const struct vor_artefact_info *outputs = run->view.spec.process->outputs;
    struct vor_blobs *blobs = run->service->config.blobs;
    struct vor_order *order = &run->order;
    char blob[VOR_BLOB_NAME_MAX + 1];
    struct vor_error why;
    uint64_t size, likely = likely_bytes(&run->view);
    int found;
    vor_status status = VOR_OK;

    *order = (struct vor_order){.spec = run->view.spec,
                                .format = run->view.input[0].format,
                                .memory = run->service->config.memory,
                                .every = run->service->config.checkpoint_work,
                                .is_suspect = run->view.alone};
    vor_order_forget(order);
    for (unsigned i = 0; i < VOR_INPUTS_MAX; i++)
        order->seconds_read += run->view.input[i].seconds;
    for (unsigned i = 0; inputs[i].name != NULL && status == VOR_OK; i++) {
        if ((run->view.inputs >> i & 1) == 0)
            continue;
        status = vor_blob_get(blobs, &run->view.id, vor_blob_of_input(inputs[i].name, blob),
                              &order->input[i], &size, &found, err);
        if (status == VOR_OK && !found)
            status = vor_fail(err, VOR_E_INTERNAL, "the job's input %s no longer exists",
                              inputs[i].name);
    }
    /* A checkpoint that cannot be had is done without. */
    if (status == VOR_OK && run->view.attempt > 1 &&
        vor_blob_get(blobs, &run->view.id, vor_blob_of_input(VOR_BLOB_CHECKPOINT, blob),
                     &order->saved, &size, &run->has_kept, &why) != VOR_OK)
        vor_log(VOR_LOG_WARN, "a checkpoint cannot be read", VOR_OF_JOB(&run->view),
                VOR_TEXT("error", why.message));
    for (unsigned i = 0; status == VOR_OK && outputs[i].name != NULL; i++) {
        if (vor_output_in_row(&outputs[i]))
            continue;
        status = vor_blob_create(blobs, &run->writer[i], err);
        VOR_THEN(status, vor_blob_expect(run->writer[i], likely, err));
        if (status == VOR_OK)
            order->output[i] = vor_blob_fd(run->writer[i]);
    }
    return status;
}

/* Waits `seconds`, and longer while the disk is full. False when the job is to end instead: it was
 * cancelled, or the daemon goes down. */
static int wait_for_room(const struct run *run, double seconds)
{
    static const struct timespec poll = {.tv_nsec = 50000000};
    double until = vor_clock_seconds() + seconds;

    /* A job must not take what the reserve is made of. Where none is asked for, it just tries. */
    while (vor_clock_seconds() < until ||
           vor_store_check_reserve(run->service->config.store, NULL) != VOR_OK) {
        if (vor_job_asked(run->job) == VOR_CANCEL)
            return 0;
        (void)nanosleep(&poll, NULL);
    }
    return vor_job_asked(run->job) != VOR_CANCEL;
}

/* A result is written again while its storage is away; not once the job is cancelled. */
static int wait_for_blobs(void *ctx, const struct vor_error *why)
{
    struct run *run = ctx;

    if (is_not_cancelled(run))
        tell_wait(run, why);
    return wait_for_room(run, retry_seconds);
}

/* Makes the outputs that are blobs durable. */
static vor_status commit_outputs(struct run *run, struct vor_error *err)
{
    const struct vor_artefact_info *outputs = run->view.spec.process->outputs;
    const struct vor_blob_patience patience = {wait_for_blobs, is_not_cancelled, run};
    char blob[VOR_BLOB_NAME_MAX + 1];
    vor_status status = VOR_OK;

    for (unsigned i = 0; outputs[i].name != NULL && status == VOR_OK; i++) {
        const struct vor_job_output *output = &run->result.output[i];
        struct vor_blob_writer *writer = run->writer[i];

        if (writer == NULL)
            continue;
        status = vor_blob_adopt(writer, output->bytes, output->sha256, err);
        if (status != VOR_OK)
            break;
        run->writer[i] = NULL;
        vor_blob_be_patient(writer, &patience);
        status =
            vor_blob_commit(writer, &run->view.id,
                            vor_blob_of_output(outputs[i].name, run->lease.attempt, blob), err);
    }
    return status;
}

static int is_aborting(struct vor_job_service *service)
{
    int aborting;

    pthread_mutex_lock(&service->mutex);
    aborting = service->aborting;
    pthread_mutex_unlock(&service->mutex);
    return aborting;
}

/* Has the order run, once. */
static enum vor_run_end try_order(struct run *run, struct vor_error *err)
{
    const struct vor_listener listener = {
        .ctx = run, .asked = asked, .said = take, .is_looked_at = is_looked_at, .file = file_of};
    struct vor_run_executor *executor = run->service->config.executor;
    enum vor_run_end end = VOR_RUN_FAILED;

    vor_keeper_open(&run->keeper, run->service->config.blobs, &run->view.id,
                    run->service->config.checkpoint_seconds);
    if (place_order(run, err) == VOR_OK)
        end = executor->run(executor, &run->order, &listener, &run->result, &run->kept, err);
    run->has_kept |= vor_keeper_close(
        &run->keeper, end != VOR_RUN_DONE && end != VOR_RUN_FAILED         ? lost_seconds
                      : end == VOR_RUN_FAILED && is_aborting(run->service) ? leaving_seconds
                                                                           : 0);
    if (end == VOR_RUN_DONE && commit_outputs(run, err) != VOR_OK)
        end = VOR_RUN_FAILED;
    for (unsigned i = 0; i < VOR_OUTPUTS_MAX; i++) {
        run->order.output[i] = -1; /* its writer closes it */
        vor_blob_discard(run->writer[i]);
        run->writer[i] = NULL;
    }
    vor_order_close(&run->order);
    return end;
}

/* Has the order run, however long the disk is full or the blobs are away. The run itself waits
 * where its files do not grow, and keeps what it has made; here they cannot be read or made. */
static enum vor_run_end execute(struct run *run, struct vor_error *err)
{
    double pause = retry_seconds;

    for (;;) {
        enum vor_run_end end = try_order(run, err);

        if (end != VOR_RUN_FAILED ||
            (!vor_error_storage_full(err) && !vor_error_storage_absent(err)))
            return end;
        tell_wait(run, err);
        vor_text_clear(&run->kept);
        if (!wait_for_room(run, pause)) {
            (void)vor_fail(err, VOR_E_CANCELLED,
                           "cancelled while the daemon could not store the files of the job");
            return VOR_RUN_FAILED;
        }
        pause = fmin(2 * pause, retry_seconds_max);
    }
}

/* --- the end ---------------------------------------------------------------------------------- */

/* True when this end was written before, and the answer lost: *row then is the job's. */
static int is_written(const struct run *run, struct vor_job_view *row)
{
    struct vor_job_view there;
    int found = 0;

    if (vor_store_get(run->service->config.store, &row->id, NULL, &there, &found, NULL) != VOR_OK ||
        !found || there.status != row->status || there.attempt != run->lease.attempt)
        return 0;
    *row = there;
    return 1;
}

/* Writes the last row once, of a success when problem is NULL; a failure asks for another try. */
static vor_status finish_once(struct run *run, const struct vor_error *problem,
                              struct vor_error *err)
{
    const struct vor_run_result *result = &run->result;
    const char *kept = problem == NULL ? run->kept.data : NULL;
    int changed = 0;
    struct vor_job_view row;
    vor_status status;

    if (!vor_job_freeze(run->job))
        return VOR_OK; /* dismissed: its row is written */
    vor_job_service_ending(run->service, run->job,
                           problem != NULL ? VOR_JOB_FAILED : VOR_JOB_SUCCESSFUL, &row);
    (void)snprintf(row.message, sizeof row.message, "%.*s", (int)sizeof row.message - 1,
                   problem != NULL ? problem->message : result->message);
    if (problem != NULL) {
        row.problem = *problem;
    } else {
        row.progress = 100;
        memcpy(row.output, result->output, sizeof row.output);
    }
    if (problem == NULL && result->has_report) {
        /* The last record need not be that of the cloud that is handed out. */
        row.record.delta = result->report.delta;
        row.record.sigma = result->report.sigma;
        row.record.epsilon = result->report.epsilon;
    }
    status = vor_job_service_finish(run->service, run->job, &row, &run->lease, kept, &changed, err);
    if (status == VOR_OK && !changed && is_written(run, &row)) {
        vor_job_end(run->job, &row);
    } else if (status == VOR_OK && !changed) {
        vor_log(VOR_LOG_WARN, "job lost: another daemon has it, or it was deleted",
                VOR_OF_JOB(&row), VOR_COUNT("attempt", run->lease.attempt));
        run->is_lost = 1;
        row.status = VOR_JOB_DISMISSED; /* here, as readers must not wait for ever */
        if (!vor_store_is_shared(run->service->config.store)) /* else they follow its row */
            vor_job_end(run->job, &row);
    }
    vor_job_thaw(run->job);
    return status;
}

/* Ends the job. While the store refuses, the job goes on as running: after a restart it is run
 * again, and nobody was told otherwise. */
static void finish(struct run *run, const struct vor_error *problem)
{
    struct vor_error err;

    while (finish_once(run, problem, &err) != VOR_OK) {
        vor_log(VOR_LOG_ERROR, "the end of a job cannot be stored", VOR_OF_JOB(&run->view),
                VOR_TEXT("error", err.message));
        if (vor_job_service_pause(run->service, retry_seconds))
            break;
    }
}

/* The process of the run has ended under it. True when the job is to be run again. While the store
 * cannot be told, the job goes on as running: the next start of the daemon then runs it. */
static int conclude_lost(struct run *run, enum vor_run_end end, struct vor_error *problem)
{
    struct vor_hand_back back = {.lease = run->lease,
                                 .now_ms = vor_clock_wall_ms(),
                                 .is_crash = end != VOR_RUN_DISTURBED,
                                 .was_alone = end == VOR_RUN_CRASHED_ALONE,
                                 .most = run->service->config.faults_max};
    struct vor_job_service *service = run->service;
    int again;

    vor_log(VOR_LOG_WARN, "run lost", VOR_OF_JOB(&run->view),
            VOR_COUNT("attempt", run->lease.attempt), VOR_TEXT("error", problem->message));
    if (problem->status != VOR_E_INTERNAL) /* there is no worker, and may be none at once */
        (void)vor_job_service_pause(service, retry_seconds);
    do {
        /* running -> accepted in the store, and in the live job unless it has crashed too often */
        pthread_mutex_lock(&service->claim);
        if (!vor_job_service_hand_back(service, &run->view.id, &back))
            again = -1;
        else
            again = back.changed && !back.is_over &&
                    vor_job_restart(run->job, back.is_crash, vor_clock_wall_ms());
        if (again > 0) {
            pthread_mutex_lock(&service->mutex); /* another runner may have it at once */
            run->runner->job = NULL;
            pthread_mutex_unlock(&service->mutex);
            vor_capacity_wait(service, &run->view, 1);
        }
        pthread_mutex_unlock(&service->claim);
    } while (again < 0 && !vor_job_service_pause(service, retry_seconds));
    if (again < 0)
        return 0;
    if (again) {
        vor_metric_add(VOR_METRIC_JOBS_AGAIN, 1, VOR_LABELS("worker"));
    } else if (back.is_over) {
        (void)vor_fail(problem, VOR_E_INTERNAL,
                       "crashed: the worker process crashed %u times while it ran only this "
                       "job",
                       back.crashes);
        finish(run, problem);
    } else if (!back.changed) {
        finish(run, problem); /* dismissed, or lost: which it finds */
    }
    return again;
}

/* Ends the job, or finds that it is to be run again: then true. */
static int conclude(struct run *run, enum vor_run_end end, struct vor_error *problem)
{
    struct vor_hand_back back = {.lease = run->lease, .now_ms = vor_clock_wall_ms()};

    if (end == VOR_RUN_DONE) {
        finish(run, NULL);
    } else if (end != VOR_RUN_FAILED) {
        return conclude_lost(run, end, problem);
    } else if (problem->status == VOR_E_CANCELLED && is_aborting(run->service)) {
        /* The daemon goes down: the next one runs the job again. */
        if (vor_job_service_hand_back(run->service, &run->view.id, &back) && back.changed)
            vor_log(VOR_LOG_INFO, "job returned to the queue", VOR_OF_JOB(&run->view));
    } else {
        if (problem->status == VOR_E_CANCELLED && atomic_load(&run->late))
            (void)vor_fail(problem, VOR_E_DEADLINE,
                           "the job ran for %g seconds, the longest time that is allowed",
                           run->service->config.job_seconds);
        finish(run, problem);
    }
    return 0;
}

/* How many attempts have left outputs that nobody needs: all, or all before the last one. */
static uint32_t attempts_gone(enum vor_job_status status, uint32_t attempt)
{
    int is_needed = !vor_job_status_over(status) || status == VOR_JOB_SUCCESSFUL;

    return is_needed && attempt > 0 ? attempt - 1 : attempt;
}

/* Removes what the ended job no longer needs, and says how it ended. */
static void clean_up(struct run *run, double began)
{
    struct vor_job_view view;
    uint32_t gone;

    vor_job_view(run->job, &view);
    if (!vor_job_status_over(view.status))
        return;
    gone = attempts_gone(view.status, view.attempt);
    vor_job_service_drop_all(run->service, &view.id, view.process, gone,
                             vor_has_inputs(&view) | (run->has_kept ? VOR_HAS_CHECKPOINT : 0) |
                                 (gone > 0 ? VOR_HAS_OUTPUTS : 0));
    atomic_store(&run->service->has_grown, 1);
    vor_log(VOR_LOG_INFO, "job ended", VOR_OF_JOB(&view),
            VOR_TEXT("status", vor_job_status_word(view.status)), VOR_TEXT("message", view.message),
            VOR_COUNT("attempt", view.attempt), VOR_COUNT("points", view.output[0].points),
            VOR_COUNT("bytes", view.output[0].bytes),
            VOR_REAL("dur_s", round((vor_clock_seconds() - began) * 1e6) / 1e6));
}

/* What was stored after the job had ended elsewhere: who ended it did not find that. */
static void clean_up_lost(const struct run *run)
{
    const struct vor_job_service_config *config = &run->service->config;
    struct vor_job_brief row = {.status = VOR_JOB_DISMISSED, .attempt = run->lease.attempt};
    int found;

    if (vor_store_brief(config->store, &run->view.id, &row, &found, NULL) != VOR_OK)
        return;
    vor_job_service_drop_all(
        run->service, &run->view.id, run->view.process, attempts_gone(row.status, row.attempt),
        VOR_HAS_OUTPUTS |
            (run->has_kept && vor_job_status_over(row.status) ? VOR_HAS_CHECKPOINT : 0));
}

/* --- a run ------------------------------------------------------------------------------------ */

static void count_stage(const struct vor_job_view *row, const char *stage, double seconds)
{
    vor_metric_observe(VOR_METRIC_JOB_SECONDS, seconds, VOR_LABELS(row->process, stage));
}

/* It is over, however it ended. report is NULL unless it was successful and its process makes one.
 */
static void count_ended(const struct vor_job_view *row, const struct vor_report *report,
                        size_t memory, double seconds)
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

void vor_job_service_run(struct vor_runner *runner, const struct vor_job_view *row)
{
    struct vor_job_service *service = runner->service;
    double began = vor_clock_seconds(), may = service->config.job_seconds;
    struct run run = {.service = service,
                      .runner = runner,
                      .job = runner->job,
                      .view = *row,
                      .lease = {service->owner.text, row->attempt},
                      .stored = began,
                      .deadline = may > 0 ? began + may : (double)INFINITY};
    struct vor_error problem;
    enum vor_run_end end = VOR_RUN_FAILED;

    vor_text_init(&run.kept, 0);
    atomic_init(&run.late, 0);
    atomic_init(&run.stops, 0);
    vor_log(VOR_LOG_INFO, "job started", VOR_OF_JOB(row), VOR_COUNT("attempt", row->attempt));
    vor_job_begin(run.job, vor_clock_wall_ms());
    vor_metric_add(VOR_METRIC_MEMORY_RESERVED, (double)service->config.memory, NULL);
    if (row->attempt == 1)
        vor_metric_observe(VOR_METRIC_QUEUE_WAIT,
                           fmax(0, (double)(vor_clock_wall_ms() - row->created) / 1000), NULL);
    if (row->request_lost || vor_spec_check(&row->spec, NULL) != VOR_OK ||
        vor_spec_check_inputs(&row->spec, row->inputs, NULL) != VOR_OK)
        (void)vor_fail(&problem, VOR_E_INTERNAL,
                       "the job's request cannot be read by this version");
    else
        end = execute(&run, &problem);
    count_ended(row, end == VOR_RUN_DONE && run.result.has_report ? &run.result.report : NULL,
                service->config.memory, vor_clock_seconds() - began);
    if (run.has_shown)
        show_elsewhere(&run, 0);
    if (!conclude(&run, end, &problem)) {
        if (run.is_lost)
            clean_up_lost(&run);
        else
            clean_up(&run, began);
        if (!run.is_lost || vor_job_is_over(run.job))
            vor_job_service_forget(service, run.job);
    }
    vor_text_free(&run.kept);
}
