#include "server/cli/commands.h"

#include "core/base/quote.h"
#include "proto/codec.h"
#include "server/base/result_name.h"
#include "server/cli/cli_log.h"
#include "server/cli/files.h"
#include "server/cli/follow.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

enum { NAME_MAX_BYTES = 64 /* of a result's name */ };

/* One result on its way into a file. */
struct result {
    const char *name, *type; /* media type */
    char path[PATH_MAX];
    struct vor_output output;
    uint64_t bytes;
};

/* Fetching of jobs, one after another. */
struct fetch {
    struct vor_follow follow;
    const char *name, *process; /* of the job */
    struct vor_text written;    /* the paths of all files so far, each with its NUL */
};

static int on_bytes(void *ctx, const void *bytes, size_t size)
{
    struct result *result = ctx;

    result->bytes += size;
    return vor_output_write(&result->output, bytes, size);
}

/* A daemon's word becomes part of a file's name: it must not lead elsewhere. */
static int is_plain(const char *name)
{
    size_t length = strlen(name);

    return length > 0 && length <= NAME_MAX_BYTES &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-") ==
               length;
}

static int was_written(const struct fetch *fetch, const char *path)
{
    const char *at = fetch->written.data;

    for (size_t left = fetch->written.size; left > 0;) {
        size_t size = strlen(at) + 1;

        if (strcmp(at, path) == 0)
            return 1;
        at += size;
        left -= size;
    }
    return 0;
}

/* Where a result goes: the file that was named, or one in the folder that has the name of the job,
 * or its ID if a job before it had that name. */
static int name_file(const struct fetch *fetch, struct result *result)
{
    const struct vor_cli *cli = fetch->follow.cli;
    const char *into = cli->option[VOR_OPTION_INTO], *names[] = {fetch->name, ""};
    const struct vor_format *format = vor_format_by_media_type(result->type);
    const char *suffix = format != NULL                                  ? format->suffix
                         : strcmp(result->type, "application/json") == 0 ? ".json"
                                                                         : ".bin";
    char name[VOR_RESULT_NAME_SIZE] = "";
    size_t length = 0;

    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (vor_cli_into_folder(cli))
            vor_result_name(name, names[i], fetch->follow.id.text, fetch->process, result->name,
                            suffix);
        length = (size_t)snprintf(result->path, sizeof result->path, "%s%s", into, name);
        if (name[0] == '\0' || !was_written(fetch, result->path))
            break;
    }
    return length < sizeof result->path;
}

/* What was written, for people or for programs; on stderr when the bytes go to stdout. */
static void tell(const struct vor_follow *follow, const struct result *result)
{
    const struct vor_cli *cli = follow->cli;
    struct vor_text text;

    vor_text_init(&text, 0);
    if (cli->option[VOR_OPTION_JSON] != NULL) {
        vor_json_begin_object(&text);
        vor_json_put_string(&text, "jobID", follow->subject);
        vor_json_put_string(&text, "result", result->name);
        vor_json_put_string(&text, "file", result->path);
        vor_json_put_string(&text, "type", result->type);
        vor_json_put_u64(&text, "bytes", result->bytes);
        vor_json_end_object(&text);
        if (!text.failed)
            fprintf(strcmp(result->path, "-") == 0 ? stderr : stdout, "%s\n", text.data);
    } else if (cli->option[VOR_OPTION_QUIET] == NULL) {
        vor_text_printf(&text, "%llu bytes", (unsigned long long)result->bytes);
        if (!text.failed)
            vor_cli_say(result->path, text.data);
    }
    vor_text_free(&text);
}

static int receive(struct vor_follow *follow, struct result *result)
{
    char url[VOR_REMOTE_URL_MAX + NAME_MAX_BYTES + 16];
    struct vor_remote_call call = {.method = "GET",
                                   .url = url,
                                   .goes_there = 1,
                                   .take = on_bytes,
                                   .ctx = result,
                                   .stall_seconds = VOR_FOLLOW_STALL_SECONDS};
    int code;

    (void)snprintf(url, sizeof url, "%s/results/%s", follow->job, result->name);
    code = vor_follow_perform(follow, &call, 200, 0);
    if (code == VOR_EXIT_OK &&
        ((call.was_stopped && vor_output_fail(&result->output, &follow->err) != VOR_OK) ||
         vor_output_commit(&result->output, &follow->err) != VOR_OK))
        code = vor_cli_fail(result->path, &follow->err);
    vor_text_free(&call.text);
    return code;
}

