#include "server/api/handlers/events_query.h"

#include "core/base/quote.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/base/option.h"

#include <string.h>

#define BAD_QUERY "invalid-query-parameter-value"

static const char *last_id_of(const struct vor_request *request)
{
    const char *last = vor_request_header(request, "Last-Event-ID");

    return last != NULL ? last : vor_request_query(request, "lastEventId");
}

static double wait_of(const struct vor_request *request)
{
    struct vor_preferences preferences;

    vor_prefer_read(request, &preferences);
    return preferences.wait_seconds;
}

bool vor_query_points(struct vor_request *request, const char *name, size_t *out)
{
    const char *text = vor_request_query(request, name);
    unsigned value;

    if (text == NULL)
        return true;
    if (vor_whole_read(&value, text, 1, VOR_PREVIEW_POINTS_MAX)) {
        *out = value;
        return true;
    }
    return vor_problem_say(request, BAD_QUERY, "%s is \"%s\", want a whole number from 1 to %d",
                           name, VOR_QUOTED(64, text, strlen(text)), VOR_PREVIEW_POINTS_MAX);
}

bool vor_events_query_one(struct vor_request *request, struct vor_events_query *out)
{
    const char *last = last_id_of(request);

    if (!vor_query_points(request, "preview", &out->preview))
        return false;
    out->wait = wait_of(request);
    out->is_replay = last != NULL;
    if (last == NULL || vor_position_parse(&out->jobs[0].position, last))
        return true;
    return vor_problem_say(request, BAD_QUERY,
                           "the last event id is \"%.40s\", want ATTEMPT.NUMBER", last);
}

/* The next item of a list with commas; false past the last. *at is NULL there. */
static bool next_item(const char **at, const char **item, size_t *length)
{
    if (*at == NULL)
        return false;
    *item = *at;
    *length = strcspn(*at, ",");
    *at = (*item)[*length] == ',' ? *item + *length + 1 : NULL;
    return true;
}

static bool read_jobs(struct vor_request *request, struct vor_events_query *out)
{
    const char *at = vor_request_query(request, "jobs"), *item;
    struct vor_uuid id;
    size_t length;

    if (at == NULL)
        return vor_problem_say(request, BAD_QUERY,
                               "jobs is missing, want 1 to %d IDs of jobs, separated by commas",
                               VOR_EVENT_JOBS_MAX);
    while (next_item(&at, &item, &length)) {
        if (!vor_uuid_parse(&id, item, length))
            return vor_problem_say(
                request, BAD_QUERY,
                "jobs holds \"%s\", want 1 to %d IDs of jobs, separated by commas",
                VOR_QUOTED(64, item, length), VOR_EVENT_JOBS_MAX);
        for (unsigned i = 0; i < out->count; i++)
            if (strcmp(out->jobs[i].id.text, id.text) == 0)
                return vor_problem_say(request, BAD_QUERY, "jobs holds %s twice, want each ID once",
                                       id.text);
        if (out->count == VOR_EVENT_JOBS_MAX)
            return vor_problem_say(request, BAD_QUERY, "jobs holds more than %d IDs, want 1 to %d",
                                   VOR_EVENT_JOBS_MAX, VOR_EVENT_JOBS_MAX);
        out->jobs[out->count++].id = id;
    }
    return true;
}

static bool read_position(struct vor_events_query *out, unsigned index, const char *item,
                          size_t length)
{
    char text[VOR_POSITION_SIZE];

    if (length >= sizeof text)
        return false;
    memcpy(text, item, length);
    text[length] = '\0';
    out->jobs[index].is_over = strcmp(text, VOR_POSITION_END) == 0;
    return out->jobs[index].is_over || vor_position_parse(&out->jobs[index].position, text);
}

static bool read_positions(struct vor_request *request, struct vor_events_query *out)
{
    const char *last = last_id_of(request), *at = last, *item;
    unsigned count = 0;
    bool is_sound = true;
    size_t length;

    out->is_replay = last != NULL;
    while (is_sound && next_item(&at, &item, &length)) {
        is_sound = count < out->count && read_position(out, count, item, length);
        count++;
    }
    if (last == NULL || (is_sound && count == out->count))
        return true;
    return vor_problem_say(
        request, BAD_QUERY,
        "the last event id is \"%.40s\", want ATTEMPT.NUMBER or end for each of the %u "
        "jobs, separated by commas",
        last, out->count);
}

bool vor_events_query_many(struct vor_request *request, struct vor_events_query *out)
{
    *out = (struct vor_events_query){.is_many = true, .wait = wait_of(request)};
    return vor_query_points(request, "preview", &out->preview) && read_jobs(request, out) &&
           read_positions(request, out);
}
