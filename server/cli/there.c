/* voronoid PROCESS --server URL: the same job, done by a daemon. The body goes up, the events come
 * back, and when they end, the result. A stream that breaks off is taken up where it ended; ^C
 * dismisses the job. */
#include "server/cli/there.h"

#include "proto/codec.h"
#include "proto/sse.h"
#include "server/base/clock.h"
#include "server/cli/files.h"
#include "server/cli/interrupt.h"
#include "server/cli/lines.h"
#include "server/cli/progress.h"
#include "server/cli/remote.h"
#include "server/cli/say.h"

#include <string.h>
#include <sys/stat.h>
#include <time.h>

/* Most tries in a row to reach a server that does not answer. */
#define TRIES_MAX 5
#define RETRY_MS_DEFAULT 2000
#define STALL_SECONDS 120
#define LAST_WORD_SECONDS 5

struct there {
    const struct vor_cli *cli;
    struct vor_remote *remote;
    struct vor_progress progress;
    struct vor_output output;
    struct vor_input stdin_bytes;
    struct vor_sse_parser parser;
    char job[VOR_REMOTE_URL_MAX]; /* "" before there is one */
    char status[32];              /* of the job, as far as known */
    struct vor_error err;
};

static int is_over(const struct there *t)
{
    return strcmp(t->status, "successful") == 0 || strcmp(t->status, "failed") == 0 ||
           strcmp(t->status, "dismissed") == 0;
}

static const char *server_of(const struct there *t)
{
    return t->job[0] != '\0' ? t->job : t->cli->option[VOR_OPTION_SERVER];
}

/* A call that got no answer: our own signal, or a server that is not there. */
static int no_answer(struct there *t)
{
    vor_progress_clear(&t->progress);
    if (vor_interrupt_seen()) {
        (void)vor_fail(&t->err, VOR_E_CANCELLED, "cancelled");
        return vor_cli_fail(t->cli->input[0], &t->err);
    }
    vor_cli_say(server_of(t), t->err.message);
    return VOR_EXIT_UNREACHABLE;
}

static const char *text_at(const struct vor_json *json, const char *name)
{
    const char *text = vor_json_get_string(vor_json_get(json, name));

    return text != NULL ? text : "";
}

/* Says a problem in one line. If json is no problem, says the status alone. */
static int say_problem(struct there *t, const struct vor_json *json, int http)
{
    const char *title = text_at(json, "title"), *detail = text_at(json, "detail");
    struct vor_text line;
    double number;

    if (vor_json_get_number(vor_json_get(json, "status"), &number) && number >= 100 && number < 600)
        http = (int)number;
    vor_text_init(&line, 0);
    if (title[0] == '\0')
        vor_text_printf(&line, "the server answered %d", http);
    else
        vor_text_printf(&line, "%s%s%s", title, detail[0] != '\0' ? ": " : "", detail);
    vor_progress_clear(&t->progress);
    vor_cli_say(t->cli->input[0], line.data != NULL ? line.data : title);
    vor_text_free(&line);
    return vor_cli_exit_code(http, text_at(json, "type"));
}

static int refused(struct there *t, const struct vor_remote_call *call)
{
    struct vor_json *json = vor_remote_json(call);
    int code = say_problem(t, json, call->http);

    vor_json_free(json);
    return code == VOR_EXIT_OK ? VOR_EXIT_FAILED : code;
}

