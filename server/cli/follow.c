#include "server/cli/follow.h"

#include "core/base/quote.h"
#include "server/base/clock.h"
#include "server/cli/cli_log.h"
#include "server/cli/commands.h"
#include "server/cli/interrupt.h"
#include "server/cli/remote.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

/* Most tries in a row to reach a server that does not answer. */
#define TRIES_MAX 5
#define RETRY_MS_DEFAULT 2000

static int on_event(void *ctx, const struct vor_sse_arrival *event);

int vor_follow_open(struct vor_follow *follow, const struct vor_cli *cli, const char *subject)
{
    char key[VOR_KEY_SENT_MAX + 1];

    memset(follow, 0, sizeof *follow);
    follow->cli = cli;
    follow->subject = subject;
    follow->on_signal = "cancelled";
    vor_progress_start(&follow->progress, cli);
    vor_sse_parser_init(&follow->parser, on_event, follow);
    if (vor_cli_server(follow->server, cli, &follow->err) != VOR_OK)
        return vor_cli_fail(cli->command->name, &follow->err);
    if (vor_cli_key_read(key, cli, &follow->err) != VOR_OK)
        return vor_cli_fail(cli->command->name, &follow->err);
    if (vor_remote_open(&follow->remote, &follow->err) != VOR_OK ||
        vor_remote_authorize(follow->remote, follow->server, key, &follow->err) != VOR_OK)
        return vor_cli_fail(NULL, &follow->err);
    return VOR_EXIT_OK;
}

void vor_follow_close(struct vor_follow *follow)
{
    vor_progress_clear(&follow->progress);
    vor_sse_parser_free(&follow->parser);
    vor_remote_close(follow->remote);
    follow->remote = NULL;
}

int vor_follow_is_over(const struct vor_follow *follow)
{
    return strcmp(follow->status, "successful") == 0 || strcmp(follow->status, "failed") == 0 ||
           strcmp(follow->status, "dismissed") == 0;
}

/* Says that a call got no answer, and err; or that a signal came. */
static int no_answer(struct vor_follow *follow)
{
    vor_progress_clear(&follow->progress);
    if (vor_interrupt_seen()) {
        vor_cli_say(follow->subject, follow->on_signal);
        return vor_cli_interrupted();
    }
    vor_cli_say(follow->job[0] != '\0' ? follow->job : follow->server, follow->err.message);
    return follow->err.status == VOR_E_DAMAGED ? VOR_EXIT_FAILED : VOR_EXIT_UNREACHABLE;
}

const char *vor_follow_text(const struct vor_json *json, const char *name)
{
    const char *text = vor_json_get_string(vor_json_get(json, name));

    return text != NULL ? text : "";
}

/* Says a problem in one line. If json is no problem, says the status alone. */
static int say_problem(struct vor_follow *follow, const struct vor_json *json, int http)
{
    const char *title = vor_follow_text(json, "title"), *detail = vor_follow_text(json, "detail");
    struct vor_text line;
    double number;

    if (vor_json_get_number(vor_json_get(json, "status"), &number) && number >= 100 && number < 600)
        http = (int)number;
    vor_text_init(&line, 0);
    if (title[0] == '\0')
        vor_text_printf(&line, "the server responded with %d", http);
    else
        vor_text_printf(&line, "%s%s%s", title, detail[0] != '\0' ? ": " : "", detail);
    vor_progress_clear(&follow->progress);
    vor_cli_say(follow->subject, line.data != NULL ? line.data : title);
    vor_text_free(&line);
    return vor_cli_exit_code(http, vor_follow_text(json, "type"));
}

/* Says an answer that is a refusal. Never returns VOR_EXIT_OK. */
static int refused(struct vor_follow *follow, const struct vor_remote_call *call)
{
    struct vor_json *json = vor_remote_json(call);
    int code = say_problem(follow, json, call->http);

    vor_json_free(json);
    return code == VOR_EXIT_OK ? VOR_EXIT_FAILED : code;
}

int vor_follow_perform(struct vor_follow *follow, struct vor_remote_call *call, int http, int also)
{
    if (vor_remote_perform(follow->remote, call, &follow->err) != VOR_OK)
        return no_answer(follow);
    return call->http == http || call->http == also ? VOR_EXIT_OK : refused(follow, call);
}

