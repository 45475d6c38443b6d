#include "server/cli/commands.h"

#include "core/engine.h"
#include "proto/codec.h"
#include "proto/json/json.h"
#include "proto/limits.h"
#include "server/base/clock.h"
#include "server/base/flann_library.h"
#include "server/cli/cli_log.h"
#include "server/cli/files.h"
#include "server/cli/interrupt.h"
#include "server/cli/progress.h"

#include <stdio.h>
#include <string.h>

/* Where a run gets its threads and memory from. */
struct work {
    struct vor_memory memory; /* without a cap: it is the caller's own machine */
    struct vor_watch watch;   /* cancels on a signal, shows progress, knows the time */
    struct vor_run run;
    struct vor_limits limits;
};

static enum vor_answer on_poll(VOR_UNUSED void *ctx)
{
    if (vor_interrupt_seen())
        return VOR_CANCEL;
    return vor_interrupt_stops() ? VOR_STOP : VOR_CONTINUE;
}

static enum vor_answer on_progress(void *ctx, const struct vor_record *record)
{
    if (ctx != NULL)
        vor_progress_record(ctx, record);
    return on_poll(NULL);
}

static double on_clock(VOR_UNUSED void *ctx)
{
    return vor_clock_seconds();
}

/* Starts the threads. progress may be NULL. End with work_end, also after a failure. */
static vor_status work_start(struct work *work, const struct vor_cli *cli,
                             struct vor_progress *progress, struct vor_error *err)
{
    memset(work, 0, sizeof *work);
    vor_memory_init(&work->memory, SIZE_MAX);
    work->watch = (struct vor_watch){
        .ctx = progress, .progress = on_progress, .poll = on_poll, .clock = on_clock};
    work->run.memory = &work->memory;
    work->run.watch = &work->watch;
    work->limits = (struct vor_limits)VOR_LIMITS_DEFAULT;
    work->limits.points = VOR_POINTS_MAX;
    vor_limits_want(&work->limits, &cli->spec);
    return vor_pool_create(&work->run.pool, cli->threads, err);
}

static void work_end(struct work *work)
{
    vor_pool_destroy(work->run.pool);
    work->run.pool = NULL;
}

/* Reads and checks a cloud, of any size. cloud is initialised here; *format may be NULL. */
static vor_status work_load(struct work *work, struct vor_cloud *cloud,
                            const struct vor_format **format, const char *path,
                            struct vor_error *err)
{
    struct vor_input input;
    vor_status status;

    vor_cloud_init(cloud, &work->memory);
    status = vor_input_read(&input, path, err);
    VOR_THEN(status, vor_codec_read(cloud, format, input.bytes, input.size, &work->limits, err));
    vor_input_free(&input);
    return status;
}

/* --- frames of a sequence ----------------------------------------------------------------------
 */

static int has(const struct vor_attribute_names *names, const char *name)
{
    for (unsigned i = 0; i < names->count; i++)
        if (strcmp(names->name[i], name) == 0)
            return 1;
    return 0;
}

static void add(struct vor_attribute_names *names, const char *name)
{
    if (names->count < VOR_ATTRIBUTES_MAX && !has(names, name))
        memcpy(names->name[names->count++], name, strlen(name) + 1);
}

/* Takes the attributes of a frame: others is what some frames have and some not. */
static void take(struct vor_attribute_names *common, struct vor_attribute_names *others,
                 const struct vor_cloud *cloud, int is_first)
{
    unsigned kept = 0;

    for (size_t i = 0; i < cloud->attribute_count; i++) {
        const char *name = cloud->attributes[i].name;

        if (strcmp(name, VOR_TRACK) == 0)
            continue;
        if (is_first)
            add(common, name);
        else if (!has(common, name))
            add(others, name);
    }
    for (unsigned i = 0; i < common->count; i++) {
        if (vor_cloud_find_name(cloud, common->name[i]) == NULL)
            add(others, common->name[i]);
        else if (kept++ != i)
            memcpy(common->name[kept - 1], common->name[i], sizeof common->name[i]);
    }
    common->count = kept;
}

vor_status vor_sequence_common(struct vor_attribute_names *out, const struct vor_cli *cli,
                               struct vor_error *err)
{
    struct vor_attribute_names others = {.count = 0};
    char line[512] = "not all frames have these attributes, so no result has them: ";
    struct work work;
    int frames = 0;
    vor_status status = work_start(&work, cli, NULL, err);

