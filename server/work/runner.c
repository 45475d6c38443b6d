/* One run of one job: its cloud, the engine, the encoded result, its last row. */
#include "server/work/runner.h"

#include "core/engine.h"
#include "proto/codec.h"
#include "proto/dump.h"
#include "proto/json/json.h"
#include "server/base/clock.h"
#include "server/base/log.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static const double beat_seconds = 2;  /* between two notes of the progress in the store */
static const double retry_seconds = 1; /* while the store's disk is full */

struct run {
    struct vor_worker *worker;
    struct vor_job *job;
    struct vor_job_view view; /* when it began */
    uint32_t attempt;
    double beat; /* when the store was last told */
    struct vor_memory memory;
    struct vor_report report;
    struct vor_job_output output;
};

/* --- the engine's questions ------------------------------------------------------------------- */

static enum vor_answer poll_job(void *ctx)
{
    return vor_job_asked(((struct run *)ctx)->job);
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
    return vor_job_asked(run->job);
}

/* --- the three steps -------------------------------------------------------------------------- */

/* Reads the cloud that the admission kept. */
static vor_status read_input(struct run *run, struct vor_cloud *cloud, struct vor_error *err)
{
    uint64_t size;
    vor_status status;
    void *bytes;
    int fd, found;

    status = vor_blob_get(run->worker->config.blobs, &run->view.id, VOR_BLOB_INPUT, &fd, &size,
                          &found, err);
    if (status != VOR_OK)
        return status;
    if (!found)
        return vor_fail(err, VOR_E_INTERNAL, "the job's input is gone");
    bytes = size > 0 ? mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0) : MAP_FAILED;
    if (bytes == MAP_FAILED) {
        status = vor_fail(err, VOR_E_IO, "the job's input cannot be mapped: %s", strerror(errno));
    } else {
        status = vor_dump_read(cloud, bytes, size, err);
        (void)munmap(bytes, size);
    }
    close(fd);
    return status;
}

static vor_status optimize(struct run *run, struct vor_artefacts *out, struct vor_error *err)
{
    struct vor_watch watch = {
        .ctx = run, .progress = take_progress, .poll = poll_job, .clock = read_clock};
    struct vor_run engine = {
        .pool = run->worker->config.pool, .memory = &run->memory, .watch = &watch};
    struct vor_artefacts in;
    struct vor_cloud cloud;
    vor_status status;

    vor_artefacts_init(&in, &run->memory);
    vor_cloud_init(&cloud, &run->memory);
    status = read_input(run, &cloud, err);
    vor_artefacts_put_cloud(&in, "cloud", &cloud);
    if (status == VOR_OK)
        status = vor_engine_run(out, &in, &run->view.spec, &engine, err);
    vor_artefacts_free(&in);
    return status;
}

static vor_status write_cloud(struct run *run, struct vor_blob_writer *writer,
                              const struct vor_cloud *cloud, struct vor_error *err)
{
    const struct vor_format *format = vor_format(run->output.format);
    struct vor_sink sink = vor_blob_sink(writer);
    struct vor_write_options options;
    vor_status status;

    vor_write_options_from(&options, &run->report.parameters, run->report.spacing_mean);
    status = format->write(&sink, cloud, &options, err);
    if (status == VOR_E_IO && vor_blob_failure(writer, err) == VOR_OK)
        return vor_fail(err, VOR_E_INTERNAL, "the %s writer gave up", format->label);
    return status;
}

/* Encodes the result and makes it durable. */
static vor_status encode(struct run *run, const struct vor_cloud *cloud, struct vor_error *err)
{
    double began = vor_clock_seconds();
    struct vor_blob_writer *writer;
    vor_status status;

    vor_job_stage(run->job, VOR_STAGE_ENCODE, vor_clock_wall_ms());
    run->output.format = (unsigned)run->view.spec.value[VOR_PARAM_FORMAT];
    run->output.points = cloud->n;
    status = vor_blob_create(run->worker->config.blobs, &writer, err);
    if (status != VOR_OK)
        return status;
    status = write_cloud(run, writer, cloud, err);
    if (status != VOR_OK) {
        vor_blob_discard(writer);
        return status;
    }
    run->output.bytes = vor_blob_size(writer);
    vor_blob_sha256(writer, run->output.sha256);
    status = vor_blob_commit(writer, &run->view.id, VOR_BLOB_CLOUD, err);
    run->report.seconds_write = vor_clock_seconds() - began;
    return status;
}

