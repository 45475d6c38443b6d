#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"
#include "server/http/deferred.h"
#include "server/work/thread_pool.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Reads the {jobID} of the path, whosever the job is. */
static bool read_id(struct vor_request *request, struct vor_uuid *out)
{
    const char *segment;
    size_t length = vor_path_segment(request->path, 2, &segment);

    if (vor_uuid_parse(out, segment, length)) {
        (void)snprintf(request->job, sizeof request->job, "%s", out->text);
        return true;
    }
    return vor_problem_say(request, "no-such-job", "there is no job %.*s",
                           (int)(length < 60 ? length : 60), segment);
}

bool vor_job_of_path(struct vor_request *request, struct vor_uuid *out)
{
    struct vor_job_view view;

    if (vor_auth_tenant(request) == NULL)
        return read_id(request, out);
    if (!vor_job_look_up(request, &view))
        return false;
    *out = view.id;
    return true;
}

enum vor_next vor_outcome_reply(struct vor_request *request, enum vor_job_outcome outcome,
                                const struct vor_error *err, const struct vor_uuid *id)
{
    struct vor_problem full =
        VOR_PROBLEM("queue-full", .detail = "too many jobs are waiting, or their inputs are too "
                                            "large together; try again later");
    struct vor_job_service_load load;

    switch (outcome) {
    case VOR_UNKNOWN:
        return vor_problem_say(request, "no-such-job", "there is no job %s",
                               id != NULL ? id->text : "");
    case VOR_FULL:
        vor_job_service_load(request->app->service, &load);
        full.queue_depth = (int64_t)load.waiting;
        return vor_problem_reply(request, &full);
    case VOR_CROWDED:
        return vor_problem_say(request, "too-many-jobs", "%s", err->message);
    case VOR_OVER_BYTES:
        return vor_problem_say(request, "too-much-stored", "%s", err->message);
    case VOR_DRAINING:
        return vor_problem_say(request, "draining", "the daemon is shutting down");
    case VOR_CONFLICT:
        return vor_problem_say(request, "not-running", "the job is not running");
    case VOR_FAILED:
    case VOR_DONE:
        break;
    }
    return vor_problem_error(request, err, NULL);
}

bool vor_job_look_up(struct vor_request *request, struct vor_job_view *out)
{
    struct vor_error err;
    struct vor_uuid id;
    enum vor_job_outcome outcome;

    if (!read_id(request, &id))
        return false;
    outcome = vor_job_service_get(request->app->service, &id, vor_auth_tenant(request), out, &err);
    if (outcome == VOR_DONE)
        return true;
    return vor_outcome_reply(request, outcome, &err, &id);
}

/* Jobs of a list that are read and written at a step; writing takes some 4 ms of a core. Between
 * two steps of a long list the thread serves others: with 10,000 jobs at once, /livez waited 10 s
 * beside four such lists. */
enum { SLICE = 50 };

/* The list while it is written. It asks for one job more than the page has: then there is a next
 * page. */
struct listing {
    struct vor_deferred deferred; /* first; the read of a slice */
    struct vor_app *app;
    struct vor_request *request;  /* for its own thread alone */
    struct vor_job_filter filter; /* of the next slice; its texts are those below */
    char name[VOR_JOB_NAME_SIZE], process[32], tenant[VOR_JOB_PRINCIPAL_SIZE];
    struct vor_task task;
    struct vor_text text;
    bool walks;  /* no index leads to what it filters by: others of the caller go before it */
    size_t left; /* of the page */
    bool more;
    vor_status status; /* of the read, as the next three */
    struct vor_error error;
    size_t count;
    struct vor_job_view rows[SLICE];
};

static void free_listing(struct vor_deferred *deferred)
{
    struct listing *list = (struct listing *)deferred;

    vor_text_free(&list->text);
    free(list);
}

static int take_row(void *ctx, const struct vor_job_view *view)
{
    struct listing *list = ctx;

    list->rows[list->count++] = *view;
    return list->count < SLICE;
}

/* On a thread that reads the store. */
static void read_slice(void *ctx)
{
    struct listing *list = ctx;

    list->count = 0;
    list->status =
        vor_job_service_list(list->app->service, &list->filter, take_row, list, &list->error);
    vor_deferred_complete(&list->deferred);
}

enum vor_job_outcome vor_read_begin(struct vor_request *request, struct vor_deferred *deferred,
                                    struct vor_task *task, struct vor_error *err)
{
    enum vor_job_outcome outcome;

