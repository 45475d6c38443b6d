#include "server/work/execute.h"

#include "core/engine.h"
#include "proto/codec.h"
#include "proto/json/json.h"
#include "server/base/build.h"
#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/blob/blob.h"
#include "server/work/artefacts.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static const double retry_seconds = 1;      /* while the disk is full */
static const double retry_seconds_max = 16; /* at most, as encoding costs cores */

struct run {
    const struct vor_order *order;
    const struct vor_listener *listener;
    struct vor_pool *pool;
    const struct vor_codec_place *codec; /* where clouds are encoded */
    struct vor_run_result *result;
    struct vor_text *kept;
    struct vor_memory memory;
    struct vor_result_facts facts;
    double shown;     /* when its points were last shown; 0 for never */
    double origin[3]; /* of the main input, that positions are relative to */
};

/* --- the engine's questions ------------------------------------------------------------------- */

static enum vor_answer asked(void *ctx)
{
    const struct vor_listener *listener = ((struct run *)ctx)->listener;

    return listener->asked(listener->ctx);
}

static double read_clock(VOR_UNUSED void *ctx)
{
    return vor_clock_seconds();
}

static void say(const struct run *run, enum vor_said what, const void *of)
{
    run->listener->said(run->listener->ctx, what, of);
}

static enum vor_answer take_progress(void *ctx, const struct vor_record *record)
{
    say(ctx, VOR_SAID_RECORD, record);
    return asked(ctx);
}

static void take_points(void *ctx, const struct vor_moving *points, const struct vor_record *record)
{
    struct run *run = ctx;
    const struct vor_listener *listener = run->listener;
    struct vor_shown shown = {
        .moving = *points, .iteration = record->iteration, .polish = record->polish};
    double now;

    if (listener->is_looked_at == NULL || !listener->is_looked_at(listener->ctx))
        return;
    now = vor_clock_seconds();
    if (run->shown > 0 && now - run->shown < VOR_PREVIEW_SECONDS)
        return;
    run->shown = now;
    memcpy(shown.origin, run->origin, sizeof shown.origin);
    say(run, VOR_SAID_POINTS, &shown);
}

/* --- checkpoints ------------------------------------------------------------------------------ */

/* Before a checkpoint in its file: another engine would have other bytes. */
enum { ENGINE_SIZE = sizeof((struct vor_build *)0)->engine };

static void take_checkpoint(void *ctx, const struct vor_part *part, unsigned parts)
{
    const struct vor_listener *listener = ((struct run *)ctx)->listener;
    const struct vor_build build = vor_build_own();
    struct vor_job_output file = {.bytes = 0};
    struct vor_blob_writer *writer;
    vor_status status = VOR_E_NOMEM;
    int fd;

    if (parts == 0)
        say(ctx, VOR_SAID_RESUMED, "");
    fd = parts > 0 && listener->file != NULL ? listener->file(listener->ctx) : -1;
    if (fd < 0)
        return;
    writer = vor_blob_borrow(fd);
    if (writer != NULL)
        status = vor_blob_append(writer, build.engine, ENGINE_SIZE, NULL);
    for (unsigned i = 0; i < parts && status == VOR_OK; i++)
        if (part[i].size > 0)
            status = vor_blob_append(writer, part[i].bytes, part[i].size, NULL);
    if (status == VOR_OK) {
        file.bytes = vor_blob_size(writer);
        vor_blob_sha256(writer, file.sha256);
    }
    vor_blob_discard(writer);
    say(ctx, VOR_SAID_CHECKPOINT, &file);
}

/* Maps the checkpoint that the run may go on from; size 0 for none. */
static struct vor_part map_saved(const struct vor_order *order)
{
    const struct vor_build build = vor_build_own();
    struct vor_part all = {.size = 0};
    struct stat info;

    if (order->saved < 0 || fstat(order->saved, &info) != 0 || info.st_size <= ENGINE_SIZE)
        return all;
    all.bytes = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, order->saved, 0);
    if (all.bytes != MAP_FAILED)
        all.size = (size_t)info.st_size;
    if (all.size > 0 && memcmp(all.bytes, build.engine, ENGINE_SIZE) != 0) {
        (void)munmap(all.bytes, all.size);
        all.size = 0;
    }
    return all;
}

/* --- the three steps -------------------------------------------------------------------------- */

/* Runs the engine on the inputs. */
static vor_status compute(struct run *run, struct vor_artefacts *out, struct vor_error *err)
{
    const struct vor_spec *spec = &run->order->spec;
    struct vor_watch watch = {.ctx = run,
                              .progress = take_progress,
                              .poll = asked,
                              .points = take_points,
                              .checkpoint = take_checkpoint,
                              .clock = read_clock};
    struct vor_run engine = {
        .pool = run->pool, .memory = &run->memory, .watch = &watch, .every = run->order->every};
    struct vor_part saved = map_saved(run->order);
    struct vor_artefacts in;
    vor_status status;

    vor_artefacts_init(&in, &run->memory);
    status = vor_artefacts_load(&in, spec->process, run->order->input, err);
    if (status == VOR_OK) {
        const struct vor_cloud *cloud = vor_artefacts_cloud(&in, spec->process->inputs[0].name);

        vor_extent_measure(&run->facts.input, cloud);
        memcpy(run->origin, cloud->origin, sizeof run->origin);
        if (saved.size > 0)
            engine.saved =
                (struct vor_part){(char *)saved.bytes + ENGINE_SIZE, saved.size - ENGINE_SIZE};
        status = vor_engine_run(out, &in, spec, &engine, err);
    }
    vor_artefacts_free(&in);
    if (saved.size > 0)
        (void)munmap(saved.bytes, saved.size);
    return status;
}

