#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* Reads the {jobID} of the path, whosever the job is. */
static bool read_id(struct vor_app *app, struct vor_request *request, struct vor_uuid *out)
{
    const char *segment;
    size_t length = vor_path_segment(vor_request_path(request), 2, &segment);

    if (vor_uuid_parse(out, segment, length)) {
        vor_request_set_job(request, out->text);
        return true;
    }
    vor_problem_say(app, request, "no-such-job", "there is no job %.*s",
                    (int)(length < 60 ? length : 60), segment);
    return false;
}

bool vor_job_of_path(struct vor_app *app, struct vor_request *request, struct vor_uuid *out)
{
    struct vor_job_view view;

    if (vor_auth_tenant(request) == NULL)
        return read_id(app, request, out);
    if (!vor_job_look_up(app, request, &view))
        return false;
    *out = view.id;
    return true;
}

enum vor_next vor_outcome_reply(struct vor_app *app, struct vor_request *request,
                                enum vor_job_outcome outcome, const struct vor_error *err,
                                const struct vor_uuid *id)
{
    struct vor_problem full = VOR_PROBLEM_INIT("queue-full");
    struct vor_worker_load load;

    switch (outcome) {
    case VOR_UNKNOWN:
        return vor_problem_say(app, request, "no-such-job", "there is no job %s",
                               id != NULL ? id->text : "");
    case VOR_FULL:
        vor_worker_load(app->worker, &load);
        full.detail = "too many jobs, or bytes of decoded inputs, are waiting; try again later";
        full.queue_depth = (int64_t)load.waiting;
        return vor_problem_reply(app, request, &full);
    case VOR_CROWDED:
        return vor_problem_say(app, request, "too-many-jobs", "%s", err->message);
    case VOR_OVER_BYTES:
        return vor_problem_say(app, request, "too-much-stored", "%s", err->message);
    case VOR_DRAINING:
        return vor_problem_say(app, request, "draining", "the daemon is shutting down");
    case VOR_CONFLICT:
        return vor_problem_say(app, request, "not-running", "the job is not running");
    case VOR_FAILED:
    case VOR_DONE:
        break;
    }
    return vor_problem_error(app, request, err, NULL);
}

bool vor_job_look_up(struct vor_app *app, struct vor_request *request, struct vor_job_view *out)
{
    struct vor_error err;
    struct vor_uuid id;
    enum vor_job_outcome outcome;

    if (!read_id(app, request, &id))
        return false;
    outcome = vor_worker_get_of(app->worker, &id, vor_auth_tenant(request), out, &err);
    if (outcome == VOR_DONE)
        return true;
    vor_outcome_reply(app, request, outcome, &err, &id);
    return false;
}

/* Jobs of a list that are written at a step, some 4 ms of a core: between two steps of a long list
 * the thread serves others. With 10,000 jobs at once, /livez waited 10 s beside four such lists. */
enum { SLICE = 50 };

/* The list while it is written. It asks for one job more than the page has: then there is a next
 * page. */
struct listing {
    struct vor_app *app;
    struct vor_request *request;
    struct vor_job_filter filter; /* of the next slice */
    struct vor_text text;
    size_t left; /* of the page */
    size_t seen; /* of this slice */
    bool more;
};

static void free_listing(void *state)
{
    struct listing *list = state;

    vor_text_free(&list->text);
    free(list);
}

static int list_one(void *ctx, const struct vor_job_view *view)
{
    struct listing *list = ctx;

    list->seen++;
    if (list->left == 0) {
        list->more = true;
        return 0;
    }
    list->left--;
    list->filter.before_seq = view->seq;
    vor_job_write(list->app, list->request, view, &list->text);
    return 1;
}

/* *over: the page is full, or there are no more jobs. */
static vor_status list_slice(struct listing *list, bool *over, struct vor_error *err)
{
    vor_status status;

    list->seen = 0;
    list->filter.limit = list->left < SLICE ? list->left + 1 : SLICE;
    status = vor_worker_list(list->app->worker, &list->filter, list_one, list, err);
    *over = list->more || list->seen < list->filter.limit;
    return status;
}

