/* voronoid PROCESS --server URL: the same job, done by a daemon. The body goes up, the events come
 * back, and when they end, the result; ^C dismisses the job. voronoid submit: only the first of
 * these. */
#include "server/cli/commands.h"

#include "core/base/utf8.h"
#include "proto/codec.h"
#include "server/cli/cli_log.h"
#include "server/cli/files.h"
#include "server/cli/follow.h"
#include "server/cli/interrupt.h"
#include "server/store/row.h"

#include <string.h>
#include <sys/stat.h>

struct remote_run {
    struct vor_follow follow;
    struct vor_output output;
    struct vor_input in_memory[VOR_INPUTS_MAX]; /* inputs whose length no file tells */
};

static void add_pair(struct vor_text *url, const char *separator, enum vor_parameter parameter,
                     const char *value)
{
    vor_text_printf(url, "%s%s=", separator, vor_parameter_info(parameter)->name);
    vor_text_escape(url, value);
}

/* Sends only the parameters that were given: the server's own defaults hold for the rest. The
 * format follows the suffix of the output, as it does here. The job's name is that of --name, else
 * that of its input's file where a job may have it. */
static void build_url(struct vor_text *url, const struct vor_follow *follow)
{
    const struct vor_cli *cli = follow->cli;
    const char *separator = "?", *output = cli->option[VOR_OPTION_OUTPUT];
    const char *name = cli->option[VOR_OPTION_NAME], *slash = strrchr(cli->input[0], '/');
    long count;
    const struct vor_process_info *process = cli->spec.process;
    const struct vor_format *format = output != NULL ? vor_format_by_suffix(output) : NULL;
    char value[VOR_SPEC_VALUE_SIZE];

    vor_text_printf(url, "%s/v1/%s", follow->server, process->id);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;

        if (cli->given[i])
            add_pair(url, separator, parameter, vor_spec_text(&cli->spec, parameter, value));
        else if (i == VOR_PARAM_FORMAT && format != NULL && vor_process_takes(process, parameter))
            add_pair(url, separator, parameter, format->name);
        else
            continue;
        separator = "&";
    }
    if (name == NULL) {
        name = slash != NULL ? slash + 1 : cli->input[0];
        count = vor_utf8_count(name);
        if (strcmp(name, "-") == 0 || count < 1 || count > VOR_JOB_NAME_CHARACTERS)
            name = NULL;
    }
    if (name != NULL) {
        vor_text_printf(url, "%sname=", separator);
        vor_text_escape(url, name);
    }
}

/* One input: a regular file as it lies on the disk, everything else through memory, because its
 * length must be known. NULL after a failure. */
static FILE *open_input(struct remote_run *t, unsigned i, int64_t *size)
{
    const char *path = t->follow.cli->input[i];
    struct vor_input *in_memory = &t->in_memory[i];
    FILE *file = NULL;
    struct stat info;

    if (strcmp(path, "-") != 0 && stat(path, &info) == 0 && S_ISREG(info.st_mode))
        file = fopen(path, "rb");
    if (file != NULL) {
        *size = info.st_size;
        return file;
    }
    if (vor_input_read(in_memory, path, &t->follow.err) != VOR_OK)
        return NULL;
    *size = (int64_t)in_memory->size;
    file = fmemopen(in_memory->bytes, in_memory->size, "rb");
    if (file == NULL)
        (void)vor_fail(&t->follow.err, VOR_E_EMPTY, "the input is empty: 0 bytes");
    return file;
}

/* *info is the job's first statusInfo, NULL when the daemon told none. */
static int submit_body(struct vor_follow *follow, struct vor_remote_call *call,
                       struct vor_json **info)
{
    const char *type = call->files == 1 ? "Content-Type: application/octet-stream" : NULL;
    const char *const headers[] = {"Prefer: respond-async", type, NULL}; /* of a form: curl's */
    int code;

    call->method = "POST";
    call->headers = headers;
    code = vor_follow_perform(follow, call, 201, 0);
    if (code == VOR_EXIT_OK && call->location[0] == '\0') {
        vor_progress_clear(&follow->progress);
        vor_cli_say(follow->subject, "the server responded with 201");
        code = VOR_EXIT_FAILED;
    }
    if (code == VOR_EXIT_OK) {
        memcpy(follow->job, call->location, sizeof follow->job);
        *info = vor_remote_json(call);
    }
    vor_text_free(&call->text);
    return code;
}

static int submit(struct remote_run *t, struct vor_json **info)
{
    struct vor_remote_call call = {.files = 0};
    const struct vor_cli *cli = t->follow.cli;
    const struct vor_artefact_info *inputs = cli->spec.process->inputs;
    int code = VOR_EXIT_OK;

    *info = NULL;
    for (unsigned i = 0; inputs[i].name != NULL && code == VOR_EXIT_OK; i++) {
        int64_t size = 0;
        FILE *bytes = cli->input[i] != NULL ? open_input(t, i, &size) : NULL;

        if (bytes != NULL)
            call.file[call.files++] = (struct vor_remote_file){inputs[i].name, bytes, size};
        else if (cli->input[i] != NULL)
            code = vor_cli_fail(cli->input[i], &t->follow.err);
    }
    if (code == VOR_EXIT_OK) {
        struct vor_follow *follow = &t->follow;
        struct vor_text url;

        vor_progress_note(&follow->progress, "sending");
        vor_text_init(&url, VOR_REMOTE_URL_MAX - 1);
        build_url(&url, follow);
        call.url = url.data;
        if (vor_text_status(&url, &follow->err) == VOR_OK)
            code = submit_body(follow, &call, info);
        else
            code = vor_cli_fail(follow->server, &follow->err);
        vor_text_free(&url);
    }
    for (unsigned i = 0; i < call.files; i++)
        (void)fclose(call.file[i].bytes);
    for (unsigned i = 0; i < VOR_INPUTS_MAX; i++)
        vor_input_free(&t->in_memory[i]);
    return code;
}

