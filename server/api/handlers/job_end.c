/* Ending a job before its time: DELETE and stop. A dismissal waits for the disk, so a thread of the
 * service does it while the request is suspended. */
#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/http/deferred.h"

#include <stdlib.h>

struct dismissal {
    struct vor_deferred deferred; /* first */
    struct vor_dismissal work;
};

static void free_dismissal(struct vor_deferred *deferred)
{
    free(deferred);
}

/* On a thread of the job service. */
static void on_dismissed(struct vor_dismissal *work)
{
    vor_deferred_complete(work->ctx);
}

static enum vor_next reply_job(struct vor_request *request, int http,
                               const struct vor_job_view *view)
{
    struct vor_text text;

    vor_text_init(&text, 0);
    vor_job_write(request, view, &text);
    vor_reply_header(request, "Cache-Control", "no-store");
    return vor_reply_json(request, http, &text);
}

static enum vor_next begin(struct vor_request *request, int is_stop)
{
    struct dismissal *dismissal;
    struct vor_uuid id;

    if (!vor_job_of_path(request, &id))
        return VOR_NEXT_REPLY;
    if (vor_request_closing(request))
        return vor_outcome_reply(request, VOR_DRAINING, NULL, &id);
    dismissal = calloc(1, sizeof *dismissal);
    if (dismissal == NULL)
        return vor_problem_no_memory(request);
    dismissal->work = (struct vor_dismissal){.id = id,
                                             .caller = vor_auth_fairness_key(request),
                                             .why = "dismissed by the caller",
                                             .is_stop = is_stop,
                                             .done = on_dismissed,
                                             .ctx = &dismissal->deferred};
    vor_deferred_begin(&dismissal->deferred, request, free_dismissal);
    vor_deferred_retain(&dismissal->deferred);
    vor_job_service_dismiss_soon(request->app->service, &dismissal->work);
    return VOR_NEXT_STAY;
}

/* Until a thread of the job service has done it. */
static enum vor_next wait_for(struct vor_request *request, const char *ended)
{
    if (!vor_request_closing(request))
        return VOR_NEXT_STAY;
    return vor_problem_say(request, "draining",
                           "the daemon is shutting down; after the next start of the daemon, the "
                           "status of the job shows whether it is %s",
                           ended);
}

enum vor_next vor_handle_dismiss(struct vor_request *request, enum vor_step step)
{
    const struct dismissal *dismissal = request->state;

    if (step == VOR_STEP_HEAD)
        return begin(request, 0);
    if (!vor_deferred_is_done(&dismissal->deferred))
        return wait_for(request, "dismissed");
    if (dismissal->work.outcome != VOR_DONE)
        return vor_outcome_reply(request, dismissal->work.outcome, &dismissal->work.error,
                                 &dismissal->work.id);
    return reply_job(request, 200, &dismissal->work.view);
}

enum vor_next vor_handle_stop(struct vor_request *request, enum vor_step step)
{
    const struct dismissal *asked = request->state;
    struct vor_job_view view;
    struct vor_error err;
    enum vor_job_outcome outcome;

    if (step != VOR_STEP_HEAD && !vor_deferred_is_done(&asked->deferred))
        return wait_for(request, "stopped");
    if (!vor_job_look_up(request, &view))
        return VOR_NEXT_REPLY;
    if (step == VOR_STEP_HEAD) {
        outcome = vor_job_service_stop(request->app->service, &view.id, &err);
        if (outcome == VOR_CONFLICT && view.status == VOR_JOB_RUNNING &&
            vor_store_is_shared(request->app->store))
            return begin(request, 1);
    } else {
        outcome = asked->work.outcome;
        err = asked->work.error;
    }
    if (outcome == VOR_CONFLICT)
        return vor_problem_reply(
            request, &VOR_PROBLEM("not-running", .detail = "only a running job can be stopped",
                                  .job_id = view.id.text));
    if (outcome != VOR_DONE)
        return vor_outcome_reply(request, outcome, &err, &view.id);
    if (!vor_job_look_up(request, &view)) /* its message says now that it stops */
        return VOR_NEXT_REPLY;
    return reply_job(request, 202, &view);
}