/* Nobody waits for the result of a run that is cancelled. */
static int has_left(void *ctx)
{
    return asked(ctx) == VOR_CANCEL;
}

/* Writes the outputs that have a file. */
static vor_status try_files(struct run *run, const struct vor_artefacts *out, struct vor_error *err)
{
    const struct vor_order *order = run->order;
    const struct vor_artefact_info *outputs = order->spec.process->outputs;
    struct vor_codec_place place = *run->codec;
    const struct vor_writing writing = {order, &run->facts, &place};
    vor_status status = VOR_OK;

    place.has_left = has_left;
    place.ctx = run;
    for (unsigned i = 0; outputs[i].name != NULL && status == VOR_OK; i++) {
        if (order->output[i] < 0)
            continue;
        if (ftruncate(order->output[i], 0) != 0 || lseek(order->output[i], 0, SEEK_SET) != 0)
            return vor_fail_errno(err, errno, "an output"); /* of the try before */
        status = vor_artefact_write(&run->result->output[i], &writing, i,
                                    vor_artefacts_find(out, outputs[i].name), err);
    }
    return status;
}

/* The same, however long the disk is full, unless the run is cancelled. */
static vor_status write_files(struct run *run, const struct vor_artefacts *out,
                              struct vor_error *err)
{
    const struct timespec look = {0, 20 * 1000 * 1000};
    double pause = retry_seconds;

    for (;;) {
        vor_status status = try_files(run, out, err);
        double until = vor_clock_seconds() + pause;

        if (status != VOR_E_IO || !vor_error_storage_full(err))
            return status;
        say(run, VOR_SAID_WAITS, err);
        while (asked(run) != VOR_CANCEL && vor_clock_seconds() < until)
            (void)nanosleep(&look, NULL);
        if (asked(run) == VOR_CANCEL)
            return vor_fail(err, VOR_E_CANCELLED, "cancelled while the disk was full");
        pause *= pause < retry_seconds_max ? 2 : 1;
    }
}

/* "300 points after 12 iterations, delta 0.0212" of a run that spreads points; else what the main
 * output is. */
static void describe(struct run *run, const struct vor_report *report)
{
    const struct vor_process_info *process = run->order->spec.process;
    const struct vor_artefact_info *main = &process->outputs[0];
    struct vor_run_result *result = run->result;
    unsigned long long points = (unsigned long long)result->output[0].points;
    const char *plural = points == 1 ? "" : "s";
    char steps[64];

    if (report != NULL && vor_process_takes(process, VOR_PARAM_POINTS))
        (void)snprintf(result->message, sizeof result->message, "%llu point%s after %s, delta %.4f",
                       points, plural, vor_report_steps(report, steps, sizeof steps),
                       report->delta);
    else if (main->kind == VOR_ARTEFACT_CLOUD)
        (void)snprintf(result->message, sizeof result->message, "%llu point%s", points, plural);
    else
        (void)snprintf(result->message, sizeof result->message, "%s is ready, %llu bytes",
                       main->name, (unsigned long long)result->output[0].bytes);
}

static vor_status save(struct run *run, struct vor_artefacts *out, struct vor_error *err)
{
    const struct vor_artefact_info *outputs = run->order->spec.process->outputs;
    struct vor_report *report = vor_artefacts_values(out, "report", &vor_report_members);
    double began = vor_clock_seconds();
    vor_status status;
    const struct vor_job_output *first;
    const struct vor_artefact *main;

    say(run, VOR_SAID_STAGE, &(const enum vor_stage){VOR_STAGE_ENCODE});
    run->facts.spacing = report != NULL ? report->spacing_mean : 0;
    status = write_files(run, out, err);
    if (status != VOR_OK)
        return status;
    if (report != NULL) {
        /* What the engine cannot know. */
        first = &run->result->output[0];
        main = vor_artefacts_find(out, outputs[0].name);
        if (main->kind == VOR_ARTEFACT_CLOUD)
            vor_codec_report_dropped(report, &main->cloud, &main->mesh, vor_format(first->format));
        report->seconds_read = run->order->seconds_read;
        report->seconds_write = vor_clock_seconds() - began;
        report->memory_peak_bytes = atomic_load(&run->memory.peak);
        memcpy(report->origin, first->origin, sizeof report->origin);
        run->result->has_report = 1;
        run->result->report = *report;
    }
    describe(run, report);
    for (unsigned i = 0; outputs[i].name != NULL; i++) {
        if (!vor_output_in_row(&outputs[i]))
            continue;
        vor_json_document(run->kept, &vor_artefacts_find(out, outputs[i].name)->document);
        run->result->output[i].bytes = run->kept->size;
    }
    return vor_text_status(run->kept, err);
}

vor_status vor_execute(struct vor_run_result *result, struct vor_text *kept,
                       const struct vor_order *order, const struct vor_run_means *means,
                       const struct vor_listener *listener, struct vor_error *err)
{
    struct run run = {.order = order,
                      .listener = listener,
                      .pool = means->pool,
                      .codec = &means->codec,
                      .result = result,
                      .kept = kept};
    struct vor_artefacts out;
    vor_status status;

    *result = (struct vor_run_result){.has_report = 0};
    vor_memory_init(&run.memory, order->memory);
    vor_artefacts_init(&out, &run.memory);
    status = compute(&run, &out, err);
    if (status == VOR_OK && asked(&run) == VOR_CANCEL)
        status = vor_fail(err, VOR_E_CANCELLED, "cancelled by the caller");
    VOR_THEN(status, save(&run, &out, err));
    vor_artefacts_free(&out);
    return status;
}