/* Writes a value of a query, with escapes where they are needed. */
static void put_escaped(struct vor_text *text, const char *value)
{
    for (; *value != '\0'; value++) {
        unsigned char c = (unsigned char)*value;

        if (isalnum(c) || strchr("-._~,", c) != NULL)
            vor_text_add(text, value, 1);
        else
            vor_text_printf(text, "%%%02X", c);
    }
}

/* Writes a link to /v1/jobs with the query of this request and another cursor. */
static void put_list_link(struct listing *list, const char *rel, const char *cursor)
{
    char base[VOR_URL_MAX];
    struct vor_link link = {rel, "application/json", NULL, NULL, -1};
    struct vor_text url;
    const char *name;
    char mark = '?';

    vor_text_init(&url, 0);
    vor_text_puts(&url, vor_app_url(list->app, list->request, "/v1/jobs", base));
    for (unsigned i = 0; (name = vor_request_query_name(list->request, i)) != NULL; i++) {
        if (cursor != NULL && strcmp(name, "cursor") == 0)
            continue;
        vor_text_printf(&url, "%c%s=", mark, name);
        put_escaped(&url, vor_request_query_value(list->request, i));
        mark = '&';
    }
    if (cursor != NULL)
        vor_text_printf(&url, "%ccursor=%s", mark, cursor);
    link.href = url.data;
    vor_json_begin_object(&list->text);
    vor_json_put_string(&list->text, "rel", link.rel);
    vor_json_put_string(&list->text, "type", link.type);
    vor_json_put_string(&list->text, "href", link.href);
    vor_json_end_object(&list->text);
    vor_text_free(&url);
}

/* NULL after a problem has been replied. */
static struct listing *begin_list(struct vor_app *app, struct vor_request *request)
{
    struct listing *list = calloc(1, sizeof *list);
    struct vor_error err;

    if (list == NULL) {
        (void)vor_fail(&err, VOR_E_NOMEM, "no memory for a request");
        (void)vor_problem_error(app, request, &err, NULL);
        return NULL;
    }
    *list = (struct listing){.app = app, .request = request};
    vor_text_init(&list->text, 0);
    if (!vor_job_filter_read(app, request, &list->filter)) {
        free_listing(list);
        return NULL;
    }
    list->filter.tenant = vor_auth_tenant(request);
    list->left = list->filter.limit;
    vor_json_begin_object(&list->text);
    vor_json_key(&list->text, "jobs");
    vor_json_begin_array(&list->text);
    vor_request_set_state(request, list, free_listing);
    return list;
}

static enum vor_next reply_list(struct listing *list)
{
    char cursor[32];

    vor_json_end_array(&list->text);
    vor_json_key(&list->text, "links");
    vor_json_begin_array(&list->text);
    put_list_link(list, "self", NULL);
    (void)snprintf(cursor, sizeof cursor, "%lld", (long long)list->filter.before_seq);
    if (list->more)
        put_list_link(list, "next", cursor);
    vor_json_end_array(&list->text);
    vor_json_end_object(&list->text);
    vor_text_puts(&list->text, "\n");
    vor_reply_header(list->request, "Cache-Control", "no-store");
    return vor_app_reply(list->app, list->request, 200, "application/json", &list->text);
}

enum vor_next vor_handle_jobs(void *ctx, struct vor_request *request, enum vor_step step)
{
    struct listing *list =
        step == VOR_STEP_HEAD ? begin_list(ctx, request) : vor_request_state(request);
    struct vor_error err;
    bool over;

    if (list == NULL)
        return VOR_NEXT_REPLY;
    if (vor_request_gone(request))
        return vor_problem_say(ctx, request, "client-closed", "the client disconnected");
    if (step != VOR_STEP_HEAD && vor_request_closing(request))
        return vor_problem_say(ctx, request, "draining", "the daemon is shutting down");
    if (list_slice(list, &over, &err) != VOR_OK)
        return vor_problem_error(ctx, request, &err, NULL);
    if (over)
        return reply_list(list);
    vor_request_wake_soon(request);
    return VOR_NEXT_WAIT;
}