static int fetch_main(struct remote_run *t)
{
    struct vor_follow *follow = &t->follow;
    const struct vor_cli *cli = follow->cli;
    int in_lines = vor_lines_wanted(cli);
    char url[VOR_REMOTE_URL_MAX + 64];
    struct vor_remote_call call = {.method = "GET",
                                   .url = url,
                                   .goes_there = 1,
                                   .take = in_lines ? NULL : vor_output_write,
                                   .ctx = &t->output,
                                   .stall_seconds = VOR_FOLLOW_STALL_SECONDS};
    int code = VOR_EXIT_OK;

    (void)snprintf(url, sizeof url, "%s/results/%s", follow->job,
                   cli->spec.process->outputs[0].name);
    vor_progress_note(&follow->progress, "receiving");
    code = vor_follow_perform(follow, &call, 200, 0);
    if (code == VOR_EXIT_OK &&
        ((call.was_stopped && vor_output_fail(&t->output, &follow->err) != VOR_OK) ||
         (in_lines && vor_lines_from_json(&call.text, cli, &follow->err) != VOR_OK) ||
         (in_lines && vor_output_write(&t->output, call.text.data, call.text.size) != 0 &&
          vor_output_fail(&t->output, &follow->err) != VOR_OK) ||
         /* A document of a daemon is one line without its end, as the body of an answer. */
         (!in_lines && cli->spec.process->outputs[0].kind == VOR_ARTEFACT_DOCUMENT &&
          vor_output_write(&t->output, "\n", 1) != 0 &&
          vor_output_fail(&t->output, &follow->err) != VOR_OK) ||
         vor_output_commit(&t->output, &follow->err) != VOR_OK))
        code = vor_cli_fail(cli->option[VOR_OPTION_OUTPUT], &follow->err);
    vor_text_free(&call.text);
    return code;
}

static int work(struct remote_run *t)
{
    struct vor_follow *follow = &t->follow;
    struct vor_json *info;
    int code = submit(t, &info);

    vor_json_free(info);
    if (follow->cli->spec.process->methods != 0)
        vor_interrupt_keep_best();
    if (code == VOR_EXIT_OK)
        code = vor_follow_end(follow);
    if (code == VOR_EXIT_OK)
        code = fetch_main(t);
    if (code == VOR_EXIT_OK)
        code = vor_follow_report(follow);
    if (code == VOR_EXIT_OK && vor_interrupt_stops())
        code = VOR_EXIT_INTERRUPTED;
    if ((vor_interrupt_seen() || code == VOR_EXIT_INTERRUPTED) && follow->job[0] != '\0' &&
        !vor_follow_is_over(follow)) {
        struct vor_remote_call call = {.method = "DELETE",
                                       .url = follow->job,
                                       .timeout_seconds = VOR_FOLLOW_LAST_SECONDS,
                                       .is_last_word = 1};

        /* After ^C: nobody waits for the result any more. */
        if (vor_remote_perform(follow->remote, &call, &follow->err) != VOR_OK || call.http >= 300)
            vor_cli_say(follow->job, "the job could not be dismissed");
        vor_text_free(&call.text);
    }
    return code;
}

int vor_cli_run_remote(const struct vor_cli *cli)
{
    const char *output = cli->option[VOR_OPTION_OUTPUT];
    struct remote_run t;
    int code, replace;

    memset(&t, 0, sizeof t);
    code = vor_follow_open(&t.follow, cli, cli->input[0]);
    if (code == VOR_EXIT_OK &&
        (vor_overwrite_check(cli, output, &replace, &t.follow.err) != VOR_OK ||
         vor_output_open(&t.output, output, replace, &t.follow.err) != VOR_OK))
        code = vor_cli_fail(output, &t.follow.err);
    else if (code == VOR_EXIT_OK)
        code = work(&t);
    vor_progress_clear(&t.follow.progress);
    vor_output_abandon(&t.output);
    vor_follow_close(&t.follow);
    return code;
}

static int submit_one(const struct vor_cli *cli, int index, VOR_UNUSED void *ctx)
{
    const char *input = cli->operands[index];
    struct vor_cli one = *cli;
    struct vor_json *info = NULL;
    struct remote_run t;
    int code;

    memset(&t, 0, sizeof t);
    one.input[0] = input;
    code = vor_follow_open(&t.follow, &one, input);
    if (code == VOR_EXIT_OK)
        code = submit(&t, &info);
    vor_progress_clear(&t.follow.progress);
    if (code == VOR_EXIT_OK) {
        struct vor_text text;

        /* The line that a script reads: the ID, or with --json all that the daemon said of the job.
         */
        vor_text_init(&text, 0);
        if (cli->option[VOR_OPTION_JSON] != NULL)
            vor_json_copy(&text, info);
        else
            vor_text_puts(&text, vor_follow_text(info, "jobID"));
        if (!text.failed && text.data != NULL)
            (void)puts(text.data);
        (void)fflush(stdout);
        vor_text_free(&text);
    }
    vor_json_free(info);
    vor_follow_close(&t.follow);
    return code == VOR_EXIT_OK && ferror(stdout) ? VOR_EXIT_FAILED : code;
}

int vor_cli_submit(const struct vor_cli *cli)
{
    return vor_cli_each(cli, submit_one, NULL);
}