static int fetch_result(struct fetch *fetch, const struct vor_json *member)
{
    struct vor_follow *follow = &fetch->follow;
    struct result result = {.name = vor_json_name(member), .type = vor_follow_text(member, "type")};
    int code, replace;

    if (!is_plain(result.name) || !is_plain(fetch->process) || !name_file(fetch, &result)) {
        vor_cli_say(follow->subject, "the name of a result cannot be a file name");
        return VOR_EXIT_FAILED;
    }
    if (vor_overwrite_check(follow->cli, result.path, &replace, &follow->err) != VOR_OK ||
        vor_output_open(&result.output, result.path, replace, &follow->err) != VOR_OK)
        return vor_cli_fail(result.path, &follow->err);
    vor_progress_note(&follow->progress, "receiving");
    code = receive(follow, &result);
    vor_progress_clear(&follow->progress);
    vor_output_abandon(&result.output);
    if (code == VOR_EXIT_OK) {
        vor_text_add(&fetch->written, result.path, strlen(result.path) + 1);
        tell(follow, &result);
    }
    return code;
}

/* Fetches what is wanted of the results that the job has, the main one first. */
static int fetch_listed(struct fetch *fetch, const struct vor_json *list)
{
    struct vor_text line;
    const struct vor_follow *follow = &fetch->follow;
    const char *wanted = follow->cli->option[VOR_OPTION_RESULT];
    int is_all = wanted == NULL && vor_cli_into_folder(follow->cli), code = VOR_EXIT_OK;

    if (vor_json_kind(list) != VOR_JSON_OBJECT || vor_json_first(list) == NULL) {
        vor_cli_say(follow->subject, "the server lists no results");
        return VOR_EXIT_FAILED;
    }
    if (wanted != NULL && vor_json_get(list, wanted) == NULL) {
        vor_text_init(&line, 0);
        vor_text_printf(&line, "no result %s, want ",
                        VOR_QUOTED(NAME_MAX_BYTES, wanted, strlen(wanted)));
        for (const struct vor_json *m = vor_json_first(list); m != NULL; m = vor_json_next(m))
            vor_text_printf(&line, "%s%s", m != vor_json_first(list) ? " or " : "",
                            vor_json_name(m));
        vor_cli_say(follow->subject, line.data != NULL ? line.data : "no such result");
        vor_text_free(&line);
        return VOR_EXIT_USAGE;
    }
    for (const struct vor_json *m = vor_json_first(list); m != NULL && code == VOR_EXIT_OK;
         m = vor_json_next(m)) {
        if (wanted != NULL && strcmp(wanted, vor_json_name(m)) != 0)
            continue;
        code = fetch_result(fetch, m);
        if (!is_all)
            break;
    }
    return code;
}

static int fetch_one(const struct vor_cli *cli, int index, void *ctx)
{
    const char *id = cli->operands[index];
    struct fetch *fetch = ctx;
    struct vor_follow *follow = &fetch->follow;
    char url[VOR_REMOTE_URL_MAX + 16];
    struct vor_json *job = NULL, *list = NULL;
    int code = vor_follow_open(follow, cli, id);

    if (code == VOR_EXIT_OK)
        code = vor_job_choose(follow, id);
    if (code == VOR_EXIT_OK)
        code = vor_follow_ask(follow, &job);
    fetch->name = vor_follow_text(vor_json_get(job, "voronoid"), "name");
    fetch->process = vor_follow_text(job, "processID");
    (void)snprintf(url, sizeof url, "%s/results", follow->job);
    if (code == VOR_EXIT_OK)
        code = vor_follow_call(follow, "GET", url, &list);
    if (code == VOR_EXIT_OK)
        code = fetch_listed(fetch, list);
    vor_json_free(list);
    vor_json_free(job);
    vor_follow_close(follow);
    return code;
}

int vor_cli_fetch(const struct vor_cli *cli)
{
    const char *into = cli->option[VOR_OPTION_INTO];
    struct fetch fetch = {.name = NULL};
    struct vor_error err;
    int code;

    if (vor_cli_into_folder(cli) && vor_folder_make(into, &err) != VOR_OK)
        return vor_cli_fail(cli->command->name, &err);
    vor_text_init(&fetch.written, 0);
    code = vor_cli_each(cli, fetch_one, &fetch);
    vor_text_free(&fetch.written);
    return fflush(stdout) != 0 && code == VOR_EXIT_OK ? VOR_EXIT_FAILED : code;
}
