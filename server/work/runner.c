/* One run of one job: its inputs, the engine, its outputs, its last row. */
#include "server/work/runner.h"

#include "core/engine.h"
#include "proto/codec.h"
#include "proto/json/json.h"
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/work/artefacts.h"

#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

static const double beat_seconds = 2;  /* between two notes of the progress in the store */
static const double retry_seconds = 1; /* while the store's disk is full */

struct run {
    struct vor_worker *worker;
    struct vor_job *job;
    struct vor_job_view view; /* when it began */
    uint32_t attempt;
    double beat;     /* when the store was last told */
    double deadline; /* when it must be over; infinite for never */
    atomic_int late; /* it was not */
    struct vor_memory memory;
    struct vor_result_facts facts;
    int has_report; /* the process has one, and the run came to its end */
    struct vor_report report;
    struct vor_text kept; /* the output that is kept in the row, as JSON; empty for none */
    struct vor_job_output output[VOR_OUTPUTS_MAX];
};

/* --- the engine's questions ------------------------------------------------------------------- */

/* A run that is late ends as one that is cancelled. */
static enum vor_answer poll_job(void *ctx)
{
    struct run *run = ctx;
    enum vor_answer asked = vor_job_asked(run->job);

    if (asked == VOR_CANCEL || vor_clock_seconds() < run->deadline)
        return asked;
    atomic_store(&run->late, 1);
    return VOR_CANCEL;
}

static double read_clock(void *ctx)
{
    (void)ctx;
    return vor_clock_seconds();
}

static void beat(struct run *run)
{
    struct vor_job_view view;
    struct vor_error err;

    vor_job_view(run->job, &view);
    if (vor_store_beat(run->worker->config.store, &view, &err) != VOR_OK)
        vor_log(VOR_LOG_WARN, "progress not stored", VOR_TEXT("job", view.id.text),
                VOR_TEXT("error", err.message));
}

static enum vor_answer take_progress(void *ctx, const struct vor_record *record)
{
    struct run *run = ctx;
    double now = vor_clock_seconds();

    vor_job_progress(run->job, record, vor_clock_wall_ms());
    if (now - run->beat >= beat_seconds) {
        run->beat = now;
        beat(run);
    }
    return poll_job(run);
}

/* --- the three steps -------------------------------------------------------------------------- */

/* Runs the engine on the job's inputs. */
static vor_status compute(struct run *run, struct vor_artefacts *out, struct vor_error *err)
{
    struct vor_watch watch = {
        .ctx = run, .progress = take_progress, .poll = poll_job, .clock = read_clock};
    struct vor_run engine = {
        .pool = run->worker->config.pool, .memory = &run->memory, .watch = &watch};
    struct vor_artefacts in;
    vor_status status;

    vor_artefacts_init(&in, &run->memory);
    status = vor_artefacts_load(&in, run->worker->config.blobs, &run->view, err);
    if (status == VOR_OK) {
        vor_extent_measure(&run->facts.input,
                           vor_artefacts_cloud(&in, run->view.spec.process->inputs[0].name));
        status = vor_engine_run(out, &in, &run->view.spec, &engine, err);
    }
    vor_artefacts_free(&in);
    return status;
}

/* Makes the outputs that are blobs durable. */
static vor_status save_blobs(struct run *run, const struct vor_artefacts *out,
                             struct vor_error *err)
{
    const struct vor_artefact_info *outputs = run->view.spec.process->outputs;
    vor_status status = VOR_OK;

    for (unsigned i = 0; outputs[i].name != NULL && status == VOR_OK; i++)
        if (!vor_output_in_row(&outputs[i]))
            status = vor_artefact_save(&run->output[i], run->worker->config.blobs, &run->view,
                                       vor_artefacts_find(out, outputs[i].name), &run->facts, err);
    return status;
}

/* What the engine cannot know of the report. */
static void complete_report(const struct run *run, struct vor_report *report,
                            const struct vor_artefacts *out, double began)
{
    const struct vor_artefact *main =
        vor_artefacts_find(out, run->view.spec.process->outputs[0].name);

    if (main->kind == VOR_ARTEFACT_CLOUD)
        vor_codec_report_dropped(report, &main->cloud, vor_format(run->output[0].format));
    report->seconds_read = 0;
    for (unsigned i = 0; i < VOR_INPUTS_MAX; i++)
        report->seconds_read += run->view.input[i].seconds;
    report->seconds_write = vor_clock_seconds() - began;
    report->memory_peak_bytes = atomic_load(&run->memory.peak);
    memcpy(report->origin, run->output[0].origin, sizeof report->origin);
}

