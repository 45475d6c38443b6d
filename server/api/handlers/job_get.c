/* GET of a job: its statusInfo, or 304 to who has it already. With "Prefer: wait=N" the 304 waits
 * for a change: a long poll. */
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/base/clock.h"
#include "server/base/digest.h"

#include <stdio.h>
#include <stdlib.h>

/* The state of a request that waits for a change. */
struct poll {
    double seconds, deadline;
    struct vor_waker *waker;
    struct vor_job *job; /* NULL: it is over */
    struct vor_subscriber subscriber;
};

static void on_event(void *ctx, VOR_UNUSED enum vor_event_kind kind)
{
    vor_waker_wake(ctx);
}

static void release(void *state)
{
    struct poll *poll = state;

    vor_job_unsubscribe(poll->job, &poll->subscriber);
    vor_job_release(poll->job);
    vor_waker_drop(poll->waker);
    free(poll);
}

/* Listens to the job's events from now on; false after a problem has been replied. */
static bool begin_poll(struct vor_request *request, double seconds)
{
    struct vor_followed followed;
    struct vor_error err;
    struct vor_uuid id;
    struct poll *poll;
    enum vor_job_outcome outcome;

    if (!vor_job_of_path(request, &id))
        return false;
    poll = calloc(1, sizeof *poll);
    outcome = poll != NULL
                  ? vor_job_service_follow(request->app->service, &id, NULL, &followed, &err)
                  : VOR_FAILED;
    if (outcome != VOR_DONE) {
        if (poll == NULL)
            (void)vor_fail(&err, VOR_E_NOMEM, "a request");
        free(poll);
        return vor_outcome_reply(request, outcome, &err, &id);
    }
    poll->seconds = seconds;
    poll->deadline = vor_clock_seconds() + seconds;
    poll->job = followed.job;
    poll->waker = vor_waker_hold(request->waker);
    poll->subscriber = (struct vor_subscriber){.wake = on_event, .ctx = poll->waker};
    vor_job_subscribe(poll->job, &poll->subscriber);
    vor_request_set_state(request, poll, release);
    return true;
}

/* True when the request should wait on; nothing has changed yet. */
static bool waits_on(struct vor_request *request, const struct vor_job_view *view)
{
    struct poll *poll = request->state;
    double left = poll != NULL ? poll->deadline - vor_clock_seconds() : 0;

    if (left <= 0 || vor_job_status_over(view->status) || vor_request_gone(request) ||
        vor_request_closing(request))
        return false;
    vor_request_wake_after(request, left);
    return true;
}

enum vor_next vor_handle_job(struct vor_request *request, enum vor_step step)
{
    struct vor_preferences preferences;
    struct vor_job_view view;
    const struct poll *poll;
    char etag[VOR_ETAG_SIZE] = "", applied[32];
    struct vor_text text;

    vor_prefer_read(request, &preferences);
    if (!vor_job_look_up(request, &view))
        return VOR_NEXT_REPLY;
    if (step == VOR_STEP_HEAD && preferences.wait_seconds > 0 &&
        vor_request_header(request, "If-None-Match") != NULL &&
        !vor_job_status_over(view.status) && /* what is over does not change */
        (!begin_poll(request, preferences.wait_seconds) || !vor_job_look_up(request, &view)))
        return VOR_NEXT_REPLY;
    if (view.expired)
        return vor_result_missing(request, &view);
    poll = request->state;
    vor_text_init(&text, 0);
    vor_job_write(request, &view, &text);
    vor_text_puts(&text, "\n");
    if (vor_text_status(&text, NULL) == VOR_OK)
        vor_digest_etag(text.data, text.size, etag);
    if (etag[0] != '\0' && vor_request_condition(request, etag) == 304 &&
        waits_on(request, &view)) {
        vor_text_free(&text);
        return VOR_NEXT_WAIT;
    }
    if (poll != NULL) {
        (void)snprintf(applied, sizeof applied, "wait=%.0f", poll->seconds);
        vor_reply_header(request, "Preference-Applied", applied);
    }
    vor_reply_header(request, "ETag", etag[0] != '\0' ? etag : NULL);
    vor_reply_header(request, "Cache-Control", "no-cache");
    return vor_app_reply(request, 200, "application/json", &text);
}