    out->count = 0;
    for (int i = 0; status == VOR_OK && i < cli->operand_count && !vor_interrupt_seen(); i++) {
        struct vor_cloud cloud;
        struct vor_error why;

        if (work_load(&work, &cloud, NULL, cli->operands[i], &why) == VOR_OK)
            take(out, &others, &cloud, frames++ == 0);
        vor_cloud_free(&cloud);
    }
    work_end(&work);
    for (unsigned i = 0; i < others.count; i++)
        (void)snprintf(line + strlen(line), sizeof line - strlen(line), "%s%s", i > 0 ? ", " : "",
                       others.name[i]);
    if (status == VOR_OK && others.count > 0)
        vor_cli_say(cli->command->name, line);
    return status;
}

/* Frees the attributes of a cloud that are not among the names. */
static void keep_common(struct vor_cloud *cloud, const struct vor_attribute_names *names)
{
    size_t kept = 0;

    for (size_t i = 0; i < cloud->attribute_count; i++) {
        if (!has(names, cloud->attributes[i].name))
            vor_free(cloud->memory, cloud->attributes[i].data);
        else
            cloud->attributes[kept++] = cloud->attributes[i];
    }
    cloud->attribute_count = kept;
}

/* --- a run ------------------------------------------------------------------------------------ */

/* One run: whatever is at fault when it fails is named by `subject`. */
struct local_run {
    const struct vor_cli *cli;
    struct vor_spec spec; /* that of the command, with the format of the result */
    const char *subject;
    struct work work;
    struct vor_progress progress;
    struct vor_artefacts in, out;
    const struct vor_format *format; /* of the main input, then of the result */
    struct vor_result_facts facts;
    struct vor_output output;
    int replace;               /* a file that has the output's name */
    struct vor_report *report; /* among the outputs; NULL where the process has none */
    double seconds_read, seconds_write;
};

/* The inputs that files were given for, by the names of the process's row. */
static vor_status load(struct local_run *r, struct vor_error *err)
{
    const struct vor_artefact_info *inputs = r->cli->spec.process->inputs;
    double began = vor_clock_seconds();
    vor_status status = VOR_OK;

    vor_progress_note(&r->progress, "reading");
    for (unsigned i = 0; inputs[i].name != NULL && status == VOR_OK; i++) {
        struct vor_cloud cloud;

        if (r->cli->input[i] == NULL)
            continue;
        r->subject = r->cli->input[i];
        status = work_load(&r->work, &cloud, i == 0 ? &r->format : NULL, r->subject, err);
        if (i == 0 && r->cli->keep != NULL)
            keep_common(&cloud, r->cli->keep);
        vor_artefacts_put_cloud(&r->in, inputs[i].name, &cloud);
    }
    r->seconds_read = vor_clock_seconds() - began;
    return status;
}

static vor_status run(struct local_run *r, struct vor_error *err)
{
    const struct vor_artefact_info *inputs = r->cli->spec.process->inputs;
    const struct vor_cloud *cloud = vor_artefacts_cloud(&r->in, inputs[0].name);
    vor_status status;

    r->progress.eta.work =
        vor_eta_work_of(&r->cli->spec, cloud->n, vor_pool_threads(r->work.run.pool));
    vor_progress_note(&r->progress, "preparing");
    if (r->spec.process->methods != 0)
        vor_interrupt_keep_best();
    status = vor_engine_run(&r->out, &r->in, &r->spec, &r->work.run, err);
    if (status == VOR_E_INTERNAL && vor_flann_load(err) != VOR_OK)
        return err->status;
    for (unsigned i = 0; status != VOR_OK && inputs[i].name != NULL; i++)
        if (r->cli->input[i] != NULL && strcmp(err->parameter, inputs[i].name) == 0)
            r->subject = r->cli->input[i];
    if (status == VOR_OK)
        r->report = vor_artefacts_values(&r->out, "report", &vor_report_members);
    return status;
}

static vor_status save_cloud(struct local_run *r, const struct vor_artefact *result,
                             struct vor_error *err)
{
    struct vor_sink sink = {&r->output, vor_output_write};
    struct vor_write_options options;
    vor_status status;

    r->facts.spacing = r->report != NULL ? r->report->spacing_mean : 0;
    status = vor_write_options_from(&options, r->format, &r->spec, &r->facts, err);
    if (status != VOR_OK)
        return status;
    if (r->report != NULL)
        memcpy(r->report->origin, options.origin, sizeof r->report->origin);
    options.mesh = &result->mesh;
    return r->format->write(&sink, &result->cloud, &options, err);
}

static vor_status save_document(struct local_run *r, const struct vor_document *document,
                                struct vor_error *err)
{
    struct vor_text text;
    vor_status status;

