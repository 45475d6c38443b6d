#include "server/cli/commands.h"

#include "core/base/quote.h"
#include "server/base/clock.h"
#include "server/cli/cli_log.h"
#include "server/cli/follow.h"

#include <stdio.h>
#include <string.h>

enum {
    STATUSES_MAX = 100 /* bytes of all five with commas between */
};

/* A line of JSON, of a daemon's own. */
static void print_json(const struct vor_json *json)
{
    struct vor_text text;

    vor_text_init(&text, 0);
    vor_json_copy(&text, json);
    if (!text.failed && text.data != NULL)
        (void)puts(text.data);
    vor_text_free(&text);
}

/* "5 s", "3 min", "2 h", "4 d" since a time such as 2026-11-21T03:15:34.537Z; "?" for any other. */
static const char *age_of(const char *created, char out[32])
{
    long long seconds;
    int64_t then;

    (void)snprintf(out, 32, "?");
    if (!vor_clock_read(created, &then))
        return out;
    seconds = vor_clock_wall_ms() / 1000 - (long long)then;
    if (seconds < 120)
        (void)snprintf(out, 32, "%lld s", seconds > 0 ? seconds : 0);
    else if (seconds < 120LL * 60)
        (void)snprintf(out, 32, "%lld min", seconds / 60);
    else if (seconds < 48LL * 3600)
        (void)snprintf(out, 32, "%lld h", seconds / 3600);
    else
        (void)snprintf(out, 32, "%lld d", seconds / 86400);
    return out;
}

/* A word of the daemon, fit for a terminal. */
static const char *word_at(const struct vor_json *job, const char *name, char out[64])
{
    const char *text = vor_follow_text(job, name);

    return vor_quote(out, 64, text, strlen(text));
}

static void print_head(const struct vor_cli *cli)
{
    if (cli->option[VOR_OPTION_JSON] == NULL && cli->option[VOR_OPTION_QUIET] == NULL)
        printf("%-36s  %-10s %-10s  %8s  %-7s  %s\n", "JOB", "PROCESS", "STATUS", "PROGRESS", "AGE",
               "NAME");
}

/* The lines of a list; the head comes before the first, or stands alone. */
struct rows {
    const struct vor_cli *cli;
    int has_head;
};

static void visit_row(void *ctx, const struct vor_json *job)
{
    struct rows *rows = ctx;
    const char *name;
    char id[64], process[64], status[64], age[32];
    double progress = 0;

    if (!rows->has_head)
        print_head(rows->cli);
    rows->has_head = 1;
    name = vor_follow_text(vor_json_get(job, "voronoid"), "name");
    if (rows->cli->option[VOR_OPTION_JSON] != NULL) {
        print_json(job);
    } else if (rows->cli->option[VOR_OPTION_QUIET] != NULL) {
        printf("%s\n", word_at(job, "jobID", id));
    } else {
        (void)vor_json_get_number(vor_json_get(job, "progress"), &progress);
        printf("%-36s  %-10s %-10s  %6.0f %%  ", word_at(job, "jobID", id),
               word_at(job, "processID", process), word_at(job, "status", status), progress);
        printf(name[0] != '\0' ? "%-7s  " : "%s", age_of(vor_follow_text(job, "created"), age));
        vor_cli_put(stdout, name);
        fputc('\n', stdout);
    }
}

/* Begins to follow a job, and asks how it is doing; *job as vor_follow_ask has it. End with
 * vor_follow_close, also after a failure. */
static int ask_about(struct vor_follow *follow, const struct vor_cli *cli, const char *id,
                     struct vor_json **job)
{
    int code = vor_follow_open(follow, cli, id);

    *job = NULL;
    if (code == VOR_EXIT_OK)
        code = vor_job_choose(follow, id);
    return code == VOR_EXIT_OK ? vor_follow_ask(follow, job) : code;
}

static int show_one(const struct vor_cli *cli, int index, void *rows)
{
    const char *id = cli->operands[index];
    struct vor_follow follow;
    struct vor_json *job;
    int code = ask_about(&follow, cli, id, &job);

    if (code == VOR_EXIT_OK)
        visit_row(rows, job);
    vor_json_free(job);
    vor_follow_close(&follow);
    return code;
}