/* Writes the output that goes into the row. */
static vor_status write_kept(struct run *run, const struct vor_artefacts *out,
                             struct vor_error *err)
{
    const struct vor_artefact_info *outputs = run->view.spec.process->outputs;

    for (unsigned i = 0; outputs[i].name != NULL; i++) {
        if (!vor_output_in_row(&outputs[i]))
            continue;
        vor_json_document(&run->kept, &vor_artefacts_find(out, outputs[i].name)->document);
        run->output[i].bytes = run->kept.size;
    }
    return vor_text_status(&run->kept, err);
}

static vor_status save(struct run *run, struct vor_artefacts *out, struct vor_error *err)
{
    struct vor_report *report = vor_artefacts_values(out, "report", &vor_report_members);
    double began = vor_clock_seconds();
    vor_status status;

    vor_job_stage(run->job, VOR_STAGE_ENCODE, vor_clock_wall_ms());
    run->facts.spacing = report != NULL ? report->spacing_mean : 0;
    status = save_blobs(run, out, err);
    if (status != VOR_OK)
        return status;
    if (report != NULL) {
        complete_report(run, report, out, began);
        run->has_report = 1;
        run->report = *report;
    }
    return write_kept(run, out, err);
}

static vor_status execute(struct run *run, struct vor_error *err)
{
    struct vor_artefacts out;
    vor_status status;

    vor_memory_init(&run->memory, run->worker->config.memory);
    vor_artefacts_init(&out, &run->memory);
    status = compute(run, &out, err);
    if (status == VOR_OK && poll_job(run) == VOR_CANCEL)
        status = vor_fail(err, VOR_E_CANCELLED, "cancelled by the caller");
    if (status == VOR_OK)
        status = save(run, &out, err);
    vor_artefacts_free(&out);
    return status;
}

/* --- the end ---------------------------------------------------------------------------------- */

/* "300 points after 12 iterations, delta 0.0212" of a run that spreads points; else what the main
 * output is. */
static void describe_outputs(const struct run *run, char *out, size_t size)
{
    const struct vor_artefact_info *main = &run->view.spec.process->outputs[0];
    char steps[64];

    if (run->has_report && vor_process_takes(run->view.spec.process, VOR_PARAM_POINTS))
        (void)snprintf(out, size, "%llu points after %s, delta %.4f",
                       (unsigned long long)run->output[0].points,
                       vor_report_steps(&run->report, steps, sizeof steps), run->report.delta);
    else if (main->kind == VOR_ARTEFACT_CLOUD)
        (void)snprintf(out, size, "%llu points", (unsigned long long)run->output[0].points);
    else
        (void)snprintf(out, size, "%s is ready, %llu bytes", main->name,
                       (unsigned long long)run->output[0].bytes);
}

static void describe_success(const struct run *run, struct vor_job_view *row)
{
    row->progress = 100;
    memcpy(row->output, run->output, sizeof row->output);
    if (run->has_report) {
        /* The last record need not be that of the cloud that is handed out. */
        row->record.delta = run->report.delta;
        row->record.sigma = run->report.sigma;
        row->record.epsilon = run->report.epsilon;
    }
    describe_outputs(run, row->message, sizeof row->message);
}

static void describe_failure(struct vor_job_view *row, const struct vor_error *problem)
{
    row->problem = *problem;
    (void)snprintf(row->message, sizeof row->message, "%.*s", (int)sizeof row->message - 1,
                   problem->message);
}

/* Writes the last row once, of a success when problem is NULL; a failure asks for another try. */
static vor_status finish_once(struct run *run, const struct vor_error *problem,
                              struct vor_error *err)
{
    const char *kept = problem == NULL ? run->kept.data : NULL;
    int changed = 0;
    struct vor_job_view row;
    vor_status status;