    task->ctx = deferred;
    task->caller = vor_auth_fairness_key(request);
    vor_deferred_retain(deferred);
    outcome = vor_job_service_read_soon(request->app->service, task, err);
    if (outcome != VOR_DONE)
        vor_deferred_cancel(deferred);
    return outcome;
}

static enum vor_next begin_slice(struct listing *list)
{
    enum vor_job_outcome outcome;

    list->filter.limit = list->left < SLICE ? list->left + 1 : SLICE;
    list->task =
        (struct vor_task){.run = read_slice, .weight = list->walks ? SIZE_MAX : list->filter.limit};
    outcome = vor_read_begin(list->request, &list->deferred, &list->task, &list->error);
    return outcome == VOR_DONE ? VOR_NEXT_WAIT
                               : vor_outcome_reply(list->request, outcome, &list->error, NULL);
}

/* Writes a link to /v1/jobs with the query of this request and another cursor. */
static void put_list_link(struct listing *list, const char *rel, const char *cursor)
{
    char base[VOR_URL_MAX];
    struct vor_link link = {rel, "application/json", NULL, NULL, -1};
    struct vor_text url;
    char mark = '?';

    vor_text_init(&url, 0);
    vor_text_puts(&url, vor_app_url(list->request, "/v1/jobs", base));
    for (int i = 0; i < list->request->pair_count; i++) {
        const char *name = list->request->pairs[i].name;

        if (cursor != NULL && strcmp(name, "cursor") == 0)
            continue;
        vor_text_printf(&url, "%c%s=", mark, name);
        vor_text_escape(&url, list->request->pairs[i].value);
        mark = '&';
    }
    if (cursor != NULL)
        vor_text_printf(&url, "%ccursor=%s", mark, cursor);
    link.href = url.data;
    vor_json_link(&list->text, &link);
    vor_text_free(&url);
}

static const char *keep(char *out, size_t size, const char *text)
{
    if (text == NULL)
        return NULL;
    (void)snprintf(out, size, "%s", text);
    return out;
}

static enum vor_next begin_list(struct vor_request *request)
{
    struct vor_job_filter filter;
    struct listing *list;

    if (!vor_job_filter_read(request, &filter))
        return VOR_NEXT_REPLY;
    list = calloc(1, sizeof *list);
    if (list == NULL)
        return vor_problem_no_memory(request);
    list->app = request->app;
    list->request = request;
    list->filter = filter;
    list->filter.name = keep(list->name, sizeof list->name, filter.name);
    list->filter.process = keep(list->process, sizeof list->process, filter.process);
    list->filter.tenant = keep(list->tenant, sizeof list->tenant, vor_auth_tenant(request));
    list->walks = filter.process != NULL || filter.statuses != 0 || filter.duration_min > 0 ||
                  filter.duration_max > 0 || filter.created_from > 0 || filter.created_to > 0;
    list->left = filter.limit;
    vor_text_init(&list->text, 0);
    vor_json_begin_object(&list->text);
    vor_json_put_array(&list->text, "jobs");
    vor_deferred_begin(&list->deferred, request, free_listing);
    return begin_slice(list);
}

static enum vor_next reply_list(struct listing *list)
{
    char cursor[32];

    vor_json_end_array(&list->text);
    vor_json_put_array(&list->text, "links");
    put_list_link(list, "self", NULL);
    (void)snprintf(cursor, sizeof cursor, "%lld", (long long)list->filter.before_seq);
    if (list->more)
        put_list_link(list, "next", cursor);
    vor_json_end_array(&list->text);
    vor_json_end_object(&list->text);
    vor_reply_header(list->request, "Cache-Control", "no-store");
    return vor_reply_json(list->request, 200, &list->text);
}

enum vor_next vor_handle_jobs(struct vor_request *request, enum vor_step step)
{
    struct listing *list = request->state;

    if (step == VOR_STEP_HEAD)
        return begin_list(request);
    if (!vor_deferred_is_done(&list->deferred) || vor_request_gone(request) ||
        vor_request_closing(request))
        return vor_problem_or_wait(request);
    if (list->status != VOR_OK)
        return vor_problem_error(request, &list->error, NULL);
    for (size_t i = 0; i < list->count; i++) {
        if (list->left == 0) {
            list->more = true;
            return reply_list(list);
        }
        list->left--;
        list->filter.before_seq = list->rows[i].seq;
        vor_job_write(list->request, &list->rows[i], &list->text);
    }
    return list->count == list->filter.limit ? begin_slice(list) : reply_list(list);
}