    vor_text_init(&text, 0);
    vor_json_document(&text, document);
    vor_text_puts(&text, "\n");
    status = vor_text_status(&text, err);
    if (status == VOR_OK && vor_lines_wanted(r->cli))
        status = vor_lines_from_json(&text, r->cli, err);
    if (status == VOR_OK && vor_output_write(&r->output, text.data, text.size) != 0)
        status = vor_fail(err, VOR_E_IO, "the document cannot be written");
    vor_text_free(&text);
    return status;
}

/* The end of a run that has a report. */
static vor_status finish(struct local_run *r, struct vor_error *err)
{
    const struct vor_artefact *main = vor_artefacts_find(&r->out, r->spec.process->outputs[0].name);
    struct vor_text text;
    vor_status status;

    if (r->report == NULL)
        return VOR_OK;
    r->report->seconds_read = r->seconds_read;
    r->report->seconds_write = r->seconds_write;
    if (main->kind == VOR_ARTEFACT_CLOUD)
        vor_codec_report_dropped(r->report, &main->cloud, &main->mesh, r->format);
    vor_text_init(&text, 0);
    vor_json_document(&text, &vor_artefacts_find(&r->out, "report")->document);
    status = vor_text_status(&text, err);
    VOR_THEN(status, vor_progress_finish(&r->progress, text.data, text.size, err));
    vor_text_free(&text);
    return status;
}

/* The output is opened before the work begins: a name that cannot be written is told at once. */
static vor_status work(struct local_run *r, struct vor_error *err)
{
    const struct vor_format *by_suffix = vor_format_by_suffix(r->cli->option[VOR_OPTION_OUTPUT]);
    vor_status status;
    const struct vor_artefact *result;
    double began;

    r->subject = r->cli->option[VOR_OPTION_OUTPUT];
    status = vor_overwrite_check(r->cli, r->subject, &r->replace, err);
    VOR_THEN(status, load(r, err));
    if (status != VOR_OK)
        return status;
    if (vor_spec_given(&r->cli->spec, VOR_PARAM_FORMAT))
        r->format = vor_format((unsigned)r->cli->spec.value[VOR_PARAM_FORMAT]);
    else if (by_suffix != NULL)
        r->format = by_suffix;
    for (unsigned i = 0; vor_format(i) != NULL; i++)
        if (vor_format(i) == r->format && vor_process_takes(r->spec.process, VOR_PARAM_FORMAT))
            r->spec.value[VOR_PARAM_FORMAT] = i;
    if (r->spec.process->outputs[0].kind == VOR_ARTEFACT_CLOUD) {
        /* Refuses what can be refused before the work. */
        r->subject = r->cli->input[0];
        vor_extent_measure(&r->facts.input,
                           vor_artefacts_cloud(&r->in, r->spec.process->inputs[0].name));
        status = vor_write_check(r->format, &r->spec, &r->facts.input, err);
        if (status != VOR_OK)
            return status;
    }
    r->subject = r->cli->option[VOR_OPTION_OUTPUT];
    status = vor_output_open(&r->output, r->subject, r->replace, err);
    if (status != VOR_OK)
        return status;
    r->subject = r->cli->input[0];
    status = run(r, err);
    if (status != VOR_OK)
        return status;
    r->subject = r->cli->option[VOR_OPTION_OUTPUT];
    /* Writes the main output. */
    result = vor_artefacts_find(&r->out, r->cli->spec.process->outputs[0].name);
    began = vor_clock_seconds();
    status = result->kind == VOR_ARTEFACT_CLOUD ? save_cloud(r, result, err)
                                                : save_document(r, &result->document, err);
    if (status == VOR_E_IO)
        status = vor_output_fail(&r->output, err);
    VOR_THEN(status, vor_output_commit(&r->output, err));
    r->seconds_write = vor_clock_seconds() - began;
    return status == VOR_OK ? finish(r, err) : status;
}

int vor_cli_run_local(const struct vor_cli *cli)
{
    struct local_run r;
    struct vor_error err;
    vor_status status;

    memset(&r, 0, sizeof r);
    r.cli = cli;
    r.spec = cli->spec;
    r.subject = cli->input[0];
    vor_progress_start(&r.progress, cli);
    status = work_start(&r.work, cli, &r.progress, &err);
    vor_artefacts_init(&r.in, &r.work.memory);
    vor_artefacts_init(&r.out, &r.work.memory);
    VOR_THEN(status, work(&r, &err));
    vor_progress_clear(&r.progress);
    vor_output_abandon(&r.output);
    vor_artefacts_free(&r.in);
    vor_artefacts_free(&r.out);
    work_end(&r.work);
    if (status != VOR_OK)
        return vor_cli_fail(r.subject, &err);
    return vor_interrupt_stops() ? VOR_EXIT_INTERRUPTED : VOR_EXIT_OK;
}