int vor_cli_jobs(const struct vor_cli *cli)
{
    const char *statuses = cli->option[VOR_OPTION_STATUS];
    struct rows rows = {cli, 0};
    struct vor_follow follow;
    struct vor_error err;
    int code;

    if (statuses != NULL && (statuses[0] == '\0' || strlen(statuses) > STATUSES_MAX ||
                             statuses[strspn(statuses, "abcdefghijklmnopqrstuvwxyz,")] != '\0')) {
        (void)vor_fail(
            &err, VOR_E_PARAM,
            "status is \"%s\", want some of accepted,running,successful,failed,dismissed",
            VOR_QUOTED(64, statuses, strlen(statuses)));
        return vor_cli_fail(cli->command->name, &err);
    }
    if (cli->operand_count > 0) {
        code = vor_cli_each(cli, show_one, &rows);
    } else {
        code = vor_follow_open(&follow, cli, cli->command->name);
        if (code == VOR_EXIT_OK)
            code = vor_job_list(&follow, statuses, (unsigned)cli->number[VOR_OPTION_LIMIT],
                                visit_row, &rows);
        if (code == VOR_EXIT_OK && !rows.has_head)
            print_head(cli);
        vor_follow_close(&follow);
    }
    if (fflush(stdout) != 0 && code == VOR_EXIT_OK)
        code = VOR_EXIT_FAILED;
    return code;
}

static int wait_one(const struct vor_cli *cli, int index, VOR_UNUSED void *ctx)
{
    const char *id = cli->operands[index];
    struct vor_cli one = *cli;
    struct vor_follow follow;
    int code = vor_follow_open(&follow, &one, id);

    follow.on_signal = "stopped waiting for the job; the job itself continues";
    if (code == VOR_EXIT_OK)
        code = vor_job_choose(&follow, id);
    follow.progress.name = follow.subject;
    if (code == VOR_EXIT_OK) {
        struct vor_json *job;
        const struct vor_process_info *process;

        /* A job's process decides what its bar and its report are like. One that only the daemon
         * knows has the bar of resample and no report. */
        code = vor_follow_ask(&follow, &job);
        process = vor_process_find(vor_follow_text(job, "processID"));
        vor_json_free(job);
        vor_spec_init(&one.spec);
        if (process != NULL)
            vor_spec_preset(&one.spec, process);
        if (follow.progress.lines != NULL)
            follow.status[0] = '\0'; /* a job that is over tells its records once more */
        if (code == VOR_EXIT_OK)
            code = vor_follow_end(&follow);
        if (code == VOR_EXIT_OK && process != NULL)
            code = vor_follow_report(&follow);
    }
    vor_follow_close(&follow);
    return code;
}

int vor_cli_wait(const struct vor_cli *cli)
{
    return vor_cli_each(cli, wait_one, NULL);
}

/* Ends a job that was not over when it was asked. */
static int end_job(struct vor_follow *follow, const char *method, const char *url, const char *said)
{
    const struct vor_cli *cli = follow->cli;
    struct vor_json *job;
    int code = vor_follow_call(follow, method, url, &job);

    if (code == VOR_EXIT_OK && cli->option[VOR_OPTION_JSON] != NULL)
        print_json(job);
    else if (code == VOR_EXIT_OK && cli->option[VOR_OPTION_QUIET] == NULL)
        vor_cli_say(follow->subject, said);
    vor_json_free(job);
    return code;
}

/* The daemon removes a job that ends before its DELETE arrives, as it does for anybody. */
static int end_one(const struct vor_cli *cli, int index, void *ctx)
{
    const char *id = cli->operands[index];
    const int *keeps_best = ctx;
    char url[VOR_REMOTE_URL_MAX + 16];
    struct vor_follow follow;
    struct vor_json *job;
    int code = ask_about(&follow, cli, id, &job);

    vor_json_free(job);
    if (code == VOR_EXIT_OK && vor_follow_is_over(&follow)) {
        char line[64];

        (void)snprintf(line, sizeof line, "has already ended: %s", follow.status);
        vor_cli_say(follow.subject, line);
        code = VOR_EXIT_FAILED;
    } else if (code == VOR_EXIT_OK) {
        (void)snprintf(url, sizeof url, "%s/stop", follow.job);
        code = *keeps_best ? end_job(&follow, "POST", url,
                                     "the job will stop; its result is the best cloud so far")
                           : end_job(&follow, "DELETE", follow.job, "dismissed");
    }
    vor_follow_close(&follow);
    return code;
}

static int end_each(const struct vor_cli *cli, int keeps_best)
{
    int code = vor_cli_each(cli, end_one, &keeps_best);

    return fflush(stdout) != 0 && code == VOR_EXIT_OK ? VOR_EXIT_FAILED : code;
}

int vor_cli_cancel(const struct vor_cli *cli)
{
    return end_each(cli, 0);
}

int vor_cli_stop(const struct vor_cli *cli)
{
    return end_each(cli, 1);
}
