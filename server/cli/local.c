/* The commands that run a process of the request, done in this one; what measure shares. */
#include "proto/json/json.h"
#include "server/base/clock.h"
#include "server/cli/files.h"
#include "server/cli/work.h"

#include <stdio.h>
#include <string.h>

static enum vor_answer on_poll(void *ctx)
{
    (void)ctx;
    return vor_interrupt_seen() ? VOR_CANCEL : VOR_CONTINUE;
}

static enum vor_answer on_progress(void *ctx, const struct vor_record *record)
{
    if (ctx != NULL)
        vor_progress_record(ctx, record);
    return on_poll(NULL);
}

static double on_clock(void *ctx)
{
    (void)ctx;
    return vor_clock_seconds();
}

vor_status vor_work_start(struct vor_work *work, const struct vor_cli *cli,
                          struct vor_progress *progress, struct vor_error *err)
{
    memset(work, 0, sizeof *work);
    vor_memory_init(&work->memory, SIZE_MAX);
    work->watch = (struct vor_watch){progress, on_progress, on_poll, on_clock};
    work->run.memory = &work->memory;
    work->run.watch = &work->watch;
    return vor_pool_create(&work->run.pool, cli->threads, err);
}

void vor_work_end(struct vor_work *work)
{
    vor_pool_destroy(work->run.pool);
    work->run.pool = NULL;
}

vor_status vor_work_load(struct vor_work *work, struct vor_cloud *cloud,
                         const struct vor_format **format, const char *path, struct vor_error *err)
{
    struct vor_limits limits = VOR_LIMITS_DEFAULT;
    struct vor_input input;
    vor_status status;

    limits.points = VOR_POINTS_MAX;
    vor_cloud_init(cloud, &work->memory);
    status = vor_input_read(&input, path, err);
    if (status == VOR_OK)
        status = vor_codec_read(cloud, format, input.bytes, input.size, &limits, err);
    vor_input_free(&input);
    return status;
}

/* One run: whatever is at fault when it fails is named by `subject`. */
struct here {
    const struct vor_cli *cli;
    const char *subject;
    struct vor_work work;
    struct vor_progress progress;
    struct vor_cloud in, out;
    const struct vor_format *format; /* of the input, then of the result */
    struct vor_output output;
    struct vor_report report;
};

static const struct vor_format *format_of_result(const struct vor_cli *cli,
                                                 const struct vor_format *input)
{
    const struct vor_format *by_suffix = vor_format_by_suffix(cli->option[VOR_OPTION_OUTPUT]);

    if (vor_spec_given(&cli->spec, VOR_PARAM_FORMAT))
        return vor_format((unsigned)cli->spec.value[VOR_PARAM_FORMAT]);
    return by_suffix != NULL ? by_suffix : input;
}

static vor_status load(struct here *r, struct vor_error *err)
{
    double began = vor_clock_seconds();
    vor_status status;

    vor_progress_note(&r->progress, "reading");
    status = vor_work_load(&r->work, &r->in, &r->format, r->cli->input, err);
    r->report.seconds_read = vor_clock_seconds() - began;
    return status;
}

static vor_status run_engine(struct here *r, struct vor_error *err)
{
    double seconds_read = r->report.seconds_read;
    struct vor_artefacts in, out;
    const struct vor_report *report;
    vor_status status;

    vor_progress_note(&r->progress, "preparing");
    vor_artefacts_init(&in, &r->work.memory);
    vor_artefacts_init(&out, &r->work.memory);
    vor_artefacts_put_cloud(&in, "cloud", &r->in);
    status = vor_engine_run(&out, &in, &r->cli->spec, &r->work.run, err);
    vor_artefacts_free(&in);
    report = vor_artefacts_values(&out, "report", &vor_report_members);
    if (status == VOR_OK) {
        r->report = *report;
        r->out = *vor_artefacts_cloud(&out, "cloud");
        out.count = 0;
        vor_free(&r->work.memory, (void *)(uintptr_t)report);
    }
    vor_artefacts_free(&out);
    r->report.seconds_read = seconds_read;
    return status;
}

static vor_status save(struct here *r, struct vor_error *err)
{
    struct vor_sink sink = {&r->output, vor_output_write};
    struct vor_write_options options;
    double began = vor_clock_seconds();
    vor_status status;

    vor_write_options_from(&options, &r->cli->spec, r->report.spacing_mean);
    status = r->format->write(&sink, &r->out, &options, err);
    if (status == VOR_E_IO)
        status = vor_output_fail(&r->output, err);
    if (status == VOR_OK)
        status = vor_output_commit(&r->output, err);
    r->report.seconds_write = vor_clock_seconds() - began;
    return status;
}

static vor_status finish(struct here *r, struct vor_error *err)
{
    struct vor_document report = {"report", &vor_report_members, &r->report};
    struct vor_text text;
    vor_status status;

    r->report.parameters.value[VOR_PARAM_FORMAT] =
        r->format == vor_format(VOR_FORMAT_DRC) ? VOR_FORMAT_DRC : VOR_FORMAT_PLY;
    vor_text_init(&text, 0);
    vor_json_document(&text, &report);
    status = vor_text_status(&text, err);
    if (status == VOR_OK)
        status = vor_progress_finish(&r->progress, text.data, text.size, err);
    vor_text_free(&text);
    return status;
}

/* The output is opened before the work begins: a name that cannot be written is told at once. */
static vor_status work(struct here *r, struct vor_error *err)
{
    vor_status status = load(r, err);

    if (status != VOR_OK)
        return status;
    r->format = format_of_result(r->cli, r->format);
    r->subject = r->cli->option[VOR_OPTION_OUTPUT];
    status = vor_output_open(&r->output, r->subject, err);
    if (status != VOR_OK)
        return status;
    r->subject = r->cli->input;
    status = run_engine(r, err);
    if (status != VOR_OK)
        return status;
    r->subject = r->cli->option[VOR_OPTION_OUTPUT];
    status = save(r, err);
    return status == VOR_OK ? finish(r, err) : status;
}

int vor_cli_process_here(const struct vor_cli *cli)
{
    struct here r;
    struct vor_error err;
    vor_status status;

    memset(&r, 0, sizeof r);
    r.cli = cli;
    r.subject = cli->input;
    vor_progress_start(&r.progress, cli);
    status = vor_work_start(&r.work, cli, &r.progress, &err);
    vor_cloud_init(&r.in, &r.work.memory);
    vor_cloud_init(&r.out, &r.work.memory);
    if (status == VOR_OK)
        status = work(&r, &err);
    vor_progress_clear(&r.progress);
    vor_output_abandon(&r.output);
    vor_cloud_free(&r.in);
    vor_cloud_free(&r.out);
    vor_work_end(&r.work);
    return status == VOR_OK ? VOR_EXIT_OK : vor_cli_fail(r.subject, &err);
}