int vor_follow_call(struct vor_follow *follow, const char *method, const char *url,
                    struct vor_json **json)
{
    struct vor_remote_call call = {
        .method = method, .url = url, .timeout_seconds = VOR_FOLLOW_ANSWER_SECONDS};
    int code = vor_follow_perform(follow, &call, 200, 202);

    *json = code == VOR_EXIT_OK ? vor_remote_json(&call) : NULL;
    if (code == VOR_EXIT_OK && *json == NULL) {
        vor_cli_say(follow->subject, "the response of the server is not JSON");
        code = VOR_EXIT_FAILED;
    }
    vor_text_free(&call.text);
    return code;
}

static void keep_status(struct vor_follow *follow, const struct vor_json *json)
{
    (void)snprintf(follow->status, sizeof follow->status, "%s", vor_follow_text(json, "status"));
}

static int on_event(void *ctx, const struct vor_sse_arrival *event)
{
    struct vor_follow *follow = ctx;
    struct vor_json *json = NULL;

    if (vor_json_parse(&json, event->data, event->size, NULL) != VOR_OK)
        return 0;
    if (strcmp(event->name, "progress") == 0) {
        vor_progress_event(&follow->progress, json);
    } else if (strcmp(event->name, "replaced") == 0) {
        follow->progress.eta = (struct vor_eta){0};
    } else if (strcmp(event->name, "status") == 0) {
        const struct vor_json *own = vor_json_get(json, "voronoid");
        const char *words = vor_follow_text(json, "message");
        char note[64];
        double position;

        if (words[0] == '\0')
            words = vor_follow_text(json, "status");
        if (vor_json_get_number(vor_json_get(own, "queuePosition"), &position))
            (void)snprintf(note, sizeof note, "waiting, %.0f jobs before it", position);
        else
            (void)vor_quote(note, sizeof note, words, strlen(words));
        vor_progress_note(&follow->progress, note);
    } else if (strcmp(event->name, "end") == 0) {
        keep_status(follow, json);
    }
    vor_json_free(json);
    return vor_follow_is_over(follow);
}

static int on_stream(void *ctx, const void *bytes, size_t size)
{
    struct vor_follow *follow = ctx;

    return vor_sse_feed(&follow->parser, bytes, size, &follow->err) != VOR_OK;
}

/* Listens until the stream ends, for whatever reason: what became of the job is asked for next. */
static vor_status listen(struct vor_follow *follow)
{
    char url[VOR_REMOTE_URL_MAX + 16], last_id[256];
    const char *headers[] = {"Accept: text/event-stream", NULL, NULL};
    struct vor_remote_call call = {.method = "GET",
                                   .url = url,
                                   .headers = headers,
                                   .take = on_stream,
                                   .ctx = follow,
                                   .ends_to_stop = !follow->told_to_stop,
                                   .stall_seconds = VOR_FOLLOW_STALL_SECONDS};
    vor_status status;

    (void)snprintf(url, sizeof url, "%s/events", follow->job);
    (void)snprintf(last_id, sizeof last_id, "Last-Event-ID: %.200s",
                   vor_sse_parser_last_id(&follow->parser));
    if (vor_sse_parser_last_id(&follow->parser)[0] != '\0')
        headers[1] = last_id;
    vor_sse_parser_restart(&follow->parser);
    status = vor_remote_perform(follow->remote, &call, &follow->err);
    vor_text_free(&call.text);
    return status;
}

/* Asks how the job is doing; *json is its statusInfo. Says a refusal and returns its exit code. */
static int ask(struct vor_follow *follow, struct vor_json **json, vor_status *status)
{
    struct vor_remote_call call = {
        .method = "GET", .url = follow->job, .timeout_seconds = VOR_FOLLOW_ANSWER_SECONDS};
    int code = VOR_EXIT_OK;

    *json = NULL;
    *status = vor_remote_perform(follow->remote, &call, &follow->err);
    if (*status == VOR_OK && call.http == 503)
        *status = vor_fail(&follow->err, VOR_E_IO, "the server responded with 503");
    if (*status == VOR_OK && call.http != 200)
        code = refused(follow, &call);
    else if (*status == VOR_OK)
        *status = vor_json_parse(json, call.text.data != NULL ? call.text.data : "", call.text.size,
                                 &follow->err);
    if (*json != NULL)
        keep_status(follow, *json);
    vor_text_free(&call.text);
    return code;
}

