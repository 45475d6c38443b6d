#include "proto/codec.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"

/* There is no length to tell yet: a stream, whose reply to HEAD has none. */
static long no_bytes(VOR_UNUSED struct vor_request *request, VOR_UNUSED char *out,
                     VOR_UNUSED size_t size)
{
    return -1;
}

enum vor_next vor_converted_get(struct vor_request *request, const struct vor_job_view *view,
                                unsigned index, unsigned format, struct vor_converted *out)
{
    const char *name = view->spec.process->outputs[index].name;
    char blob[VOR_BLOB_NAME_MAX + 1];
    struct vor_here here = {.exists = false};
    enum vor_job_outcome outcome;
    struct vor_asker asker;
    enum vor_next next;
    struct vor_error err;

    out->fd = -1;
    if (!vor_blob_is_here(request, &view->id,
                          vor_blob_of_converted(name, vor_format(format)->name, blob), &here,
                          &next))
        return next;
    if (here.exists &&
        vor_converted_open(out, request->app->blobs, &view->id, name, format, &err) != VOR_OK)
        return vor_problem_error(request, &err, view->id.text);
    if (out->fd >= 0)
        return VOR_NEXT_REPLY;
    if (request->method == VOR_HEAD) {
        vor_reply_header(request, "Cache-Control", "private, no-cache");
        vor_reply_stream(request, 200, vor_format(format)->media_type, VOR_LENGTH_UNKNOWN,
                         no_bytes);
        return VOR_NEXT_REPLY;
    }
    asker = vor_asker_of(request);
    outcome = vor_convert(request->app->conversions, view, index, format, &asker, &err);
    if (outcome == VOR_DONE)
        return vor_problem_or_wait(request);
    vor_waker_drop(asker.ctx);
    if (outcome == VOR_FULL)
        return vor_problem_say(request, "too-many-conversions",
                               "too many results are being converted; try again later");
    if (outcome == VOR_FAILED && err.status == VOR_E_CANCELLED)
        outcome = VOR_DRAINING;
    return vor_outcome_reply(request, outcome, &err, &view->id);
}
