#include "server/api/handlers/converted.h"

#include "proto/codec.h"
#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"

#include <stdlib.h>

/* The state of a request that waits for a conversion. */
struct wait {
    struct vor_conversion *conversion; /* NULL before it has begun */
    struct vor_conversion_waiter waiter;
    struct vor_waker *waker;
};

static void wake(void *ctx)
{
    vor_waker_wake(ctx);
}

static void release(void *state)
{
    struct wait *wait = state;

    if (wait->conversion != NULL)
        vor_conversion_leave(wait->conversion, &wait->waiter);
    vor_waker_drop(wait->waker);
    free(wait);
}

/* There is no length to tell yet: a stream, whose reply to HEAD has none. */
static long no_bytes(void *ctx, struct vor_request *request, char *out, size_t size)
{
    (void)ctx;
    (void)request;
    (void)out;
    (void)size;
    return -1;
}

/* True when the conversion that a request waits for is over, and went well. Else *next is what the
 * handler returns. */
static bool is_made(struct vor_app *app, struct vor_request *request,
                    const struct vor_job_view *view, enum vor_next *next)
{
    struct wait *wait = vor_request_state(request);
    struct vor_error err;
    vor_status status;

    if (!vor_conversion_over(wait->conversion, &status, &err)) {
        *next = vor_problem_or_wait(app, request);
        return false;
    }
    if (status != VOR_OK)
        *next = status == VOR_E_CANCELLED
                    ? vor_problem_say(app, request, "draining", "the daemon is shutting down")
                    : vor_problem_error(app, request, &err, view->id.text);
    return status == VOR_OK;
}

enum vor_next vor_converted_get(struct vor_app *app, struct vor_request *request,
                                const struct vor_job_view *view, unsigned index, unsigned format,
                                struct vor_converted *out)
{
    bool has_waited = vor_request_state(request) != NULL;
    const char *name = view->spec.process->outputs[index].name;
    char blob[VOR_BLOB_NAME_MAX + 1];
    struct vor_here here = {.may_flow = false};
    enum vor_next next;
    struct vor_error err;

    out->fd = -1;
    if ((has_waited && !is_made(app, request, view, &next)) ||
        !vor_blob_is_here(app, request, &view->id,
                          vor_blob_of_converted(name, vor_format(format)->name, blob), &here,
                          &next))
        return next;
    if (here.exists && vor_converted_open(out, app->blobs, &view->id, name, format, &err) != VOR_OK)
        return vor_problem_error(app, request, &err, view->id.text);
    if (out->fd >= 0)
        return VOR_NEXT_REPLY;
    if (has_waited) /* the job went meanwhile */
        return vor_problem_say(app, request, "result-not-available", "the job was deleted");
    if (vor_request_method(request) != VOR_HEAD) {
        struct wait *wait = calloc(1, sizeof *wait);
        enum vor_job_outcome outcome;

        if (wait == NULL)
            return vor_problem_no_memory(app, request);
        wait->waker = vor_request_waker(request);
        wait->waiter = (struct vor_conversion_waiter){
            .wake = wake, .ctx = wait->waker, .caller = vor_auth_fairness_key(request)};
        vor_request_set_state(request, wait, release);
        outcome = vor_conversion_begin(&wait->conversion, app->conversions, view, index, format,
                                       &wait->waiter, &err);
        if (outcome == VOR_FULL)
            return vor_problem_say(app, request, "too-many-conversions",
                                   "too many results are being converted; try again later");
        if (outcome != VOR_DONE)
            return vor_outcome_reply(app, request, outcome, &err, &view->id);
        return VOR_NEXT_WAIT;
    }
    vor_reply_header(request, "Cache-Control", "private, no-cache");
    vor_reply_stream(request, 200, vor_format(format)->media_type, VOR_LENGTH_UNKNOWN, no_bytes,
                     NULL);
    return VOR_NEXT_REPLY;
}
