#include "server/api/handlers/event_text.h"

#include "proto/sse.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/base/metrics.h"

#include <math.h>

/* How many steps a parameter allows; 0 where the process does not take it. */
static uint64_t steps_of(const struct vor_spec *spec, enum vor_parameter parameter, double steps)
{
    return vor_process_takes(spec->process, parameter) && steps > 0 ? (uint64_t)steps : 0;
}

/* maxIterations and maxPolish are older than stages: they mean something to a run that iterates and
 * polishes. */
static void write_progress(const struct vor_teller *teller, const struct vor_event *event,
                           struct vor_text *text)
{
    const struct vor_spec *spec = &teller->followed->row.spec;

    vor_json_begin_object(text);
    vor_json_put_string(text, "jobID", teller->followed->row.id.text);
    vor_json_put_u64(text, "attempt", event->attempt);
    vor_json_put_string(text, "stage", vor_stage_word(event->stage));
    vor_json_put_u64(text, "maxIterations",
                     steps_of(spec, VOR_PARAM_ITERATIONS, vor_spec_iterations(spec)));
    vor_json_put_u64(text, "maxPolish", steps_of(spec, VOR_PARAM_POLISH, vor_spec_polish(spec)));
    vor_json_members(text, &vor_record_members, &event->record);
    vor_json_put_i64(text, "progress", event->progress);
    vor_json_put_double(text, "eta", event->eta_seconds >= 0 ? event->eta_seconds : NAN);
    vor_json_end_object(text);
}

static void write_end(const struct vor_teller *teller, const struct vor_event *event,
                      struct vor_text *text)
{
    const struct vor_artefact_info *outputs = teller->followed->row.spec.process->outputs;
    const struct vor_uuid *id = &teller->followed->row.id;
    char url[VOR_URL_MAX];

    vor_json_begin_object(text);
    vor_json_put_string(text, "jobID", teller->followed->row.id.text);
    vor_json_put_string(text, "status", vor_job_status_word(event->status));
    if (event->status == VOR_JOB_SUCCESSFUL) {
        /* href and report are older than outputs, which has them all by name. */
        vor_json_put_string(text, "href",
                            vor_app_result_url(teller->request, id, outputs[0].name, url));
        if (vor_artefact_find(outputs, "report") != NULL)
            vor_json_put_string(text, "report",
                                vor_app_result_url(teller->request, id, "report", url));
        vor_json_put_object(text, "outputs");
        for (unsigned i = 0; outputs[i].name != NULL; i++)
            vor_json_put_string(text, outputs[i].name,
                                vor_app_result_url(teller->request, id, outputs[i].name, url));
        vor_json_end_object(text);
    } else
        vor_json_put_string(text, "href",
                            vor_app_job_url(teller->request, &teller->followed->row.id, "", url));
    vor_json_end_object(text);
}

static void write_data(const struct vor_teller *teller, const struct vor_event *event,
                       struct vor_text *text)
{
    struct vor_job_view view;

    switch (event->kind) {
    case VOR_EVENT_PROGRESS:
        write_progress(teller, event, text);
        return;
    case VOR_EVENT_END:
        write_end(teller, event, text);
        return;
    case VOR_EVENT_REPLACED:
        vor_json_begin_object(text);
        vor_json_put_string(text, "jobID", teller->followed->row.id.text);
        vor_json_put_u64(text, "attempt", event->attempt);
        vor_json_put_string(text, "reason",
                            event->stage == VOR_STAGE_QUEUED ? "daemon-restarted"
                                                             : "worker-restarted");
        vor_json_end_object(text);
        return;
    case VOR_EVENT_STATUS:
    case VOR_EVENT_KINDS:
        break;
    }
    /* Writes the job as it is now, but in the state that it had at the event. */
    vor_job_service_followed(teller->request->app->service, teller->followed, &view);
    if (view.status != event->status) {
        view.finished = 0;
        view.message[0] = '\0';
    }
    view.status = event->status;
    view.stage = event->stage;
    view.attempt = event->attempt;
    view.progress = event->progress;
    view.updated = event->time_ms;
    vor_job_write(teller->request, &view, text);
}

int vor_event_frame(const struct vor_teller *teller, const char *name, const char *id,
                    const struct vor_text *data, struct vor_text *out)
{
    if (data->failed)
        return 0;
    if (!teller->is_lines) {
        vor_sse_event(out, id, name, data->data, data->size);
        return !out->failed;
    }
    vor_json_begin_object(out);
    vor_json_put_string(out, "event", name);
    if (id != NULL)
        vor_json_put_string(out, "id", id);
    vor_json_key(out, "data");
    vor_json_raw(out, data->data, data->size);
    vor_json_end_object(out);
    vor_text_puts(out, "\n");
    return !out->failed;
}

int vor_event_tell(const struct vor_teller *teller, const struct vor_event *event, const char *id,
                   struct vor_text *out)
{
    struct vor_text data;
    int told;

    vor_text_init(&data, 0);
    write_data(teller, event, &data);
    told = vor_event_frame(teller, vor_event_word(event->kind), id, &data, out);
    vor_text_free(&data);
    return told;
}

int vor_event_tell_preview(const struct vor_teller *teller, const struct vor_preview_info *info,
                           size_t points, struct vor_text *out)
{
    const struct vor_uuid *id = &teller->followed->row.id;
    char url[VOR_URL_MAX], suffix[48];
    struct vor_text data;
    int told;

    (void)snprintf(suffix, sizeof suffix, "/preview?points=%zu", points);
    vor_text_init(&data, 0);
    vor_json_begin_object(&data);
    vor_json_put_string(&data, "jobID", id->text);
    vor_json_put_u64(&data, "iteration", info->iteration);
    vor_json_put_u64(&data, "polish", info->polish);
    vor_json_put_u64(&data, "points", vor_shown_count(info->points, points));
    vor_json_put_string(&data, "href", vor_app_job_url(teller->request, id, suffix, url));
    vor_json_end_object(&data);
    told = vor_event_frame(teller, "preview", NULL, &data, out);
    vor_text_free(&data);
    return told;
}

void vor_events_count_dropped(struct vor_position from, struct vor_position to, size_t sent)
{
    uint32_t begin = from.attempt == to.attempt && from.number <= to.number ? from.number : 0;

    if (to.number - begin > sent)
        vor_metric_add(VOR_METRIC_STREAM_DROPPED, (double)(to.number - begin - sent), NULL);
}

enum vor_next vor_events_reply_nothing(struct vor_request *request)
{
    vor_reply_bytes(request, 204, NULL, "", 0);
    return VOR_NEXT_REPLY;
}

void vor_events_reply_crowded(struct vor_request *request)
{
    enum { RETRY_MS = 10000 };
    struct vor_text text;

    vor_text_init(&text, 0);
    vor_sse_retry(&text, RETRY_MS);
    vor_reply_bytes(request, 200, "text/event-stream", text.data, text.size);
    vor_text_free(&text);
    request->reply.close = true;
}
