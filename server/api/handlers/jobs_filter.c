/* The query of a list of jobs, after OGC API - Processes. */
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/base/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LIST_DEFAULT = 10, LIST_MAX = 10000, SECONDS_MAX = 1000000000 };

/* A whole number in digits alone; -1 otherwise. */
static int64_t parse_count(const char *text)
{
    size_t length = strlen(text);

    if (length == 0 || length > 18 || strspn(text, "0123456789") != length)
        return -1;
    return strtoll(text, NULL, 10);
}

static const char *read_limit(const char *value, struct vor_job_filter *out)
{
    int64_t number = parse_count(value);

    out->limit = (size_t)number;
    return number < 1 || number > LIST_MAX ? "a whole number from 1 to 10000" : NULL;
}

static const char *read_cursor(const char *value, struct vor_job_filter *out)
{
    out->before_seq = parse_count(value);
    return out->before_seq < 1 ? "the cursor from a link with rel=next" : NULL;
}

static const char *read_status(const char *value, struct vor_job_filter *out)
{
    static const char want[] = "some of accepted, running, successful, failed, dismissed";

    while (*value != '\0') {
        size_t length = strcspn(value, ",");
        char word[32];
        enum vor_job_status status;

        (void)snprintf(word, sizeof word, "%.*s", (int)(length < 30 ? length : 30), value);
        status = vor_job_status_find(word);
        if (status == VOR_JOB_STATUSES)
            return want;
        out->statuses |= 1u << status;
        value += length + (value[length] == ',');
    }
    return out->statuses == 0 ? want : NULL;
}

static const char *read_process(const char *value, struct vor_job_filter *out)
{
    out->process = value;
    return NULL;
}

static const char *read_name(const char *value, struct vor_job_filter *out)
{
    out->name = value;
    return NULL;
}

static const char *read_type(const char *value, struct vor_job_filter *out)
{
    (void)out; /* there is no other */
    return strcmp(value, "process") == 0 ? NULL : "process";
}

/* Seconds as milliseconds; 0 ms would mean any duration. */
static const char *read_seconds(const char *value, int64_t *out)
{
    int64_t seconds = parse_count(value);

    if (seconds < 0 || seconds > SECONDS_MAX)
        return "whole seconds from 0 to 1000000000";
    *out = seconds > 0 ? seconds * 1000 : 1;
    return NULL;
}

static const char *read_shortest(const char *value, struct vor_job_filter *out)
{
    const char *want = read_seconds(value, &out->duration_min);

    if (strcmp(value, "0") == 0)
        out->duration_min = 0;
    return want;
}

static const char *read_longest(const char *value, struct vor_job_filter *out)
{
    return read_seconds(value, &out->duration_max);
}

/* A time in UTC of that length, perhaps with a fraction of a second; both ends of what it names,
 * in milliseconds. */
static bool parse_instant(const char *text, size_t length, int64_t *first, int64_t *last)
{
    enum { SECOND = 19 };
    int64_t seconds;
    size_t digits = 0;

    if (length <= SECOND || !vor_clock_read(text, &seconds) || text[length - 1] != 'Z')
        return false;
    *first = seconds * 1000;
    *last = *first + 999;
    text += SECOND;
    length -= SECOND + 1;
    if (length == 0)
        return true;
    while (digits + 1 < length && text[1 + digits] >= '0' && text[1 + digits] <= '9') {
        static const int worth[] = {100, 10, 1};

        *first += digits < 3 ? (text[1 + digits] - '0') * worth[digits] : 0;
        digits++;
    }
    *last = *first;
    return text[0] == '.' && digits > 0 && digits + 1 == length;
}

/* An instant, or two with a slash between, of which one may be open: ".." or nothing. */
static const char *read_datetime(const char *value, struct vor_job_filter *out)
{
    static const char want[] =
        "a time such as 2026-11-21T03:15:34Z, or START/END, where one of the two may be ..";
    const char *slash = strchr(value, '/');
    int64_t first, last;
    size_t length;

    if (slash == NULL)
        return parse_instant(value, strlen(value), &out->created_from, &out->created_to) ? NULL
                                                                                         : want;
    length = (size_t)(slash - value);
    if (length > 0 && strncmp(value, "../", 3) != 0) {
        if (!parse_instant(value, length, &out->created_from, &last))
            return want;
    }
    slash++;
    if (*slash != '\0' && strcmp(slash, "..") != 0 &&
        !parse_instant(slash, strlen(slash), &first, &out->created_to))
        return want;
    return out->created_from == 0 && out->created_to == 0 ? want : NULL;
}

static const struct {
    const char *name;
    const char *(*read)(const char *value, struct vor_job_filter *out);
} parameters[] = {
    {"limit", read_limit},          {"cursor", read_cursor},       {"status", read_status},
    {"processID", read_process},    {"type", read_type},           {"datetime", read_datetime},
    {"minDuration", read_shortest}, {"maxDuration", read_longest}, {"name", read_name},
};

enum { PARAMETERS = sizeof parameters / sizeof parameters[0] };

bool vor_job_filter_read(struct vor_request *request, struct vor_job_filter *out)
{
    char detail[256];

    *out = (struct vor_job_filter){.limit = LIST_DEFAULT, .now = vor_clock_wall_ms()};
    for (int i = 0; i < request->pair_count; i++) {
        const char *name = request->pairs[i].name, *value = request->pairs[i].value;
        const char *want = "one of limit, cursor, status, processID, type, datetime, minDuration, "
                           "maxDuration and name as the name";

        for (int k = 0; k < PARAMETERS; k++) /* what the value should be; NULL when it is that */
            if (strcmp(name, parameters[k].name) == 0)
                want = parameters[k].read(value, out);
        if (want == NULL)
            continue;
        (void)snprintf(detail, sizeof detail, "%.40s is \"%.60s\", want %s", name, value, want);
        return vor_problem_reply(request, &VOR_PROBLEM("invalid-query-parameter-value",
                                                       .parameter = name, .detail = detail));
    }
    return true;
}
