/* Where the points of a running job are now. */
#include "proto/codec.h"
#include "server/api/handlers/events_query.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"

#include <inttypes.h>
#include <stdio.h>

enum { CLOUD_BYTES = 1 << 20, FILE_BYTES = 2 << 20 }; /* of VOR_PREVIEW_POINTS_MAX points; 1.2 MB */

static enum vor_next reply_none(struct vor_request *request, const struct vor_uuid *id)
{
    return vor_problem_reply(
        request,
        &VOR_PROBLEM("result-not-available", .job_id = id->text,
                     .detail =
                         "the job has no preview: it is not running, or no client follows its "
                         "events with preview=N, or no point has moved since the last preview"));
}

static enum vor_next reply_cloud(struct vor_request *request, const struct vor_followed *followed,
                                 size_t most)
{
    const struct vor_format *ply = vor_format(VOR_FORMAT_PLY);
    const struct vor_write_options options = {.keep_order = 1};
    struct vor_preview_info info;
    struct vor_memory memory;
    struct vor_cloud cloud;
    struct vor_text text;
    struct vor_sink sink = {&text, vor_text_take};
    struct vor_error err;
    vor_status status;

    vor_memory_init(&memory, CLOUD_BYTES);
    vor_cloud_init(&cloud, &memory);
    vor_text_init(&text, FILE_BYTES);
    status = vor_job_service_mirror_preview(request->app->service, followed->job, &err);
    VOR_THEN(status, vor_preview_cloud(vor_job_preview(followed->job), most, &cloud, &info, &err));
    VOR_THEN(status, ply->write(&sink, &cloud, &options, &err));
    vor_cloud_free(&cloud);
    if (status == VOR_OK) {
        char etag[96];

        /* The same bytes have the same tag: those of one version, as many points of it, of one life
         * of the job. */
        (void)snprintf(etag, sizeof etag, "\"%u-%" PRIu64 "-%zu\"", followed->row.attempt,
                       info.version, vor_shown_count(info.points, most));
        vor_reply_header(request, "ETag", etag);
        vor_reply_header(request, "Cache-Control", "private, no-cache");
    }
    if (status == VOR_OK)
        return vor_app_reply(request, 200, ply->media_type, &text);
    vor_text_free(&text);
    return status == VOR_E_EMPTY ? reply_none(request, &followed->row.id)
                                 : vor_problem_error(request, &err, followed->row.id.text);
}

enum vor_next vor_handle_preview(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    size_t most = VOR_PREVIEW_POINTS_MAX;
    struct vor_followed followed;
    enum vor_job_outcome outcome;
    enum vor_next next;
    struct vor_error err;
    struct vor_uuid id;

    if (!vor_job_of_path(request, &id) || !vor_query_points(request, "points", &most))
        return VOR_NEXT_REPLY;
    outcome = vor_job_service_follow(request->app->service, &id, NULL, &followed, &err);
    if (outcome != VOR_DONE)
        next = vor_outcome_reply(request, outcome, &err, &id);
    else if (followed.job == NULL || vor_job_is_over(followed.job))
        next = reply_none(request, &id);
    else
        next = reply_cloud(request, &followed, most);
    if (outcome == VOR_DONE)
        vor_job_release(followed.job);
    return next;
}
