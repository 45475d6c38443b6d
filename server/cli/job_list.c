#include "server/cli/follow.h"

#include "server/cli/cli_log.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

enum {
    PAGE_JOBS = 100,     /* of one request: a job has up to 4 KiB, an answer VOR_JSON_SIZE_MAX */
    CURSOR_SIZE = 24,    /* digits of a sequence number, and a NUL */
    STATUSES_MAX = 1024, /* bytes of a list of statuses in a URL */
    SHOWN_MAX = 5        /* jobs that a word may stand for, in a message */
};

int vor_job_list(struct vor_follow *follow, const char *statuses, unsigned limit,
                 void (*visit)(void *ctx, const struct vor_json *job), void *ctx)
{
    char url[VOR_REMOTE_URL_MAX + STATUSES_MAX + 64], cursor[CURSOR_SIZE] = "";
    int code = VOR_EXIT_OK;
    const struct vor_json *links;

    do {
        const struct vor_json *jobs;
        struct vor_json *list;

        (void)snprintf(url, sizeof url, "%s/v1/jobs?limit=%u%s%.*s%s%s", follow->server,
                       limit < PAGE_JOBS ? limit : PAGE_JOBS, statuses != NULL ? "&status=" : "",
                       STATUSES_MAX, statuses != NULL ? statuses : "",
                       cursor[0] != '\0' ? "&cursor=" : "", cursor);
        code = vor_follow_call(follow, "GET", url, &list);
        jobs = vor_json_get(list, "jobs");
        for (const struct vor_json *j = vor_json_first(jobs); j != NULL && limit > 0;
             j = vor_json_next(j), limit--)
            visit(ctx, j);
        /* The number behind "cursor=" in the link to the next page; "" where there is none. */
        links = vor_json_get(list, "links");
        cursor[0] = '\0';
        for (const struct vor_json *l = vor_json_first(links); l != NULL; l = vor_json_next(l)) {
            const char *at = strstr(vor_follow_text(l, "href"), "cursor=");

            if (at == NULL || strcmp(vor_follow_text(l, "rel"), "next") != 0)
                continue;
            at += strlen("cursor=");
            (void)snprintf(cursor, CURSOR_SIZE, "%.*s", (int)strspn(at, "0123456789"), at);
        }
        vor_json_free(list);
    } while (code == VOR_EXIT_OK && limit > 0 && cursor[0] != '\0');
    return code;
}

/* The jobs with an ID that begins with a word. */
struct found {
    const char *word;
    struct vor_uuid id[SHOWN_MAX];
    unsigned count;
};

static void match(void *ctx, const struct vor_json *job)
{
    const char *text = vor_follow_text(job, "jobID");
    struct found *found = ctx;
    struct vor_uuid id;

    if (!vor_uuid_parse(&id, text, strlen(text)) ||
        strncmp(text, found->word, strlen(found->word)) != 0)
        return;
    if (found->count < SHOWN_MAX)
        found->id[found->count] = id;
    found->count++;
}

int vor_job_choose(struct vor_follow *follow, const char *word)
{
    struct found found = {.word = word, .count = 0};
    char line[SHOWN_MAX * sizeof found.id[0].text + 128];
    int code, at;

    if (!vor_uuid_parse(&follow->id, word, strlen(word))) {
        code = vor_job_list(follow, NULL, UINT_MAX, match, &found);
        if (code != VOR_EXIT_OK)
            return code;
        if (found.count > 1) {
            at = snprintf(line, sizeof line, "%u jobs begin with this:", found.count);
            for (unsigned i = 0; i < found.count && i < SHOWN_MAX; i++)
                at += snprintf(line + at, sizeof line - (size_t)at, "%s %s", i > 0 ? "," : "",
                               found.id[i].text);
            if (found.count > SHOWN_MAX)
                (void)snprintf(line + at, sizeof line - (size_t)at, " and %u more",
                               found.count - SHOWN_MAX);
            vor_cli_say(word, line);
            return VOR_EXIT_USAGE;
        }
        if (found.count == 0) {
            vor_cli_say(word, "no such job; voronoid jobs lists all jobs");
            return VOR_EXIT_FAILED;
        }
        follow->id = found.id[0];
    }
    follow->subject = follow->id.text;
    /* vor_cli_server leaves room for the path. */
    (void)snprintf(follow->job, sizeof follow->job, "%.*s/v1/jobs/%s", VOR_REMOTE_URL_MAX - 128,
                   follow->server, follow->id.text);
    return VOR_EXIT_OK;
}