static vor_status execute(struct run *run, struct vor_error *err)
{
    struct vor_report *report;
    struct vor_artefacts out;
    vor_status status;

    vor_memory_init(&run->memory, run->worker->config.memory);
    vor_artefacts_init(&out, &run->memory);
    status = optimize(run, &out, err);
    report = vor_artefacts_values(&out, "report", &vor_report_members);
    if (report != NULL)
        run->report = *report;
    run->report.seconds_read = run->view.input[0].seconds;
    if (status == VOR_OK && vor_job_asked(run->job) == VOR_CANCEL)
        status = vor_fail(err, VOR_E_CANCELLED, "cancelled by the caller");
    if (status == VOR_OK)
        status = encode(run, vor_artefacts_cloud(&out, "cloud"), err);
    vor_artefacts_free(&out);
    run->report.memory_peak_bytes = atomic_load(&run->memory.peak);
    return status;
}

/* --- the end ---------------------------------------------------------------------------------- */

static void describe_success(struct run *run, struct vor_job_view *row)
{
    char steps[64];

    row->progress = 100;
    row->output[0] = run->output;
    /* The last record need not be that of the cloud that is handed out. */
    row->record.delta = run->report.delta;
    row->record.sigma = run->report.sigma;
    row->record.epsilon = run->report.epsilon;
    (void)snprintf(row->message, sizeof row->message, "%llu points after %s, delta %.4f",
                   (unsigned long long)run->output.points,
                   vor_report_steps(&run->report, steps, sizeof steps), run->report.delta);
}

static void describe_failure(struct vor_job_view *row, const struct vor_error *problem)
{
    row->problem = *problem;
    (void)snprintf(row->message, sizeof row->message, "%.*s", (int)sizeof row->message - 1,
                   problem->message);
}

/* Writes the last row once, of a success when problem is NULL; a failure asks for another try. */
static vor_status finish_once(struct run *run, const struct vor_error *problem, const char *report,
                              struct vor_error *err)
{
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
    row.output[1].bytes = report != NULL ? strlen(report) : 0;
    status = vor_worker_finish(run->worker, run->job, &row, run->attempt, report, &changed, err);
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
    struct vor_document document = {"report", &vor_report_members, &run->report};
    struct vor_text report;
    struct vor_error err;
    const char *json = NULL;

    vor_text_init(&report, 0);
    if (problem == NULL)
        vor_json_document(&report, &document);
    if (vor_text_status(&report, NULL) == VOR_OK)
        json = report.data; /* NULL when there is none */
    while (finish_once(run, problem, json, &err) != VOR_OK) {
        vor_log(VOR_LOG_ERROR, "the end of a job cannot be stored",
                VOR_TEXT("job", run->view.id.text), VOR_TEXT("error", err.message));
        if (vor_worker_pause(run->worker, retry_seconds))
            break;
    }
    vor_text_free(&report);
}

static int is_aborting(struct vor_worker *worker)
{
    int aborting;

    pthread_mutex_lock(&worker->mutex);
    aborting = worker->aborting;
    pthread_mutex_unlock(&worker->mutex);
    return aborting;
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
    vor_worker_drop(run->worker, &view.id, VOR_BLOB_INPUT);
    if (view.status != VOR_JOB_SUCCESSFUL)
        vor_worker_drop(run->worker, &view.id, VOR_BLOB_CLOUD);
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

    vor_job_view(job, &run.view);
    if (claim(&run)) {
        vor_log(VOR_LOG_INFO, "job started", VOR_TEXT("job", run.view.id.text),
                VOR_COUNT("attempt", run.attempt));
        vor_job_begin(job, vor_clock_wall_ms());
        status = execute(&run, &problem);
        if (status == VOR_E_CANCELLED && is_aborting(worker))
            give_back(&run);
        else
            finish(&run, status == VOR_OK ? NULL : &problem);
    }
    clean_up(&run, began);
}