    if (!vor_job_freeze(run->job))
        return VOR_OK; /* dismissed: its row is written */
    vor_worker_ending(run->worker, run->job, problem != NULL ? VOR_JOB_FAILED : VOR_JOB_SUCCESSFUL,
                      &row);
    if (problem != NULL)
        describe_failure(&row, problem);
    else
        describe_success(run, &row);
    status = vor_worker_finish(run->worker, run->job, &row, run->attempt, kept, &changed, err);
    if (status == VOR_OK && !changed) {
        row.status = VOR_JOB_DISMISSED; /* somebody changed the row behind our back: readers must
                                           not wait for ever */
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
        vor_log(VOR_LOG_ERROR, "the end of a job cannot be stored",
                VOR_TEXT("job", run->view.id.text), VOR_TEXT("error", err.message));
        if (vor_worker_pause(run->worker, retry_seconds))
            break;
    }
}

static int is_aborting(struct vor_worker *worker)
{
    int aborting;

    pthread_mutex_lock(&worker->mutex);
    aborting = worker->aborting;
    pthread_mutex_unlock(&worker->mutex);
    return aborting;
}

/* Why a run that failed did, where the engine cannot know. */
static void explain(struct run *run, vor_status status, struct vor_error *problem)
{
    if (status == VOR_E_CANCELLED && atomic_load(&run->late))
        (void)vor_fail(problem, VOR_E_DEADLINE, "the job ran for %g seconds, as long as it may",
                       run->worker->config.job_seconds);
}

/* The daemon goes down: the next one runs the job again. */
static void give_back(struct run *run)
{
    struct vor_error err;
    int changed;

    if (vor_store_release(run->worker->config.store, &run->view.id, run->attempt,
                          vor_clock_wall_ms(), &changed, &err) != VOR_OK)
        vor_log(VOR_LOG_ERROR, "a job cannot be given back", VOR_TEXT("job", run->view.id.text),
                VOR_TEXT("error", err.message));
    else if (changed)
        vor_log(VOR_LOG_INFO, "job given back", VOR_TEXT("job", run->view.id.text));
}

/* Removes what the ended job no longer needs, and says how it ended. */
static void clean_up(struct run *run, double began)
{
    struct vor_job_view view;

    vor_job_view(run->job, &view);
    if (!vor_job_status_over(view.status))
        return;
    vor_worker_drop_inputs(run->worker, &view.id, view.process);
    if (view.status != VOR_JOB_SUCCESSFUL)
        vor_worker_drop_outputs(run->worker, &view.id, view.process);
    if (view.kept > 0)
        vor_worker_shed(run->worker);
    vor_log(VOR_LOG_INFO, "job ended", VOR_TEXT("job", view.id.text),
            VOR_TEXT("status", vor_job_status_word(view.status)), VOR_TEXT("message", view.message),
            VOR_COUNT("attempt", view.attempt), VOR_COUNT("points", view.output[0].points),
            VOR_COUNT("bytes", view.output[0].bytes),
            VOR_REAL("dur_s", round((vor_clock_seconds() - began) * 1e6) / 1e6));
}

/* accepted -> running in the store; false when the job was dismissed or the daemon goes down. */
static int claim(struct run *run)
{
    struct vor_error err;
    int changed;

    while (vor_store_claim(run->worker->config.store, &run->view.id, vor_clock_wall_ms(),
                           &run->attempt, &changed, &err) != VOR_OK) {
        vor_log(VOR_LOG_ERROR, "a job cannot be claimed", VOR_TEXT("job", run->view.id.text),
                VOR_TEXT("error", err.message));
        if (vor_worker_pause(run->worker, retry_seconds))
            return 0;
    }
    return changed;
}

void vor_worker_run(struct vor_worker *worker, struct vor_job *job)
{
    double began = vor_clock_seconds();
    struct run run = {.worker = worker, .job = job, .beat = began};
    struct vor_error problem;
    vor_status status;

    vor_text_init(&run.kept, 0);
    atomic_init(&run.late, 0);
    vor_job_view(job, &run.view);
    if (claim(&run)) {
        vor_log(VOR_LOG_INFO, "job started", VOR_TEXT("job", run.view.id.text),
                VOR_COUNT("attempt", run.attempt));
        vor_job_begin(job, vor_clock_wall_ms());
        run.deadline = worker->config.job_seconds > 0
                           ? vor_clock_seconds() + worker->config.job_seconds
                           : (double)INFINITY;
        status = execute(&run, &problem);
        explain(&run, status, &problem);
        if (status == VOR_E_CANCELLED && is_aborting(worker))
            give_back(&run);
        else
            finish(&run, status == VOR_OK ? NULL : &problem);
    }
    clean_up(&run, began);
    vor_text_free(&run.kept);
}