int vor_follow_ask(struct vor_follow *follow, struct vor_json **json)
{
    vor_status status;
    int code = ask(follow, json, &status);

    return status != VOR_OK ? no_answer(follow) : code;
}

/* Asks for the job to end with the best so far: VOR_EXIT_OK, also where it is over already;
 * VOR_EXIT_INTERRUPTED, after it was said, where it has not begun. */
static int stop_job(struct vor_follow *follow)
{
    char url[VOR_REMOTE_URL_MAX + 16];
    struct vor_remote_call call = {
        .method = "POST", .url = url, .timeout_seconds = VOR_FOLLOW_ANSWER_SECONDS};
    struct vor_json *job = NULL;
    int code;

    follow->told_to_stop = 1;
    (void)snprintf(url, sizeof url, "%s/stop", follow->job);
    code = vor_follow_perform(follow, &call, 202, 409);
    if (code == VOR_EXIT_OK && call.http == 409)
        code = vor_follow_ask(follow, &job);
    if (job != NULL && !vor_follow_is_over(follow)) {
        vor_progress_clear(&follow->progress);
        vor_cli_say(follow->subject, "cancelled before it began");
        code = VOR_EXIT_INTERRUPTED;
    }
    vor_json_free(job);
    vor_text_free(&call.text);
    return code;
}

/* Until the job is over. A server that goes away is tried a few times, and as long as it answers
 * that the job goes on, listening goes on. */
static int listen_to_end(struct vor_follow *follow)
{
    struct vor_json *json = NULL;
    vor_status status;
    int code;
    int ms;
    double until;
    struct timespec step = {0, 50 * 1000 * 1000};

    for (int tries = 0; !vor_follow_is_over(follow);) {
        if (listen(follow) == VOR_E_CANCELLED && vor_interrupt_seen())
            return no_answer(follow);
        if (vor_interrupt_stops() && !follow->told_to_stop) {
            code = stop_job(follow);
            if (code != VOR_EXIT_OK)
                return code;
            continue;
        }
        if (vor_follow_is_over(follow))
            break;
        code = ask(follow, &json, &status);
        vor_json_free(json);
        if (code != VOR_EXIT_OK)
            return code;
        if (vor_follow_is_over(follow))
            break;
        tries = status == VOR_OK ? 0 : tries + 1;
        if (tries >= TRIES_MAX || vor_interrupt_seen())
            return no_answer(follow);
        /* Waits as long as the server asks to, or until a signal comes. */
        ms = follow->parser.retry_ms >= 0 ? follow->parser.retry_ms : RETRY_MS_DEFAULT;
        until = vor_clock_seconds() + ms / 1000.0;
        while (vor_clock_seconds() < until && !vor_interrupt_seen())
            (void)nanosleep(&step, NULL);
    }
    return VOR_EXIT_OK;
}

int vor_follow_end(struct vor_follow *follow)
{
    struct vor_json *json = NULL;
    int code = listen_to_end(follow);

    if (code != VOR_EXIT_OK || strcmp(follow->status, "successful") == 0)
        return code;
    if (strcmp(follow->status, "dismissed") == 0) {
        vor_progress_clear(&follow->progress);
        vor_cli_say(follow->subject, "the job was dismissed");
        return VOR_EXIT_CANCELLED;
    }
    code = vor_follow_ask(follow, &json);
    if (code == VOR_EXIT_OK)
        code = say_problem(follow, vor_json_get(json, "exception"), 500);
    vor_json_free(json);
    return code;
}

int vor_follow_report(struct vor_follow *follow)
{
    char url[VOR_REMOTE_URL_MAX + 16];
    struct vor_remote_call call = {
        .method = "GET", .url = url, .timeout_seconds = VOR_FOLLOW_ANSWER_SECONDS};
    int code;

    if (vor_artefact_find(follow->cli->spec.process->outputs, "report") == NULL)
        return VOR_EXIT_OK;
    (void)snprintf(url, sizeof url, "%s/results/report", follow->job);
    code = vor_follow_perform(follow, &call, 200, 0);
    if (code == VOR_EXIT_OK &&
        vor_progress_finish(&follow->progress, call.text.data != NULL ? call.text.data : "",
                            call.text.size, &follow->err) != VOR_OK)
        code = vor_cli_fail(follow->job, &follow->err);
    vor_text_free(&call.text);
    return code;
}