static void append_escaped(struct vor_text *url, const char *text)
{
    static const char plain[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";

    for (; *text != '\0'; text++) {
        if (strchr(plain, *text) != NULL)
            vor_text_add(url, text, 1);
        else
            vor_text_printf(url, "%%%02X", (unsigned char)*text);
    }
}

static void add_pair(struct vor_text *url, const char *separator, enum vor_parameter parameter,
                     const char *value)
{
    vor_text_printf(url, "%s%s=", separator, vor_parameter_info(parameter)->name);
    append_escaped(url, value);
}

/* Sends only the parameters that were given: the server's own defaults hold for the rest. The
 * format follows the suffix of the output, as it does here. */
static void build_url(struct vor_text *url, const struct vor_cli *cli)
{
    const char *server = cli->option[VOR_OPTION_SERVER], *separator = "?";
    const char *name = cli->option[VOR_OPTION_NAME];
    const struct vor_process_info *process = cli->spec.process;
    const struct vor_format *format = vor_format_by_suffix(cli->option[VOR_OPTION_OUTPUT]);
    size_t length = strlen(server);
    char value[VOR_SPEC_VALUE_SIZE];

    while (length > 0 && server[length - 1] == '/')
        length--;
    vor_text_add(url, server, length);
    vor_text_printf(url, "/v1/%s", process->id);
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
    if (name != NULL) {
        vor_text_printf(url, "%sname=", separator);
        append_escaped(url, name);
    }
}

/* The body: a regular file as it lies on the disk, everything else through memory, because its
 * length must be known. */
static vor_status open_body(struct there *t, FILE **body, int64_t *size)
{
    const char *path = t->cli->input[0];
    struct stat info;
    vor_status status;

    *body = NULL;
    if (strcmp(path, "-") != 0 && stat(path, &info) == 0 && S_ISREG(info.st_mode)) {
        *body = fopen(path, "rb");
        if (*body != NULL) {
            *size = info.st_size;
            return VOR_OK;
        }
    }
    status = vor_input_read(&t->stdin_bytes, path, &t->err);
    if (status != VOR_OK)
        return status;
    *size = (int64_t)t->stdin_bytes.size;
    *body = fmemopen(t->stdin_bytes.bytes, t->stdin_bytes.size, "rb");
    return *body != NULL ? VOR_OK
                         : vor_fail(&t->err, VOR_E_EMPTY, "there is nothing to read: 0 bytes");
}

static int submit_body(struct there *t, const char *url, FILE *body, int64_t size)
{
    static const char *const headers[] = {"Prefer: respond-async",
                                          "Content-Type: application/octet-stream", NULL};
    struct vor_remote_call call = {
        .method = "POST", .url = url, .headers = headers, .body = body, .body_size = size};
    int code = VOR_EXIT_OK;

    if (vor_remote_perform(t->remote, &call, &t->err) != VOR_OK)
        code = no_answer(t);
    else if (call.http != 201 || call.location[0] == '\0')
        code = refused(t, &call);
    else
        memcpy(t->job, call.location, sizeof t->job);
    vor_text_free(&call.text);
    return code;
}

static int submit(struct there *t)
{
    struct vor_text url;
    FILE *body = NULL;
    int64_t size = 0;
    int code;

    if (open_body(t, &body, &size) != VOR_OK)
        return vor_cli_fail(t->cli->input[0], &t->err);
    vor_progress_note(&t->progress, "sending");
    vor_text_init(&url, VOR_REMOTE_URL_MAX - 1);
    build_url(&url, t->cli);
    if (vor_text_status(&url, &t->err) == VOR_OK)
        code = submit_body(t, url.data, body, size);
    else
        code = vor_cli_fail(t->cli->option[VOR_OPTION_SERVER], &t->err);
    vor_text_free(&url);
    (void)fclose(body);
    vor_input_free(&t->stdin_bytes);
    return code;
}

static void show_status(struct there *t, const struct vor_json *json)
{
    const struct vor_json *own = vor_json_get(json, "voronoid");
    char note[64];
    double position;

    if (vor_json_get_number(vor_json_get(own, "queuePosition"), &position))
        (void)snprintf(note, sizeof note, "waiting, %.0f before it", position);
    else
        (void)snprintf(note, sizeof note, "%.31s %.31s", text_at(json, "status"),
                       text_at(own, "stage"));
    vor_progress_note(&t->progress, note);
}

static void keep_status(struct there *t, const struct vor_json *json)
{
    (void)snprintf(t->status, sizeof t->status, "%s", text_at(json, "status"));
}

static int on_event(void *ctx, const struct vor_sse_arrival *event)
{
    struct there *t = ctx;
    struct vor_json *json = NULL;

    if (vor_json_parse(&json, event->data, event->size, NULL) != VOR_OK)
        return 0;
    if (strcmp(event->name, "progress") == 0)
        vor_progress_event(&t->progress, json);
    else if (strcmp(event->name, "replaced") == 0)
        t->progress.pace = (struct vor_pace){0};
    else if (strcmp(event->name, "status") == 0)
        show_status(t, json);
    else if (strcmp(event->name, "end") == 0)
        keep_status(t, json);
    vor_json_free(json);
    return is_over(t);
}

static int on_stream(void *ctx, const void *bytes, size_t size)
{
    struct there *t = ctx;

    return vor_sse_feed(&t->parser, bytes, size, &t->err) != VOR_OK;
}

/* Listens until the stream ends, for whatever reason: what became of the job is asked for next. */
static vor_status listen(struct there *t)
{
    char url[VOR_REMOTE_URL_MAX + 16], last_id[256];
    const char *headers[] = {"Accept: text/event-stream", NULL, NULL};
    struct vor_remote_call call = {.method = "GET",
                                   .url = url,
                                   .headers = headers,
                                   .take = on_stream,
                                   .ctx = t,
                                   .stall_seconds = STALL_SECONDS};
    vor_status status;

    (void)snprintf(url, sizeof url, "%s/events", t->job);
    (void)snprintf(last_id, sizeof last_id, "Last-Event-ID: %.200s",
                   vor_sse_parser_last_id(&t->parser));
    if (vor_sse_parser_last_id(&t->parser)[0] != '\0')
        headers[1] = last_id;
    vor_sse_parser_restart(&t->parser);
    status = vor_remote_perform(t->remote, &call, &t->err);
    vor_text_free(&call.text);
    return status;
}

/* Asks how the job is doing; *json is its statusInfo. Says a refusal and returns its exit code. */
static int ask(struct there *t, struct vor_json **json, vor_status *status)
{
    struct vor_remote_call call = {.method = "GET", .url = t->job, .timeout_seconds = 30};
    int code = VOR_EXIT_OK;

    *json = NULL;
    *status = vor_remote_perform(t->remote, &call, &t->err);
    if (*status == VOR_OK && call.http == 503)
        *status = vor_fail(&t->err, VOR_E_IO, "the server answered 503");
    if (*status == VOR_OK && call.http != 200)
        code = refused(t, &call);
    else if (*status == VOR_OK)
        *status = vor_json_parse(json, call.text.data != NULL ? call.text.data : "", call.text.size,
                                 &t->err);
    if (*json != NULL)
        keep_status(t, *json);
    vor_text_free(&call.text);
    return code;
}

/* Waits as long as the server asks to, or until a signal comes. */
static void pause_before_retry(const struct there *t)
{
    int ms = t->parser.retry_ms >= 0 ? t->parser.retry_ms : RETRY_MS_DEFAULT;
    double until = vor_clock_seconds() + ms / 1000.0;
    struct timespec step = {0, 50 * 1000 * 1000};

    while (vor_clock_seconds() < until && !vor_interrupt_seen())
        (void)nanosleep(&step, NULL);
}

/* Until the job is over. A server that goes away is tried a few times, and as long as it answers
 * that the job goes on, listening goes on. */
static int follow(struct there *t)
{
    struct vor_json *json = NULL;
    vor_status status;
    int code;

    for (int tries = 0; !is_over(t);) {
        if (listen(t) == VOR_E_CANCELLED && vor_interrupt_seen())
            return no_answer(t);
        if (is_over(t))
            break;
        code = ask(t, &json, &status);
        vor_json_free(json);
        if (code != VOR_EXIT_OK)
            return code;
        if (is_over(t))
            break;
        tries = status == VOR_OK ? 0 : tries + 1;
        if (tries >= TRIES_MAX || vor_interrupt_seen())
            return no_answer(t);
        pause_before_retry(t);
    }
    return VOR_EXIT_OK;
}

/* Says why a job did not succeed. */
static int say_failure(struct there *t)
{
    struct vor_json *json = NULL;
    vor_status status;
    int code;

    if (strcmp(t->status, "dismissed") == 0) {
        vor_progress_clear(&t->progress);
        vor_cli_say(t->cli->input[0], "the job was dismissed");
        return VOR_EXIT_CANCELLED;
    }
    code = ask(t, &json, &status);
    if (status != VOR_OK)
        code = no_answer(t);
    else if (code == VOR_EXIT_OK)
        code = say_problem(t, vor_json_get(json, "exception"), 500);
    vor_json_free(json);
    return code;
}

/* Writes the document that came as lines. */
static vor_status save_lines(struct there *t, struct vor_text *document)
{
    vor_status status = vor_lines_from_json(document, t->cli, &t->err);

    if (status == VOR_OK && vor_output_write(&t->output, document->data, document->size) != 0)
        status = vor_output_fail(&t->output, &t->err);
    return status;
}

static int fetch_main(struct there *t)
{
    int in_lines = vor_lines_wanted(t->cli);
    char url[VOR_REMOTE_URL_MAX + 64];
    struct vor_remote_call call = {.method = "GET",
                                   .url = url,
                                   .take = in_lines ? NULL : vor_output_write,
                                   .ctx = &t->output,
                                   .stall_seconds = STALL_SECONDS};
    int code = VOR_EXIT_OK;

    (void)snprintf(url, sizeof url, "%s/results/%s", t->job, t->cli->spec.process->outputs[0].name);
    vor_progress_note(&t->progress, "receiving");
    if (vor_remote_perform(t->remote, &call, &t->err) != VOR_OK)
        code = no_answer(t);
    else if (call.http != 200)
        code = refused(t, &call);
    else if ((call.was_stopped && vor_output_fail(&t->output, &t->err) != VOR_OK) ||
             (in_lines && save_lines(t, &call.text) != VOR_OK) ||
             vor_output_commit(&t->output, &t->err) != VOR_OK)
        code = vor_cli_fail(t->cli->option[VOR_OPTION_OUTPUT], &t->err);
    vor_text_free(&call.text);
    return code;
}

static int fetch_report(struct there *t)
{
    char url[VOR_REMOTE_URL_MAX + 16];
    struct vor_remote_call call = {.method = "GET", .url = url, .timeout_seconds = 30};
    int code = VOR_EXIT_OK;

    if (vor_artefact_find(t->cli->spec.process->outputs, "report") == NULL)
        return VOR_EXIT_OK;
    (void)snprintf(url, sizeof url, "%s/results/report", t->job);
    if (vor_remote_perform(t->remote, &call, &t->err) != VOR_OK)
        code = no_answer(t);
    else if (call.http != 200)
        code = refused(t, &call);
    else if (vor_progress_finish(&t->progress, call.text.data != NULL ? call.text.data : "",
                                 call.text.size, &t->err) != VOR_OK)
        code = vor_cli_fail(t->job, &t->err);
    vor_text_free(&call.text);
    return code;
}

/* After ^C: nobody waits for the result any more. */
static void dismiss(struct there *t)
{
    struct vor_remote_call call = {
        .method = "DELETE", .url = t->job, .timeout_seconds = LAST_WORD_SECONDS, .is_last_word = 1};

    if (vor_remote_perform(t->remote, &call, &t->err) != VOR_OK || call.http >= 300)
        vor_cli_say(t->job, "the job could not be dismissed");
    vor_text_free(&call.text);
}

static int work(struct there *t)
{
    int code = submit(t);

    if (code == VOR_EXIT_OK)
        code = follow(t);
    if (code == VOR_EXIT_OK && strcmp(t->status, "successful") != 0)
        code = say_failure(t);
    else if (code == VOR_EXIT_OK)
        code = fetch_main(t);
    if (code == VOR_EXIT_OK)
        code = fetch_report(t);
    if (vor_interrupt_seen() && t->job[0] != '\0' && !is_over(t))
        dismiss(t);
    return code;
}

int vor_cli_process_there(const struct vor_cli *cli)
{
    struct there t;
    int code;

    memset(&t, 0, sizeof t);
    t.cli = cli;
    vor_progress_start(&t.progress, cli);
    vor_sse_parser_init(&t.parser, on_event, &t);
    if (vor_output_open(&t.output, cli->option[VOR_OPTION_OUTPUT], &t.err) != VOR_OK)
        code = vor_cli_fail(cli->option[VOR_OPTION_OUTPUT], &t.err);
    else if (vor_remote_open(&t.remote, &t.err) != VOR_OK)
        code = vor_cli_fail(NULL, &t.err);
    else
        code = work(&t);
    vor_progress_clear(&t.progress);
    vor_output_abandon(&t.output);
    vor_sse_parser_free(&t.parser);
    vor_remote_close(t.remote);
    return code;
}
